// A rigid thing that moves: where it is, how it is turned, and how fast.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace stevedore::world {

/// World: NED (north, east, down), origin at take-off, metres. Local axes are the thing's own (see its
/// struct).
struct Rigid {
  Eigen::Vector3d position_ned_m = Eigen::Vector3d::Zero();  ///< of the local origin
  Eigen::Quaterniond ned_from_local = Eigen::Quaterniond::Identity();
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d angular_velocity_ned_radps = Eigen::Vector3d::Zero();

  [[nodiscard]] Eigen::Vector3d to_ned(const Eigen::Vector3d& local_m) const {
    return position_ned_m + ned_from_local * local_m;
  }
  [[nodiscard]] Eigen::Vector3d to_local(const Eigen::Vector3d& ned_m) const {
    return ned_from_local.conjugate() * (ned_m - position_ned_m);
  }
  /// Velocity of a point that is fixed to the thing.
  [[nodiscard]] Eigen::Vector3d velocity_at(const Eigen::Vector3d& ned_m) const {
    return velocity_ned_mps + angular_velocity_ned_radps.cross(ned_m - position_ned_m);
  }
};

}  // namespace stevedore::world
