// Where things sit on the aircraft.
#pragma once

#include <Eigen/Core>

namespace stevedore::world {

/// Body frame (forward, right, down), as the pipeline is told; the world's own differ by draws of 2 cm.
struct LeverArms {
  Eigen::Vector3d camera_body_m{0.80, 0, 0.25};
  Eigen::Vector3d hook_body_m{0, 0, 0.35};  ///< where the rope begins
  Eigen::Vector3d altimeter_body_m{-0.5, 0, 0.25};
  double rope_m = 0.8;
};

}  // namespace stevedore::world
