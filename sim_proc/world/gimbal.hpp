// The pan-tilt that carries the camera.
#pragma once

#include "geometry/attitude.hpp"

namespace stevedore::world {

/// Each joint follows its command as a second-order system of 15 Hz bandwidth, no faster than 120 deg/s,
/// within +-30 deg.
class Gimbal {
 public:
  static constexpr double bandwidth_hz = 15;
  static constexpr double damping = 0.7;  ///< of its servo; the -3 dB frequency is then the natural one
  static constexpr double max_rate_radps = 2.0943951023931953;  // 120 deg/s
  static constexpr double limit_rad = 0.52359877559829887;      // 30 deg

  explicit Gimbal(double step_s);

  void command(const GimbalAngles& angles) { command_ = angles; }
  void step();

  [[nodiscard]] const GimbalAngles& angles() const { return angles_; }
  [[nodiscard]] const GimbalAngles& rates_radps() const { return rates_; }  ///< per second
  [[nodiscard]] bool at_limit() const;

 private:
  void step_joint(double command_rad, double& angle_rad, double& rate_radps) const;

  double step_s_;
  double angle_from_angle_, angle_from_rate_, rate_from_angle_, rate_from_rate_;  ///< of one exact step
  GimbalAngles command_, angles_, rates_;
};

}  // namespace stevedore::world
