// A weight on a rope: a damped pendulum from a point that moves.
#pragma once

#include <Eigen/Core>

#include "sim_proc/world/footing.hpp"

namespace stevedore::world {

/// What hangs on it, as a point. drag_per_s: force of the air over mass and speed.
struct Load {
  double length_m = 0;  ///< from where the rope begins
  double drag_per_s = 0;
};

/// The rope is weightless and does not stretch; it can go slack.
class Rope {
 public:
  /// What rope and swivel take of a swing's speed, a second: a few per cent of each swing.
  static constexpr double friction_per_s = 0.1;

  Rope(const Eigen::Vector3d& anchor_ned_m, const Load& load);

  /// Another load, which goes on from this state.
  void carry(const Eigen::Vector3d& weight_ned_m, const Eigen::Vector3d& velocity_ned_mps, const Load& load);
  void lengthen_to(double length_m) { load_.length_m = length_m; }
  void step(const Eigen::Vector3d& anchor_ned_m, const Eigen::Vector3d& wind_ned_mps, double step_s);
  /// What hangs touches the floor and drags over it: raised by so much, and slowed.
  void drag_over(const Footing& on, double raised_m, double step_s);
  /// What lies on the floor goes with the floor.
  void rest_on(const Floor& floor);

  [[nodiscard]] const Eigen::Vector3d& weight_ned_m() const { return weight_ned_m_; }
  [[nodiscard]] const Eigen::Vector3d& velocity_ned_mps() const { return velocity_ned_mps_; }
  [[nodiscard]] Eigen::Vector3d up_ned() const;  ///< unit, from the weight to where the rope begins
  [[nodiscard]] double pull_mps2() const { return pull_mps2_; }  ///< tension over mass; 0: slack

 private:
  Eigen::Vector3d anchor_ned_m_;
  Load load_;
  Eigen::Vector3d weight_ned_m_;
  Eigen::Vector3d velocity_ned_mps_ = Eigen::Vector3d::Zero();
  double pull_mps2_ = 0;
};

}  // namespace stevedore::world
