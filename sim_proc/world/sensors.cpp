#include "sim_proc/world/sensors.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stevedore::world {
namespace {

/// Even an exact sensor claims some variance: nobody divides by zero.
constexpr double least_sigma = 1e-3;

double claimed(double sigma, double share) {
  return std::max(share * sigma, least_sigma);
}

Eigen::Quaterniond small_turn(const Eigen::Vector3d& turn_rad) {
  const double angle_rad = turn_rad.norm();
  if (angle_rad == 0) return Eigen::Quaterniond::Identity();
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, turn_rad / angle_rad));
}

double heading_of(const Rigid& deck) {
  const Eigen::Vector3d ahead_ned = deck.ned_from_local * Eigen::Vector3d::UnitX();
  return std::atan2(ahead_ned.y(), ahead_ned.x());
}

const char* platform_stream(int platform) {
  return platform == 0 ? "platform sensor 0" : "platform sensor 1";
}

}  // namespace

VehicleSensor::VehicleSensor(std::uint64_t seed, double share)
    : dice_(seed, "vehicle sensor"),
      share_(share),
      position_bias_m_(share * position_sigma_m, position_time_s, SensorPeriods::vehicle_s, dice_),
      attitude_bias_rad_(share * attitude_bias_rad, attitude_time_s, SensorPeriods::vehicle_s, dice_) {}

VehicleReading VehicleSensor::read(double time_s, const Rigid& body) {
  VehicleReading reading;
  reading.time_s = time_s;
  reading.position_ned_m = body.position_ned_m + position_bias_m_.step(dice_);
  reading.velocity_ned_mps = body.velocity_ned_mps + normal3(share_ * velocity_sigma_mps, dice_);
  const Eigen::Vector3d bias_rad = attitude_bias_rad_.step(dice_);
  const Eigen::Vector3d noise_rad = normal3(share_ * attitude_noise_rad, dice_);
  reading.ned_from_body = (body.ned_from_local * small_turn(bias_rad + noise_rad)).normalized();
  reading.angular_rate_body_radps = body.ned_from_local.conjugate() * body.angular_velocity_ned_radps +
                                    normal3(share_ * rate_sigma_radps, dice_);
  reading.position_sigma_m = claimed(position_sigma_m, share_);
  reading.velocity_sigma_mps = claimed(velocity_sigma_mps, share_);
  reading.attitude_sigma_rad = claimed(std::hypot(attitude_noise_rad, attitude_bias_rad), share_);
  return reading;
}

GimbalEncoders::GimbalEncoders(std::uint64_t seed, double share)
    : dice_(seed, "gimbal encoders"), share_(share) {}

GimbalReading GimbalEncoders::read(double time_s, const GimbalAngles& angles, bool at_limit) {
  const double roll_rad = angles.roll_rad + dice_.normal(share_ * sigma_rad);
  const double pitch_rad = angles.pitch_rad + dice_.normal(share_ * sigma_rad);
  return {time_s, {roll_rad, pitch_rad}, at_limit};
}

Altimeter::Altimeter(std::uint64_t seed, double share) : dice_(seed, "altimeter"), share_(share) {}

AltimeterReading Altimeter::read(double time_s, std::optional<double> range_m, bool on_water) {
  const double noise_m = dice_.normal(share_ * sigma_m);
  const bool swallowed = dice_.chance(share_ * lost_on_water) && on_water;
  dropping_out_ = dice_.chance(share_ * (dropping_out_ ? goes_on_dropping_out : begins_to_drop_out));
  AltimeterReading reading{time_s, {}, claimed(sigma_m, share_)};
  const bool seen = range_m && *range_m < longest_m && !dropping_out_ && !swallowed;
  if (seen) reading.range_m = std::max(0.0, *range_m + noise_m);
  return reading;
}

LoadCell::LoadCell(std::uint64_t seed, double share)
    : dice_(seed, "load cell"), share_(share), offset_n_(dice_.normal(share * offset_sigma_n)) {}

HookReading LoadCell::read(double time_s, double load_n, bool closed) {
  return {time_s, load_n + offset_n_ + dice_.normal(share_ * sigma_n), closed};
}

PlatformSensor::PlatformSensor(std::uint64_t seed, int platform, double share)
    : dice_(seed, platform_stream(platform)),
      platform_(platform),
      share_(share),
      bias_m_(share * bias_sigma_m, bias_time_s, SensorPeriods::platform_s, dice_) {}

bool PlatformSensor::is_silent(double time_s) {
  const bool falls_silent = dice_.chance(share_ * chance_of_silence);
  const double silence_s = dice_.uniform(shortest_silence_s, longest_silence_s);
  if (falls_silent) silent_until_s_ = std::max(silent_until_s_, time_s + silence_s);
  return time_s < silent_until_s_;
}

std::optional<PlatformReading> PlatformSensor::read(double time_s, const Rigid& deck) {
  PlatformReading reading;
  reading.time_s = time_s;
  reading.platform = platform_;
  reading.position_ned_m = deck.position_ned_m + bias_m_.step(dice_) + normal3(share_ * noise_sigma_m, dice_);
  reading.velocity_ned_mps = deck.velocity_ned_mps + normal3(share_ * velocity_sigma_mps, dice_);
  reading.heading_rad =
      std::remainder(heading_of(deck) + dice_.normal(share_ * heading_sigma_rad), 2 * std::numbers::pi);
  reading.position_sigma_m = claimed(std::hypot(bias_sigma_m, noise_sigma_m), share_);
  if (is_silent(time_s)) return std::nullopt;
  return reading;
}

AutopilotSensor::AutopilotSensor(std::uint64_t seed, double share)
    : dice_(seed, "autopilot sensor"), share_(share) {}

AutopilotReading AutopilotSensor::read(double time_s, bool landed, double battery_share) {
  const double volts = empty_v + (full_v - empty_v) * battery_share + dice_.normal(share_ * sigma_v);
  return {time_s, landed, battery_share, volts};
}

}  // namespace stevedore::world
