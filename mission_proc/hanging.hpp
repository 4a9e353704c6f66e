// Where the hook hangs, though no camera sees it.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>

#include "geometry/vehicle_history.hpp"
#include "mission_proc/carry_settings.hpp"

namespace stevedore {

/// An aircraft that hovers leans into the wind, and so does a rope: both where weight, thrust and drag are in
/// balance. The mean of the aircraft's lean over some seconds, without its manoeuvres, tells that of the
/// rope. About it the rope swings by what its upper end does, which lean and velocity tell: a pendulum that
/// is reckoned along.
class Hanging {
 public:
  explicit Hanging(const CarrySettings& settings) : settings_(settings) {}

  /// loaded: with a cargo, whose weight lies below the hook. What changes that begins without a swing.
  void hear(const VehicleSample& vehicle, bool loaded);
  /// From the point whose position VEHICLE_STATE tells, m, along NED's axes: without the swing.
  [[nodiscard]] Eigen::Vector3d mean_ned_m() const;
  /// Of the hook; horizontal.
  [[nodiscard]] Eigen::Vector2d velocity_ned_mps() const;
  /// Of the hook from where it hangs in the mean; as it will be if nothing else happens.
  [[nodiscard]] Eigen::Vector2d swing_ned_m(double ahead_s = 0) const;
  [[nodiscard]] double heading_rad() const { return heading_rad_; }

 private:
  void swing_on(const VehicleSample& vehicle, const Eigen::Vector2d& lean, double passed_s);
  [[nodiscard]] double pendulum_m() const;
  [[nodiscard]] Eigen::Vector2d resting_m() const;

  CarrySettings settings_;
  Eigen::Vector3d mean_down_ned_ = Eigen::Vector3d::UnitZ();  ///< body's down axis
  double heading_rad_ = 0;
  std::int64_t utime_ = 0;
  bool loaded_ = false;
  Eigen::Vector2d down_ = Eigen::Vector2d::Zero();  ///< body's down axis as last heard, horizontally
  Eigen::Vector2d top_mps_ =
      Eigen::Vector2d::Zero();  ///< of the aircraft, which takes the rope's upper end along
  Eigen::Vector2d weight_m_ = Eigen::Vector2d::Zero();    ///< of what hangs, from there
  Eigen::Vector2d weight_mps_ = Eigen::Vector2d::Zero();  ///< its own, over ground
};

}  // namespace stevedore
