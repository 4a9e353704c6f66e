#include "sim_proc/world/aircraft.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "sim_proc/world/gravity.hpp"

namespace stevedore::world {
namespace {

/// Slower climbs are noise on a command of zero, not a wish to leave the ground.
constexpr double climb_mps = 0.1;

/// Time constants of what is not modelled: the rotor's answer to steady drag, and skids that give way.
constexpr double lean_time_s = 0.3;
constexpr double settle_time_s = 0.1;

Eigen::Vector3d limited(Eigen::Vector3d acceleration_mps2, double limit_mps2) {
  const double horizontal_mps2 = acceleration_mps2.head<2>().norm();
  if (horizontal_mps2 > limit_mps2) acceleration_mps2.head<2>() *= limit_mps2 / horizontal_mps2;
  acceleration_mps2.z() = std::clamp(acceleration_mps2.z(), -limit_mps2, limit_mps2);
  return acceleration_mps2;
}

/// Down along `down`, forward as near to the heading as that allows.
Eigen::Quaterniond attitude(const Eigen::Vector3d& down_ned, double heading_rad) {
  const Eigen::Vector3d heading_ned(std::cos(heading_rad), std::sin(heading_rad), 0);
  Eigen::Matrix3d ned_from_body;
  ned_from_body.col(2) = down_ned;
  ned_from_body.col(1) = down_ned.cross(heading_ned).normalized();
  ned_from_body.col(0) = ned_from_body.col(1).cross(down_ned);
  return Eigen::Quaterniond(ned_from_body);
}

Eigen::Vector3d angular_velocity(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to,
                                 double step_s) {
  Eigen::Quaterniond turn = to * from.conjugate();
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  return 2 / step_s * turn.vec();  // small angle: a step turns by hundredths of a radian
}

}  // namespace

Aircraft::Aircraft(const Eigen::Vector2d& position_m, double heading_rad, const Footing& on, double step_s)
    : step_s_(step_s),
      heading_rad_(heading_rad),
      delay_steps_(static_cast<std::size_t>(std::lround(delay_s / step_s))) {
  assert(delay_steps_ < on_their_way_.size());
  body_.position_ned_m << position_m, on.rigid.position_ned_m.z() - skids_down_m;
  body_.ned_from_local = attitude(Eigen::Vector3d::UnitZ(), heading_rad);
}

void Aircraft::command(const VelocityCommand& command) {
  if (command.velocity_ned_mps.z() < -climb_mps) landing_ = false;
  if (!landing_) newest_ = command;
}

void Aircraft::land() {
  landing_ = true;
  newest_ = {{0, 0, landing_mps}, 0};
}

VelocityCommand Aircraft::delayed() {
  on_their_way_[step_ % on_their_way_.size()] = newest_;
  const std::size_t sent = step_ < delay_steps_ ? 0 : step_ - delay_steps_;
  const VelocityCommand command =
      step_ < delay_steps_ ? VelocityCommand{} : on_their_way_[sent % on_their_way_.size()];
  ++step_;
  return command;
}

void Aircraft::step(const Air& air, const Floor& floor) {
  const VelocityCommand command = delayed();
  if (landed_ && command.velocity_ned_mps.z() < -climb_mps) landed_ = false;
  if (!landed_) fly(command, air);
  meet_the_floor(command, floor);
  turn(command, air);
  battery_share_ = std::max(0.0, battery_share_ - step_s_ / (landed_ ? idle_endurance_s : hover_endurance_s));
}

/// v'' = w^2 (command - v) - 2 damping w a, of which a = v' but for what gusts add to it.
void Aircraft::fly(const VelocityCommand& command, const Air& air) {
  const Eigen::Vector3d jerk_mps3 =
      loop_radps * loop_radps * (command.velocity_ned_mps - body_.velocity_ned_mps) -
      2 * loop_damping * loop_radps * acceleration_ned_mps2_;
  acceleration_ned_mps2_ = limited(acceleration_ned_mps2_ + jerk_mps3 * step_s_, max_acceleration_mps2);
  body_.velocity_ned_mps += (acceleration_ned_mps2_ + drag_per_s * air.gust_ned_mps) * step_s_;
  body_.position_ned_m += body_.velocity_ned_mps * step_s_;
}

void Aircraft::meet_the_floor(const VelocityCommand& command, const Floor& floor) {
  const Eigen::Vector3d skids_ned_m = body_.position_ned_m + Eigen::Vector3d(0, 0, skids_down_m);
  const Footing below = footing_below(floor, skids_ned_m);
  if (!landed_ && below.height_of(skids_ned_m) > 0) return;
  if (command.velocity_ned_mps.z() >= -climb_mps) landed_ = true;
  const Eigen::Vector3d up_ned = below.up_ned();
  body_.velocity_ned_mps = below.rigid.velocity_at(skids_ned_m);
  if (landed_) body_.position_ned_m.head<2>() += body_.velocity_ned_mps.head<2>() * step_s_;
  body_.position_ned_m.z() += below.height_of(skids_ned_m) / up_ned.dot(-Eigen::Vector3d::UnitZ());
  acceleration_ned_mps2_ *= std::exp(-step_s_ / settle_time_s);
}

void Aircraft::turn(const VelocityCommand& command, const Air& air) {
  const double wanted_radps =
      landed_ ? 0 : std::clamp(command.yaw_rate_radps, -max_yaw_rate_radps, max_yaw_rate_radps);
  yaw_rate_radps_ += (wanted_radps - yaw_rate_radps_) * (1 - std::exp(-yaw_loop_radps * step_s_));
  heading_rad_ += yaw_rate_radps_ * step_s_;

  const Eigen::Vector3d against_drag_mps2 =
      landed_ ? Eigen::Vector3d(0, 0, 0)
              : Eigen::Vector3d(drag_per_s * (body_.velocity_ned_mps - air.mean_ned_mps));
  leaning_mps2_ += (against_drag_mps2 - leaning_mps2_) * (1 - std::exp(-step_s_ / lean_time_s));
  Eigen::Vector3d thrust_mps2 = acceleration_ned_mps2_ - gravity_mps2 * Eigen::Vector3d::UnitZ();
  thrust_mps2.head<2>() += leaning_mps2_.head<2>();
  const Eigen::Quaterniond now = attitude(-thrust_mps2.normalized(), heading_rad_);
  body_.angular_velocity_ned_radps = angular_velocity(body_.ned_from_local, now, step_s_);
  body_.ned_from_local = now;
}

}  // namespace stevedore::world
