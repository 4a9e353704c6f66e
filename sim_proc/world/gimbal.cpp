#include "sim_proc/world/gimbal.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stevedore::world {

/// The step of x'' + 2 d w x' + w^2 x = 0, in closed form: 15 Hz is too fast to be integrated at 5 ms.
Gimbal::Gimbal(double step_s) : step_s_(step_s) {
  const double w_radps = 2 * std::numbers::pi * bandwidth_hz;
  const double decay_radps = damping * w_radps, swing_radps = w_radps * std::sqrt(1 - damping * damping);
  const double fade = std::exp(-decay_radps * step_s), c = std::cos(swing_radps * step_s),
               s = std::sin(swing_radps * step_s) / swing_radps;
  angle_from_angle_ = fade * (c + decay_radps * s);
  angle_from_rate_ = fade * s;
  rate_from_angle_ = -fade * w_radps * w_radps * s;
  rate_from_rate_ = fade * (c - decay_radps * s);
}

void Gimbal::step() {
  step_joint(command_.roll_rad, angles_.roll_rad, rates_.roll_rad);
  step_joint(command_.pitch_rad, angles_.pitch_rad, rates_.pitch_rad);
}

void Gimbal::step_joint(double command_rad, double& angle_rad, double& rate_radps) const {
  const double wanted_rad = std::clamp(command_rad, -limit_rad, limit_rad);
  const double off_rad = angle_rad - wanted_rad;
  const double free_rad = wanted_rad + angle_from_angle_ * off_rad + angle_from_rate_ * rate_radps;
  const double free_radps = rate_from_angle_ * off_rad + rate_from_rate_ * rate_radps;
  const double travel_rad = max_rate_radps * step_s_;
  const double next_rad = std::clamp(free_rad, angle_rad - travel_rad, angle_rad + travel_rad);
  rate_radps = std::clamp(free_radps, -max_rate_radps, max_rate_radps);
  angle_rad = std::clamp(next_rad, -limit_rad, limit_rad);
  if (angle_rad != next_rad) rate_radps = 0;  // against the stop
}

bool Gimbal::at_limit() const {
  return std::abs(angles_.roll_rad) >= limit_rad || std::abs(angles_.pitch_rad) >= limit_rad;
}

}  // namespace stevedore::world
