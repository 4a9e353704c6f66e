// Single views of the competition, each of another scenery, height, light and sea: what `scenes` makes
// pictures of.
#pragma once

#include <cstdint>
#include <vector>

#include "geometry/camera_model.hpp"
#include "sim_proc/world/scene.hpp"

namespace stevedore {

/// What all stills of one run share: the camera as told and as it really is.
struct StillCamera {
  CameraModel told;
  CameraModel real;
  double circle_radius_m = 0.5;  ///< as painted
};

/// exact: real is as told. Else it differs as on a real aircraft: focal length 0.3 %, principal point 2 px at
/// 640 pixels of width, circle radius 0.5 % (one standard deviation each).
StillCamera draw_still_camera(const CameraModel& told, std::uint64_t seed, bool exact);

struct StillCircle {
  int platform = 0;  ///< 0, 1; 2: the take-off pad
  int slot = 0;
  bool occupied = false;  ///< a bucket's base has its centre in it
  Eigen::Vector3d center_ned_m;
  Eigen::Vector3d normal_ned;
};

struct StillCargo {
  int index = 0;
  int platform = -1;  ///< -1: on the hook
  int slot = -1;      ///< -1: in no circle
};

struct Still {
  world::Scene scene;
  int sea_state = 0;
  double height_m = 0;  ///< of the camera over the nearest platform's deck plane
  std::vector<StillCircle> circles;
  std::vector<StillCargo> cargoes;  ///< in the order of scene.buckets
  double circle_radius_m = 0.5;
};

/// The still of that number; it depends on seed, number and camera alone.
Still draw_still(const StillCamera& camera, std::uint64_t seed, int number);

}  // namespace stevedore
