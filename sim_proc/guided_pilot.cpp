#include "sim_proc/guided_pilot.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "sim_proc/world/aircraft.hpp"

namespace stevedore {
namespace {
constexpr double period_s = 0.02;
}

void GuidedPilot::hear(const world::VehicleReading& own) {
  own_ = own;
}

/// One step of the model, and what the aircraft does otherwise.
void GuidedPilot::observe() {
  constexpr double loop_radps = world::Aircraft::loop_radps, damping = world::Aircraft::loop_damping;
  constexpr double mean_over_s = 0.35;  // noise of 0.1 m/s at 50 Hz becomes 0.017, gusts last for seconds
  const Eigen::Vector3d jerk_mps3 = loop_radps * loop_radps * (commanded_mps_[next_] - model_velocity_mps_) -
                                    2 * damping * loop_radps * model_acceleration_mps2_;
  model_acceleration_mps2_ += jerk_mps3 * period_s;
  model_velocity_mps_ += model_acceleration_mps2_ * period_s;
  const Eigen::Vector3d other_mps = own_->velocity_ned_mps - model_velocity_mps_;
  disturbance_mps_ += period_s / mean_over_s * (other_mps - disturbance_mps_);
}

world::VelocityCommand GuidedPilot::fly(std::int64_t now_utime) {
  world::VelocityCommand command;
  const bool told = set_point_ && now_utime - set_point_->utime < silence_us;
  if (own_) observe();
  if (!told || !own_) {
    velocity_ned_mps_.setZero();
    commanded_mps_[next_] = velocity_ned_mps_;
    next_ = (next_ + 1) % delay_steps;
    return command;
  }
  const double age_s = static_cast<double>(now_utime - set_point_->utime) * 1e-6;
  const Eigen::Vector3d& pace_mps = set_point_->velocity_ned_mps;
  const Eigen::Vector3d error_m = set_point_->place_ned_m + age_s * pace_mps - own_->position_ned_m;
  if (error_m.norm() < integrated_within_m) {
    integral_mps_ += period_s * integral_per_s2 * error_m;
    integral_mps_ = integral_mps_.cwiseMax(-max_integral_mps).cwiseMin(max_integral_mps);
  }
  const Eigen::Vector3d own_mps = model_velocity_mps_ + disturbance_mps_;  // without the reading's noise
  Eigen::Vector3d wanted_mps = pace_mps + position_gain_per_s * error_m +
                               velocity_gain * (pace_mps - own_mps) -
                               acceleration_gain_s * model_acceleration_mps2_ + integral_mps_;
  const double fast_mps = wanted_mps.head<2>().norm();
  if (fast_mps > max_horizontal_mps) wanted_mps.head<2>() *= max_horizontal_mps / fast_mps;
  wanted_mps.z() = std::clamp(wanted_mps.z(), -max_vertical_mps, max_vertical_mps);
  Eigen::Vector3d change_mps = wanted_mps - velocity_ned_mps_;
  const double most_mps = max_acceleration_mps2 * period_s;
  if (change_mps.norm() > most_mps) change_mps *= most_mps / change_mps.norm();
  velocity_ned_mps_ += change_mps;
  // the model hears what is wanted, the aircraft what it takes to have that in the wind
  commanded_mps_[next_] = velocity_ned_mps_;
  next_ = (next_ + 1) % delay_steps;
  command.velocity_ned_mps = velocity_ned_mps_ - disturbance_mps_;

  const Eigen::Matrix3d axes = own_->ned_from_body.toRotationMatrix();
  const double heading_rad = std::atan2(axes(1, 0), axes(0, 0));
  const double turn_rad = std::remainder(set_point_->heading_rad - heading_rad, 2 * std::numbers::pi);
  command.yaw_rate_radps = std::clamp(yaw_gain_per_s * turn_rad, -max_yaw_rate_radps, max_yaw_rate_radps);
  return command;
}

}  // namespace stevedore
