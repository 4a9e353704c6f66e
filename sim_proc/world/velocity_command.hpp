// What the autopilot's velocity loop is told.
#pragma once

#include <Eigen/Core>

namespace stevedore::world {

struct VelocityCommand {
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();
  double yaw_rate_radps = 0;  ///< clockwise seen from above
};

}  // namespace stevedore::world
