// The autopilot's guided mode: flies to MISSION's set-points by the aircraft's own readings.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>

#include "sim_proc/world/readings.hpp"
#include "sim_proc/world/velocity_command.hpp"

namespace stevedore {

/// Where to be and how fast to go there, from the time of the word on.
struct SetPoint {
  std::int64_t utime = 0;
  Eigen::Vector3d place_ned_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();
  double heading_rad = 0;
};

/// Feedback of position, velocity and acceleration around the velocity loop, with the limits of a careful
/// pilot, and an observer of what disturbs it (and an integral for what the readings' own lasting errors
/// leave): how the aircraft's velocity differs from that of a model of its loop under the same commands
/// (Ohnishi, 1987) is a gust, and taken from the next command. It knows nothing but what MISSION says and
/// what VEHICLE_STATE says.
class GuidedPilot {
 public:
  GuidedPilot() { commanded_mps_.fill(Eigen::Vector3d::Zero()); }

  /// With the velocity loop's s^2 + 3.5 s + 6.25 they put all three poles at -2.25 rad/s, close to the loop's
  /// own.
  static constexpr double position_gain_per_s = 1.82, velocity_gain = 1.43, acceleration_gain_s = 0.52;
  static constexpr double integral_per_s2 = 0.3;  ///< a sixth of the gain a second: slower than the loop
  static constexpr double integrated_within_m = 1, max_integral_mps = 0.5;
  static constexpr double max_horizontal_mps = 3, max_vertical_mps = 1;
  static constexpr double max_acceleration_mps2 = 1.5;  ///< half of what the aircraft can
  static constexpr double yaw_gain_per_s = 1, max_yaw_rate_radps = 0.6;
  /// A mission that is silent for longer is not there: the aircraft hovers.
  static constexpr std::int64_t silence_us = 1'000'000;

  /// Nothing: hover.
  void hear(const std::optional<SetPoint>& set_point) { set_point_ = set_point; }
  void hear(const world::VehicleReading& own);

  /// 50 times a second. now_utime: in the time of the messages.
  world::VelocityCommand fly(std::int64_t now_utime);

 private:
  std::optional<SetPoint> set_point_;
  std::optional<world::VehicleReading> own_;
  static constexpr std::size_t delay_steps = 5;  ///< 0.1 s, from command to loop
  void observe();

  Eigen::Vector3d velocity_ned_mps_ = Eigen::Vector3d::Zero();  ///< wanted last
  Eigen::Vector3d integral_mps_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d disturbance_mps_ = Eigen::Vector3d::Zero();
  std::array<Eigen::Vector3d, delay_steps> commanded_mps_;  ///< on their way
  std::size_t next_ = 0;
  Eigen::Vector3d model_velocity_mps_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d model_acceleration_mps2_ = Eigen::Vector3d::Zero();
};

}  // namespace stevedore
