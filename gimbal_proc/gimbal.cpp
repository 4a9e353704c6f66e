#include "gimbal_proc/gimbal.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stevedore {
namespace {

constexpr double deg = std::numbers::pi / 180;

/// Nominal time between attitudes, for the first one: VEHICLE_STATE comes at 50 Hz.
constexpr double period_s = 0.02;

/// Attitudes this far apart are not one motion: the rates of one say nothing about the other.
constexpr double gap_s = 0.2;

/// A direction that stands still in the world, as the turning body sees it after a time: d/dt g = -w x g.
Eigen::Vector3d carried(const Eigen::Vector3d& direction_body, const Eigen::Vector3d& rate_body_radps,
                        double ahead_s) {
  const Eigen::Vector3d turn_rad = -rate_body_radps * ahead_s;
  const double angle_rad = turn_rad.norm();
  if (angle_rad < 1e-12) return direction_body;  // no axis to turn about
  return Eigen::AngleAxisd(angle_rad, turn_rad / angle_rad) * direction_body;
}

double largest_difference(const GimbalAngles& a, const GimbalAngles& b) {
  return std::max(std::abs(a.roll_rad - b.roll_rad), std::abs(a.pitch_rad - b.pitch_rad));
}

}  // namespace

GimbalAngles leveling_angles(const Eigen::Vector3d& gravity_body, const CameraMount& mount) {
  // Rx(roll) Ry(pitch) m = g, m: the optical axis on the platform. The outer turn leaves x alone:
  //   m_x cos(pitch) + m_z sin(pitch) = g_x, then roll turns (y, z) of Ry(pitch) m to that of g.
  const Eigen::Vector3d m = mount.platform_from_camera().col(2), g = gravity_body.normalized();
  const double reach = std::hypot(m.x(), m.z());
  GimbalAngles angles;
  angles.pitch_rad = std::asin(std::clamp(g.x() / reach, -1.0, 1.0)) - std::atan2(m.x(), m.z());
  const double z = m.z() * std::cos(angles.pitch_rad) - m.x() * std::sin(angles.pitch_rad);
  angles.roll_rad = std::remainder(std::atan2(g.z(), g.y()) - std::atan2(z, m.y()), 2 * std::numbers::pi);
  return angles;
}

void Gimbal::measured(const PanTiltReading& reading) {
  reading_ = reading;
}

GimbalStep Gimbal::follow(const AttitudeReading& attitude) {
  const std::optional<double> since_s = time_s_ ? std::optional(attitude.time_s - *time_s_) : std::nullopt;
  const bool continuous = since_s && *since_s >= 0 && *since_s <= gap_s;
  if (!continuous) start_clock(attitude.time_s);
  smooth_gravity(attitude, continuous ? since_s : std::nullopt);
  time_s_ = attitude.time_s;
  const Eigen::Vector3d ahead = carried(gravity_body_, attitude.rate_body_radps, settings_.lag_s);
  const GimbalAngles wanted = leveling_angles(ahead, mount_);
  GimbalStep step;
  step.level = judge(attitude, wanted);
  step.command = commanded(wanted, continuous ? *since_s : period_s);
  command_ = step.command;
  return step;
}

void Gimbal::start_clock(double time_s) {
  start_s_ = time_s;
  apart_since_s_.reset();
}

void Gimbal::smooth_gravity(const AttitudeReading& attitude, std::optional<double> since_s) {
  const Eigen::Vector3d seen = attitude.ned_from_body.conjugate() * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d expected = carried(gravity_body_, attitude.rate_body_radps, since_s.value_or(0));
  if (!since_s || !expected.allFinite()) {  // what is no number would stay one for good
    gravity_body_ = seen;
    return;
  }
  const double trust = *since_s >= settings_.smoothing_s ? 1 : *since_s / settings_.smoothing_s;
  gravity_body_ = (expected + trust * (seen - expected)).normalized();
}

GimbalAngles Gimbal::commanded(const GimbalAngles& wanted, double elapsed_s) const {
  const double limit_rad = settings_.limit_deg * deg, step_rad = settings_.rate_degps * deg * elapsed_s;
  const auto start = command_ ? command_ : reading_ ? std::optional(reading_->angles) : std::nullopt;
  const auto reached = [&](double to_rad, double GimbalAngles::*joint) {
    const double bounded = std::clamp(to_rad, -limit_rad, limit_rad);
    if (!start) return bounded;  // nobody knows how it stands; its own limits hold
    return std::clamp(bounded, (*start).*joint - step_rad, (*start).*joint + step_rad);
  };
  return {reached(wanted.roll_rad, &GimbalAngles::roll_rad),
          reached(wanted.pitch_rad, &GimbalAngles::pitch_rad)};
}

CameraLevel Gimbal::judge(const AttitudeReading& attitude, const GimbalAngles& wanted) {
  CameraLevel level;
  const double age_s = attitude.time_s - (reading_ ? reading_->time_s : start_s_);
  if (reading_) level.angles = reading_->angles;
  if (std::abs(age_s) > settings_.late_after_s) {  // from before a restart: it may be far ahead, too
    level.status = GimbalStatus::late;
    apart_since_s_.reset();
    return level;
  }
  level.status = GimbalStatus::ok;
  if (!reading_) return level;
  const Eigen::Vector3d gravity_then = carried(gravity_body_, attitude.rate_body_radps, -age_s);
  const Eigen::Vector3d axis_body = body_from_camera(reading_->angles, mount_).col(2);
  level.off_level_rad = std::atan2(axis_body.cross(gravity_then).norm(), axis_body.dot(gravity_then));

  const bool apart = command_ && largest_difference(*command_, reading_->angles) > settings_.stuck_deg * deg;
  if (!apart) apart_since_s_.reset();
  if (apart && !apart_since_s_) apart_since_s_ = attitude.time_s;
  const double limit_rad = settings_.limit_deg * deg;
  if (reading_->at_limit || std::abs(wanted.roll_rad) > limit_rad || std::abs(wanted.pitch_rad) > limit_rad)
    level.status = GimbalStatus::at_limit;
  if (apart && attitude.time_s - *apart_since_s_ >= settings_.stuck_after_s)
    level.status = GimbalStatus::stuck;
  return level;
}

}  // namespace stevedore
