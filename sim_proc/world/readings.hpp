// What the sensors say. time_s is when it was taken, by the aircraft's own clock.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>
#include <vector>

#include "geometry/attitude.hpp"

namespace stevedore::world {

struct VehicleReading {
  double time_s = 0;
  Eigen::Vector3d position_ned_m;
  Eigen::Vector3d velocity_ned_mps;
  Eigen::Quaterniond ned_from_body;
  Eigen::Vector3d angular_rate_body_radps;
  double position_sigma_m = 0;  ///< as the sensor claims
  double velocity_sigma_mps = 0;
  double attitude_sigma_rad = 0;
};

struct GimbalReading {
  double time_s = 0;
  GimbalAngles angles;
  bool at_limit = false;
};

struct AltimeterReading {
  double time_s = 0;
  std::optional<double> range_m;  ///< along the beam; nothing: a drop-out
  double sigma_m = 0;
};

struct HookReading {
  double time_s = 0;
  double load_n = 0;
  bool closed = false;
};

struct PlatformReading {
  double time_s = 0;
  int platform = 0;
  Eigen::Vector3d position_ned_m;
  Eigen::Vector3d velocity_ned_mps;
  double heading_rad = 0;
  double position_sigma_m = 0;
};

struct AutopilotReading {
  double time_s = 0;
  bool landed = false;
  double battery_share = 1;
  double battery_v = 0;
};

/// Those that fell due in the last step.
struct Readings {
  std::optional<VehicleReading> vehicle;      // 50 Hz
  std::optional<GimbalReading> gimbal;        // 50 Hz
  std::optional<AltimeterReading> altimeter;  // 20 Hz
  std::optional<HookReading> hook;            // 10 Hz
  std::vector<PlatformReading> platforms;     // 2 Hz
  std::optional<AutopilotReading> autopilot;  // 2 Hz
};

}  // namespace stevedore::world
