// A weight on a rope: a damped pendulum from a point that moves.
#pragma once

#include <Eigen/Core>

#include "sim_proc/world/footing.hpp"

namespace stevedore::world {

/// The rope is weightless and does not stretch; it can go slack. The weight is a point.
class Rope {
 public:
  /// Of the weight's speed through the air, a second: a bucket of 0.1 m2 at a few m/s.
  static constexpr double drag_per_s = 0.15;

  Rope(const Eigen::Vector3d& anchor_ned_m, double length_m);

  /// Another weight at another distance along the line, which goes on from this state.
  void carry(const Eigen::Vector3d& weight_ned_m, const Eigen::Vector3d& velocity_ned_mps, double length_m);
  void lengthen_to(double length_m) { length_m_ = length_m; }
  void step(const Eigen::Vector3d& anchor_ned_m, const Eigen::Vector3d& wind_ned_mps, double step_s);
  /// What lies on the floor goes with the floor.
  void rest_on(const Floor& floor);

  [[nodiscard]] const Eigen::Vector3d& weight_ned_m() const { return weight_ned_m_; }
  [[nodiscard]] const Eigen::Vector3d& velocity_ned_mps() const { return velocity_ned_mps_; }
  [[nodiscard]] Eigen::Vector3d up_ned() const;  ///< unit, from the weight to where the rope begins
  [[nodiscard]] double pull_mps2() const { return pull_mps2_; }  ///< tension over mass; 0: slack

 private:
  Eigen::Vector3d anchor_ned_m_;
  double length_m_;
  Eigen::Vector3d weight_ned_m_;
  Eigen::Vector3d velocity_ned_mps_ = Eigen::Vector3d::Zero();
  double pull_mps2_ = 0;
};

}  // namespace stevedore::world
