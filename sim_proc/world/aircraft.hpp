// The aircraft under its autopilot's velocity loop: what a command makes it do, and how it is tilted
// meanwhile.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstddef>

#include "sim_proc/world/footing.hpp"
#include "sim_proc/world/rigid.hpp"
#include "sim_proc/world/velocity_command.hpp"

namespace stevedore::world {

/// The air that it flies in: known to the autopilot is the mean only.
struct Air {
  Eigen::Vector3d mean_ned_mps = Eigen::Vector3d::Zero();
  Eigen::Vector3d gust_ned_mps = Eigen::Vector3d::Zero();
};

/// Velocity follows its command, 0.1 s late, as a second-order system: natural frequency 2.5 rad/s, damping
/// 0.7. Acceleration is limited to 3 m/s2: by tilt, and vertically by thrust. The body's down axis is
/// opposite to the thrust that this and the drag against the air take. Gusts push it; the loop fights them.
class Aircraft {
 public:
  static constexpr double loop_radps = 2.5, loop_damping = 0.7;
  static constexpr double delay_s = 0.1;
  static constexpr double max_acceleration_mps2 = 3;
  static constexpr double drag_per_s = 0.15;   ///< 5 m/s of wind: 4.4 deg of tilt
  static constexpr double yaw_loop_radps = 4;  ///< of its rate, first order
  static constexpr double max_yaw_rate_radps = 1;
  static constexpr double skids_down_m = 0.55;  ///< below the body's origin
  static constexpr double landing_mps = 0.5;
  static constexpr double hover_endurance_s = 1500;
  static constexpr double idle_endurance_s = 20000;

  /// It stands on its skids, level, at this heading.
  Aircraft(const Eigen::Vector2d& position_m, double heading_rad, const Footing& on, double step_s);

  void command(const VelocityCommand& command);  ///< a climb ends a landing
  void land();                                   ///< straight down until it stands
  void step(const Air& air, const Floor& floor);

  [[nodiscard]] const Rigid& body() const { return body_; }
  [[nodiscard]] bool landed() const { return landed_; }
  [[nodiscard]] double battery_share() const { return battery_share_; }

 private:
  [[nodiscard]] VelocityCommand delayed();
  void fly(const VelocityCommand& command, const Air& air);
  void meet_the_floor(const VelocityCommand& command, const Floor& floor);
  void turn(const VelocityCommand& command, const Air& air);

  double step_s_;
  Rigid body_;
  Eigen::Vector3d acceleration_ned_mps2_ = Eigen::Vector3d::Zero();  ///< that the loop asks of the thrust
  Eigen::Vector3d leaning_mps2_ = Eigen::Vector3d::Zero();           ///< against the drag
  double heading_rad_ = 0;
  double yaw_rate_radps_ = 0;
  bool landed_ = true;
  bool landing_ = false;
  double battery_share_ = 1;
  VelocityCommand newest_;
  std::array<VelocityCommand, 32> on_their_way_;  ///< ring of commands, one a step
  std::size_t delay_steps_;
  std::size_t step_ = 0;
};

}  // namespace stevedore::world
