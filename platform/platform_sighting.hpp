// What comes in: one frame's circles and cargoes, and what platforms say of themselves.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

namespace stevedore {

/// One of the circles that an ellipse may be the image of. Camera frame: x right, y down, z forward.
struct SeenCircle {
  Eigen::Vector3d center_camera_m;
  Eigen::Vector3d normal_camera;  ///< unit, towards the camera
  Eigen::Matrix3d covariance_m2;
  double normal_variance_rad2 = 0;  ///< mean of its two directions
  double probability = 1;           ///< of being the right one
};

/// A painted circle, with the poses that its image allows.
struct CircleSighting {
  std::vector<SeenCircle> solutions;
  double radius_m = 0.5;
  std::optional<bool> occupied;  ///< a cargo stands in it; nothing: can't tell
};

/// A cargo's rim.
struct CargoSighting {
  Eigen::Vector3d center_camera_m;
  Eigen::Matrix3d covariance_m2;
  double radius_m = 0.16;
};

struct FrameSighting {
  std::int64_t utime = 0;
  Eigen::Matrix3d body_from_camera;
  std::vector<CircleSighting> circles;
  std::vector<CargoSighting> cargoes;
};

/// A platform by its own GPS and INS: metres off. NED.
struct PlatformReport {
  std::int64_t utime = 0;
  int platform = 0;
  Eigen::Vector3d position_ned_m;
  Eigen::Vector3d velocity_ned_mps;
  double heading_rad = 0;
};

}  // namespace stevedore
