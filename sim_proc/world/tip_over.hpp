// Whether a bucket that touches down stays on its base.
#pragma once

#include <Eigen/Core>

#include "sim_proc/world/scene.hpp"

namespace stevedore::world {

/// How a bucket meets a floor: all in one frame, velocities relative to the floor.
struct Touchdown {
  Eigen::Vector3d floor_up;      ///< unit
  Eigen::Vector3d gravity_down;  ///< unit
  Eigen::Vector3d axis;          ///< unit, from base to rim
  Eigen::Vector3d velocity_mps;  ///< of the centre of mass
  Eigen::Vector3d spin_radps;
};

struct Landing {
  bool stands = true;
  Eigen::Vector3d falls_to = Eigen::Vector3d::Zero();  ///< if not: unit, along the floor
};

/// Mass is spread evenly: its centre is half way up, and about it, per kilogram, inertia is R^2/2 + H^2/12
/// (thin wall, across the axis).
double center_height_m(const Bucket& bucket);
double inertia_m2(const Bucket& bucket);

/// The lowest edge meets the floor, sticks (no bounce, no sliding: angular momentum about it is kept), and
/// the bucket turns about it. Away from upright it tips when its energy takes the centre of mass over the
/// edge, which is how Ishiyama (1982) judges rigid bodies. Back towards upright it slaps down flat and goes
/// on about the edge opposite with what angular momentum is left: the rocking block of Housner (1963).
Landing land(const Bucket& bucket, const Touchdown& touchdown);

}  // namespace stevedore::world
