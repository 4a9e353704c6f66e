// Where the aircraft was and how it was turned at any moment of the last seconds.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <deque>
#include <optional>

namespace stevedore {

/// What the autopilot said at one moment. World: NED, its own: metres off, by an error that wanders slowly.
struct VehicleSample {
  std::int64_t utime = 0;
  Eigen::Vector3d position_ned_m;
  Eigen::Vector3d velocity_ned_mps;
  Eigen::Quaterniond ned_from_body;
  Eigen::Vector3d angular_rate_body_radps;
  double velocity_variance_m2ps2 = 0;
  double attitude_variance_rad2 =
      0;  ///< of each angle: half noise from sample to sample, half an error that lasts
};

/// The aircraft at a moment between samples. The odometry frame has NED's axes; positions in it are sums of
/// velocity, so that they are right to centimetres over seconds but drift away from NED over minutes. Vision,
/// which is as precise, is kept in it.
struct VehicleMoment {
  Eigen::Vector3d position_odometry_m;
  Eigen::Vector3d ned_from_odometry_m;  ///< add to a position in odometry to have it in the autopilot's NED
  Eigen::Quaterniond
      ned_from_body;  ///< mean over the samples about that moment, each carried there by its rate
  double velocity_variance_m2ps2 = 0;
  double attitude_variance_rad2 = 0;  ///< of that mean, the noise alone
};

class VehicleHistory {
 public:
  /// One that is not newer than the newest changes nothing. After a gap too long to be bridged by velocity,
  /// odometry goes on by the difference of positions.
  void add(const VehicleSample& sample);

  /// Half the time over which attitudes are averaged. Five samples at 50 Hz: their noise is halved, and rate
  /// times time still is the turn between them to a thousandth.
  static constexpr std::int64_t attitude_window_us = 60'000;

  /// Interpolated; beyond the newest sample carried on by its velocity and rate, for as long as samples are
  /// apart at most. Nothing outside.
  [[nodiscard]] std::optional<VehicleMoment> at(std::int64_t utime) const;

  /// Of the newest sample; -1: none.
  [[nodiscard]] std::int64_t newest_utime() const;

 private:
  struct Entry {
    VehicleSample sample;
    Eigen::Vector3d position_odometry_m;
  };
  void average_attitude(std::int64_t utime, VehicleMoment& moment) const;

  std::deque<Entry> entries_;
};

}  // namespace stevedore
