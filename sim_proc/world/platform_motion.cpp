#include "sim_proc/world/platform_motion.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

namespace stevedore::world {
namespace {

using std::numbers::pi;
constexpr double deg = pi / 180;

Eigen::Vector2d along(double heading_rad) {
  return {std::cos(heading_rad), std::sin(heading_rad)};
}

/// There and back, turning round within 10 s: 0.4 m/s2 at most.
SpeedProfile to_and_fro(double speed_mps, double length_m) {
  const double run_s = length_m / speed_mps;
  return SpeedProfile({{10, speed_mps}, {run_s, speed_mps}, {10, -speed_mps}, {run_s, -speed_mps}});
}

/// Two goes there, two back, a stand after each.
SpeedProfile by_stages(double speed_mps, double stand_s) {
  std::vector<SpeedProfile::Stretch> cycle;
  for (const double v_mps : {speed_mps, speed_mps, -speed_mps, -speed_mps}) {
    cycle.insert(cycle.end(), {{5, v_mps}, {3, v_mps}, {5, 0}, {stand_s, 0}});
  }
  return SpeedProfile(std::move(cycle));
}

void draw_line(Formation& formation, Dice& dice) {
  formation.heading_rad = dice.uniform(0, 2 * pi);
  // abreast rather than in line ahead, so that both ends of the run stay near the middle
  const double bearing_rad =
      formation.heading_rad + (dice.chance(0.5) ? 1 : -1) * dice.uniform(60, 120) * deg;
  formation.apart_m = dice.uniform(18, 27) * along(bearing_rad);
  if (formation.manner == Manner::straight) {
    formation.speed = to_and_fro(dice.uniform(0.8, 1.35), 16);
  } else {
    const double stand_s = dice.uniform(8, 20), speed_mps = dice.uniform(0.7, 1.2);
    formation.speed = by_stages(speed_mps, stand_s);
  }
}

void draw_circle(Formation& formation, Dice& dice) {
  formation.turn_radius_m = dice.uniform(14, 18);
  formation.heading_rad = dice.uniform(0, 2 * pi);
  formation.apart_rad = 2 * std::asin(dice.uniform(18, 26) / 2 / formation.turn_radius_m);
  const double speed_mps = (dice.chance(0.5) ? 1 : -1) * dice.uniform(0.6, 1.35);
  formation.speed = SpeedProfile({{60, speed_mps}});
}

}  // namespace

Sea sea_of(int sea_state) {
  static constexpr std::array<Sea, 5> seas{
      {{0, 0}, {0.05, 0.7 * deg}, {0.10, 1.5 * deg}, {0.25, 3 * deg}, {0.40, 5 * deg}}};
  if (sea_state < 0 || sea_state >= static_cast<int>(seas.size()))
    throw std::invalid_argument("sea state " + std::to_string(sea_state) + " is not one of 0 to 4");
  return seas[static_cast<std::size_t>(sea_state)];
}

Formation draw_formation(std::uint64_t seed) {
  Dice dice(seed, "formation");
  Formation formation;
  formation.manner = static_cast<Manner>(dice.whole(0, 2));
  // 34 m from the origin: a course reaches 12 m from its line's middle, half the distance apart beside it
  formation.center_m = 34 * along(dice.uniform(0, 2 * pi));
  if (formation.manner == Manner::turning) {
    draw_circle(formation, dice);
  } else {
    draw_line(formation, dice);
  }
  formation.phase_s = dice.uniform(0, formation.speed.cycle_s());
  return formation;
}

PlatformMotion::PlatformMotion(std::uint64_t seed, int platform, int sea_state)
    : PlatformMotion(seed, platform, sea_of(sea_state),
                     Dice(seed, platform == 0 ? "platform 0" : "platform 1")) {}

PlatformMotion::PlatformMotion(std::uint64_t seed, int platform, const Sea& sea, Dice dice)
    : platform_(platform),
      formation_(draw_formation(seed)),
      rest_down_m_(-0.8 - 2 * sea.heave_m),  // in a rough sea higher, lest it dips under
      sway_m_(0.5, 60, 100, dice),
      heave_m_(sea.heave_m, 5, 7, dice),
      roll_rad_(sea.tilt_rad, 5, 7, dice),
      pitch_rad_(sea.tilt_rad, 5, 7, dice),
      steering_rad_(1 * deg, 20, 40, dice) {}

PlatformMotion::Track PlatformMotion::on_line(double distance_m, double speed_mps) const {
  const Eigen::Vector2d ahead = along(formation_.heading_rad);
  const Eigen::Vector2d start_m = formation_.center_m + (platform_ == 0 ? -0.5 : 0.5) * formation_.apart_m;
  return {start_m + (distance_m - formation_.speed.middle_m()) * ahead, speed_mps * ahead,
          formation_.heading_rad, 0};
}

PlatformMotion::Track PlatformMotion::on_circle(double distance_m, double speed_mps) const {
  const double radius_m = formation_.turn_radius_m;
  const double angle_rad =
      formation_.heading_rad + (platform_ == 0 ? 0 : formation_.apart_rad) + distance_m / radius_m;
  const Eigen::Vector2d outwards = along(angle_rad), onwards(-outwards.y(), outwards.x());
  const bool clockwise = formation_.speed.at(0).speed_mps > 0;
  return {formation_.center_m + radius_m * outwards, speed_mps * onwards,
          angle_rad + (clockwise ? pi / 2 : -pi / 2), speed_mps / radius_m};
}

Rigid PlatformMotion::at(double time_s) const {
  const SpeedProfile::At run = formation_.speed.at(time_s + formation_.phase_s);
  const Oscillation::At sway = sway_m_.at(time_s), heave = heave_m_.at(time_s), roll = roll_rad_.at(time_s),
                        pitch = pitch_rad_.at(time_s), steering = steering_rad_.at(time_s);
  const double distance_m = run.distance_m + sway.value, speed_mps = run.speed_mps + sway.rate;
  const Track track =
      formation_.turn_radius_m > 0 ? on_circle(distance_m, speed_mps) : on_line(distance_m, speed_mps);

  const Eigen::AngleAxisd yaw(track.heading_rad + steering.value, Eigen::Vector3d::UnitZ());
  const Eigen::AngleAxisd about_y(pitch.value, Eigen::Vector3d::UnitY());
  const Eigen::AngleAxisd about_x(roll.value, Eigen::Vector3d::UnitX());
  Rigid rigid;
  rigid.position_ned_m << track.position_m, rest_down_m_ + heave.value;
  rigid.velocity_ned_mps << track.velocity_mps, heave.rate;
  rigid.ned_from_local = yaw * about_y * about_x;
  // yaw about down, pitch about the axis that yaw has turned, roll about the axis that both have
  rigid.angular_velocity_ned_radps = (track.turn_radps + steering.rate) * Eigen::Vector3d::UnitZ() +
                                     yaw * (pitch.rate * Eigen::Vector3d::UnitY()) +
                                     yaw * (about_y * Eigen::Vector3d(roll.rate, 0, 0));
  return rigid;
}

}  // namespace stevedore::world
