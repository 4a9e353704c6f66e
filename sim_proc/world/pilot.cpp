#include "sim_proc/world/pilot.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace stevedore::world {
namespace {

constexpr double per_s = 0.6;              ///< speed for a metre to go: slower than the velocity loop by four
constexpr double over_m = 0.5;             ///< so near counts as being over a place that is looked down upon
constexpr double descends_within_m = 0.4;  ///< of a circle's middle: its radius is 0.5 m
constexpr double stay_s = 4;
constexpr double search_radius_m = 5;  ///< of the corners that are flown around a platform
constexpr int corners = 4;
constexpr double turn_per_s = 0.3, max_turn_radps = 0.35;

Eigen::Vector3d limited(Eigen::Vector3d velocity_mps) {
  const double horizontal_mps = velocity_mps.head<2>().norm();
  if (horizontal_mps > ScriptedPilot::max_horizontal_mps)
    velocity_mps.head<2>() *= ScriptedPilot::max_horizontal_mps / horizontal_mps;
  velocity_mps.z() = std::clamp(velocity_mps.z(), -ScriptedPilot::max_up_mps, ScriptedPilot::max_down_mps);
  return velocity_mps;
}

double heading_of(const Rigid& aircraft) {
  const Eigen::Vector3d ahead_ned = aircraft.ned_from_local * Eigen::Vector3d::UnitX();
  return std::atan2(ahead_ned.y(), ahead_ned.x());
}

}  // namespace

VelocityCommand ScriptedPilot::fly(const Truth& truth) {
  look(truth);
  const Goal wanted = goal(truth);
  const VelocityCommand command = towards(wanted, truth);
  velocity_ned_mps_ = command.velocity_ned_mps;
  last_s_ = truth.time_s;
  decide(truth, wanted);
  return command;
}

/// Middle of each platform's circles, and its velocity from one look to the next.
void ScriptedPilot::look(const Truth& truth) {
  for (int platform = 0; platform < 2; ++platform) {
    Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
    int circles = 0;
    for (const CircleTruth& circle : truth.circles) {
      if (circle.platform != platform) continue;
      sum_m += circle.center_ned_m;
      ++circles;
    }
    Sighting& seen = platforms_[static_cast<std::size_t>(platform)];
    const Eigen::Vector3d middle_m = sum_m / std::max(1, circles);
    const double passed_s = truth.time_s - seen.time_s;
    if (seen.time_s >= 0 && passed_s > 0) seen.velocity_ned_mps = (middle_m - seen.middle_ned_m) / passed_s;
    seen.middle_ned_m = middle_m;
    seen.time_s = truth.time_s;
  }
}

ScriptedPilot::Goal ScriptedPilot::goal(const Truth& truth) const {
  switch (leg_) {
    case Leg::take_off:
      return {{truth.camera.position_ned_m.x(), truth.camera.position_ned_m.y(), -search_height_m},
              Eigen::Vector3d::Zero()};
    case Leg::search:
      return search_goal();
    case Leg::descend:
    case Leg::stay:
      return circle_goal(truth, low_height_m);
    case Leg::go_over:
    case Leg::climb:
      break;
  }
  return circle_goal(truth, transit_height_m);
}

/// Corners around the first platform, then around the second.
ScriptedPilot::Goal ScriptedPilot::search_goal() const {
  const Sighting& platform = platforms_[static_cast<std::size_t>(search_point_ / corners)];
  const double bearing_rad = 2 * std::numbers::pi * (search_point_ % corners) / corners;
  Goal goal{platform.middle_ned_m, platform.velocity_ned_mps};
  goal.place_ned_m += search_radius_m * Eigen::Vector3d(std::cos(bearing_rad), std::sin(bearing_rad), 0);
  goal.place_ned_m.z() = -search_height_m;
  goal.velocity_ned_mps.z() = 0;
  return goal;
}

ScriptedPilot::Goal ScriptedPilot::circle_goal(const Truth& truth, double height_m) const {
  const int platform = visit_ % 2, slot = visit_ / 2 % 4;
  const auto circle = std::find_if(truth.circles.begin(), truth.circles.end(), [&](const CircleTruth& each) {
    return each.platform == platform && each.slot == slot;
  });
  const Sighting& seen = platforms_[static_cast<std::size_t>(platform)];
  const Eigen::Vector3d center_m = circle == truth.circles.end() ? seen.middle_ned_m : circle->center_ned_m;
  return {center_m - Eigen::Vector3d(0, 0, height_m), seen.velocity_ned_mps};
}

VelocityCommand ScriptedPilot::towards(const Goal& goal, const Truth& truth) const {
  const Eigen::Vector3d to_go_m = goal.place_ned_m - truth.camera.position_ned_m;
  Eigen::Vector3d wanted_mps = goal.velocity_ned_mps + per_s * to_go_m;
  const bool beside = to_go_m.head<2>().norm() > descends_within_m;
  if (leg_ == Leg::descend && beside) wanted_mps.z() = goal.velocity_ned_mps.z();
  wanted_mps = limited(wanted_mps);
  const double most_mps = max_acceleration_mps2 * std::max(0.0, truth.time_s - last_s_);
  const Eigen::Vector3d change_mps = wanted_mps - velocity_ned_mps_;
  const double share = change_mps.norm() > most_mps ? most_mps / change_mps.norm() : 1;
  VelocityCommand command{velocity_ned_mps_ + share * change_mps, 0};
  if (leg_ == Leg::go_over && to_go_m.head<2>().norm() > 2 * search_radius_m) {
    const double off_rad = std::remainder(std::atan2(to_go_m.y(), to_go_m.x()) - heading_of(truth.aircraft),
                                          2 * std::numbers::pi);
    command.yaw_rate_radps = std::clamp(turn_per_s * off_rad, -max_turn_radps, max_turn_radps);
  }
  return command;
}

void ScriptedPilot::decide(const Truth& truth, const Goal& goal) {
  const Eigen::Vector3d to_go_m = goal.place_ned_m - truth.camera.position_ned_m;
  const double beside_m = to_go_m.head<2>().norm(), over = std::abs(to_go_m.z());
  const double now_s = truth.time_s;
  switch (leg_) {
    case Leg::take_off:
      if (over < over_m) begin(Leg::search, now_s);
      break;
    case Leg::search:
      if (beside_m < 2 * over_m && ++search_point_ == 2 * corners) begin(Leg::go_over, now_s);
      break;
    case Leg::go_over:
      if (beside_m < over_m && over < 2 * over_m) begin(Leg::descend, now_s);
      break;
    case Leg::descend:
      if (beside_m < descends_within_m && over < 0.2) begin(Leg::stay, now_s);
      break;
    case Leg::stay:
      if (now_s - leg_began_s_ > stay_s) begin(Leg::climb, now_s);
      break;
    case Leg::climb:
      if (over > over_m) break;
      ++visit_;
      begin(Leg::go_over, now_s);
      break;
  }
}

void ScriptedPilot::begin(Leg leg, double time_s) {
  leg_ = leg;
  leg_began_s_ = time_s;
}

}  // namespace stevedore::world
