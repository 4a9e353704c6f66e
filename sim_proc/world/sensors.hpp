// What the sensors make of the truth. Each has its own dice and throws the same number of them for every
// reading, so that no error depends on what else happens.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

#include "geometry/attitude.hpp"
#include "sim_proc/world/dice.hpp"
#include "sim_proc/world/gauss_markov.hpp"
#include "sim_proc/world/readings.hpp"
#include "sim_proc/world/rigid.hpp"

namespace stevedore::world {

/// Periods, in seconds.
struct SensorPeriods {
  static constexpr double vehicle_s = 0.02, gimbal_s = 0.02, altimeter_s = 0.05, hook_s = 0.1,
                          platform_s = 0.5, autopilot_s = 0.5;
};

/// Autopilot's estimate: GPS whose error wanders over minutes, and attitude with noise and a wandering bias.
class VehicleSensor {
 public:
  static constexpr double position_sigma_m = 1.5, position_time_s = 300;
  static constexpr double velocity_sigma_mps = 0.1;
  static constexpr double attitude_noise_rad = 0.5 * 0.017453292519943295;  // 0.5 deg
  static constexpr double attitude_bias_rad = attitude_noise_rad, attitude_time_s = 60;
  static constexpr double rate_sigma_radps = 0.005;  ///< 0.3 deg/s: a small gyro

  /// share: of those errors; 0: exact.
  VehicleSensor(std::uint64_t seed, double share);
  VehicleReading read(double time_s, const Rigid& body);

 private:
  Dice dice_;
  double share_;
  GaussMarkov position_bias_m_, attitude_bias_rad_;
};

class GimbalEncoders {
 public:
  static constexpr double sigma_rad = 0.05 * 0.017453292519943295;  // 0.05 deg

  GimbalEncoders(std::uint64_t seed, double share);
  GimbalReading read(double time_s, const GimbalAngles& angles, bool at_limit);

 private:
  Dice dice_;
  double share_;
};

/// Laser. What it hits is the caller's business.
class Altimeter {
 public:
  static constexpr double sigma_m = 0.03, longest_m = 20;
  static constexpr double begins_to_drop_out = 0.01, goes_on_dropping_out = 0.7;  ///< a reading: 3 on end
  static constexpr double lost_on_water = 0.15;  ///< share of beams that water swallows

  Altimeter(std::uint64_t seed, double share);
  /// range_m: to what the beam hits; nothing: it hits nothing.
  AltimeterReading read(double time_s, std::optional<double> range_m, bool on_water);

 private:
  Dice dice_;
  double share_;
  bool dropping_out_ = false;
};

class LoadCell {
 public:
  static constexpr double sigma_n = 0.5, offset_sigma_n = 0.5;  ///< of a bucket's 15 N

  LoadCell(std::uint64_t seed, double share);
  HookReading read(double time_s, double load_n, bool closed);

 private:
  Dice dice_;
  double share_;
  double offset_n_;
};

/// What a platform says of itself: metres off, and silent for seconds now and then.
class PlatformSensor {
 public:
  static constexpr double bias_sigma_m = 2.5, bias_time_s = 120, noise_sigma_m = 0.3;
  static constexpr double velocity_sigma_mps = 0.2;
  static constexpr double heading_sigma_rad = 3 * 0.017453292519943295;  // 3 deg
  static constexpr double chance_of_silence = 0.02, shortest_silence_s = 2, longest_silence_s = 8;

  PlatformSensor(std::uint64_t seed, int platform, double share);
  /// Nothing: it is silent.
  std::optional<PlatformReading> read(double time_s, const Rigid& deck);

 private:
  bool is_silent(double time_s);

  Dice dice_;
  int platform_;
  double share_;
  GaussMarkov bias_m_;
  double silent_until_s_ = 0;
};

class AutopilotSensor {
 public:
  static constexpr double empty_v = 21, full_v = 25.2, sigma_v = 0.05;  ///< six lithium cells

  AutopilotSensor(std::uint64_t seed, double share);
  AutopilotReading read(double time_s, bool landed, double battery_share);

 private:
  Dice dice_;
  double share_;
};

}  // namespace stevedore::world
