// Where the hook hangs, though no camera sees it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

#include "mission_proc/carry_settings.hpp"

namespace stevedore {

/// An aircraft that hovers leans into the wind, and so does a rope: both where weight, thrust and drag are in
/// balance. The mean of the aircraft's lean over some seconds, without its manoeuvres, tells that of the
/// rope.
class Hanging {
 public:
  explicit Hanging(const CarrySettings& settings) : settings_(settings) {}

  void hear(const Eigen::Quaterniond& ned_from_body, std::int64_t utime);
  /// From the point whose position VEHICLE_STATE tells, m, along NED's axes.
  [[nodiscard]] Eigen::Vector3d hook_ned_m(bool loaded) const;
  [[nodiscard]] double heading_rad() const { return heading_rad_; }

 private:
  CarrySettings settings_;
  Eigen::Vector3d mean_down_ned_ = Eigen::Vector3d::UnitZ();  ///< body's down axis
  double heading_rad_ = 0;
  std::int64_t utime_ = 0;
};

}  // namespace stevedore
