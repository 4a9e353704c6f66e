#include "mission_proc/hanging.hpp"

#include <algorithm>
#include <cmath>

namespace stevedore {
namespace {

constexpr double gravity_mps2 = 9.81;
/// A rope of a metre swings on for a quarter of a minute; a little less keeps what the readings' noise stirs
/// up (0.1 m/s at 50 Hz) at some centimetres.
constexpr double dies_out_s = 10;
/// Lean tells changes of velocity, readings of velocity what lean misses: gusts, which last for a second.
constexpr double corrected_in_s = 1;

}  // namespace

void Hanging::hear(const VehicleSample& vehicle, bool loaded) {
  constexpr double mean_over_s = 3;  // two swings of the rope, a few corrections of the pilot's
  constexpr std::int64_t another_stream_us = 1'000'000;
  constexpr std::int64_t gap_us = 200'000;  // a tenth of a swing: not bridged by one step
  const std::int64_t passed_us = vehicle.utime - utime_;
  const bool first = utime_ == 0 || std::abs(passed_us) > another_stream_us;
  if (!first && passed_us < 0) return;  // late
  const bool begins_anew = first || passed_us > gap_us;
  const double passed_s = first ? mean_over_s : static_cast<double>(passed_us) * 1e-6;
  const double share = std::clamp(passed_s / mean_over_s, 0.0, 1.0);
  const Eigen::Matrix3d axes = vehicle.ned_from_body.toRotationMatrix();
  mean_down_ned_ = (mean_down_ned_ + share * (axes.col(2) - mean_down_ned_)).normalized();
  heading_rad_ = std::atan2(axes(1, 0), axes(0, 0));
  utime_ = vehicle.utime;
  if (begins_anew || loaded != loaded_) {
    loaded_ = loaded;
    top_mps_ = weight_mps_ = vehicle.velocity_ned_mps.head<2>();
    weight_m_ = resting_m();
    down_ = axes.col(2).head<2>();
    return;
  }
  const Eigen::Vector2d lean =
      axes.col(2).head<2>() / axes(2, 2) - mean_down_ned_.head<2>() / mean_down_ned_.z();
  weight_m_ -= settings_.hook_down_m * (axes.col(2).head<2>() - down_);  // as the aircraft tilts
  down_ = axes.col(2).head<2>();
  swing_on(vehicle, lean, passed_s);
}

void Hanging::swing_on(const VehicleSample& vehicle, const Eigen::Vector2d& lean, double passed_s) {
  top_mps_ -= gravity_mps2 * passed_s * lean;
  top_mps_ += std::min(1.0, passed_s / corrected_in_s) * (vehicle.velocity_ned_mps.head<2>() - top_mps_);
  const Eigen::Vector2d pull_mps2 = -gravity_mps2 / pendulum_m() * (weight_m_ - resting_m());
  weight_mps_ += passed_s * (pull_mps2 - 2 / dies_out_s * (weight_mps_ - top_mps_));
  weight_m_ += passed_s * (weight_mps_ - top_mps_);
}

/// A cargo's weight is half way up its body.
double Hanging::pendulum_m() const {
  const double below_hook_m = settings_.handle_over_rim_m + settings_.rim_over_deck_m / 2;
  return std::max(0.1, settings_.rope_m + (loaded_ ? below_hook_m : 0));
}

Eigen::Vector2d Hanging::resting_m() const {
  const double share = loaded_ ? settings_.loaded_lean : settings_.empty_lean;
  return share * pendulum_m() * mean_down_ned_.head<2>();
}

Eigen::Vector2d Hanging::swing_ned_m(double ahead_s) const {
  const double radps = std::sqrt(gravity_mps2 / pendulum_m());
  const Eigen::Vector2d now_m = weight_m_ - resting_m(), rate_mps = weight_mps_ - top_mps_;
  return settings_.rope_m / pendulum_m() *
         (std::cos(radps * ahead_s) * now_m + std::sin(radps * ahead_s) / radps * rate_mps);
}

Eigen::Vector2d Hanging::velocity_ned_mps() const {
  return top_mps_ + settings_.rope_m / pendulum_m() * (weight_mps_ - top_mps_);
}

Eigen::Vector3d Hanging::mean_ned_m() const {
  const Eigen::Vector3d down = Eigen::Vector3d::UnitZ(), lean = mean_down_ned_ - down;
  const Eigen::Vector3d rope =
      (down + (loaded_ ? settings_.loaded_lean : settings_.empty_lean) * lean).normalized();
  const Eigen::Vector3d ahead(std::cos(heading_rad_), std::sin(heading_rad_), 0);
  const Eigen::Vector3d right(-ahead.y(), ahead.x(), 0);
  return settings_.hook_forward_m * ahead + settings_.hook_right_m * right +
         settings_.hook_down_m * mean_down_ned_ + settings_.rope_m * rope;
}

}  // namespace stevedore
