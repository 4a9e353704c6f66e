// Where the aircraft should be, and what it should do there.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "mission_proc/carry.hpp"

namespace stevedore {
namespace {

double seconds(std::int64_t us) {
  return static_cast<double>(us) * 1e-6;
}

constexpr double climb_mps = 0.7;
constexpr double lower_mps = 0.4;   // a deck's heave of 0.4 m at 6 s is as fast: never twice as fast together
constexpr double touch_mps = 0.12;  // the last decimetres: well below what a hook may have against a handle
/// A commanded height changes its rate no faster: a third of what the aircraft can, so that nothing swings.
constexpr double smooth_mps2 = 0.4;
/// A handle is felt for: up and down by this much about where it should be, in this time. The jaws need the
/// handle within 0.06 m for 0.3 s: at 0.08 m/s it stays there long enough. Four lever arms that are known to
/// 0.02 m each and a deck to 0.03 m make 0.05 m: twice that.
constexpr double felt_m = 0.10, felt_turn_s = 8;
/// Below contact: a cargo is lowered until the load cell tells that it stands. The height is off by as much
/// as a handle's.
constexpr double press_m = 0.15;
/// Over its circle a cargo is held as low as leaves it clear of the deck, whose height is known to a
/// decimetre.
constexpr double held_m = 0.25;
/// Of a swing, a second, that the rope's upper end goes after it: a swing dies out to a third in 2 / 0.6 = 3
/// s, two of its periods, and the aircraft moves by a sixth of it.
constexpr double damped_per_s = 0.6;
constexpr double told_every_s =
    0.1;  // set-points come with the camera's frames: half of it later in the mean

/// Along a spiral with turns that far apart, the middle of each seen from the next one.
Eigen::Vector2d spiral_m(double way_m, double apart_m) {
  constexpr double widest_way_m = 250;  // then from the middle again
  way_m = std::fmod(std::max(0.0, way_m), widest_way_m);
  const double turn_rad = std::sqrt(4 * std::numbers::pi * way_m / apart_m);
  const double radius_m = apart_m / (2 * std::numbers::pi) * turn_rad;
  return radius_m * Eigen::Vector2d(std::cos(turn_rad), std::sin(turn_rad));
}

}  // namespace

void Carry::guide(double passed_s) {
  goal_ = goal(passed_s);
  switch (record_.phase) {
    case Phase::idle:
    case Phase::complete:
    case Phase::suspended:
      action_ = Action::none;
      break;
    case Phase::hold:
    case Phase::abort:
      action_ = Action::hover;
      break;
    case Phase::take_off:
    case Phase::verify_load:
    case Phase::verify_drop:
    case Phase::retry:
      action_ = Action::climb;
      break;
    case Phase::search:
    case Phase::approach:
    case Phase::transit:
    case Phase::go_home:
      action_ = Action::go_to;
      break;
    case Phase::descend:
      action_ = Action::descend;
      break;
    case Phase::load:
      action_ = closes_jaws_ ? Action::grab : closing_since_ ? Action::release : Action::descend;
      break;
    case Phase::drop:
      action_ = opens_jaws_ ? Action::release : Action::descend;
      break;
    case Phase::land:
      action_ = lands_ ? Action::land : Action::descend;
      break;
  }
  const bool nothing_to_hold =
      !record_.loaded && record_.phase != Phase::load && record_.phase != Phase::verify_load;
  const bool in_charge = action_ != Action::none && action_ != Action::land;
  const bool may_hold = hook_ ? hook_->closed : record_.phase == Phase::retry;  // a hook that tells nothing
  if (in_charge && nothing_to_hold && may_hold) action_ = Action::release;
}

std::optional<Carry::Goal> Carry::goal(double passed_s) {
  const double clear_m = hook_height_at(settings_.approach_height_m);
  switch (record_.phase) {
    case Phase::idle:
    case Phase::complete:
    case Phase::suspended:
      return std::nullopt;
    case Phase::hold:
    case Phase::abort:
      return stay(0, 0);
    case Phase::take_off:
      return over_home(settings_.take_off_height_m);
    case Phase::search:
      return over_deck(sees_deck() ? settings_.inspect_height_m : settings_.search_height_m);
    case Phase::transit:
      return over_deck(settings_.transit_height_m);
    case Phase::approach:
      return over_target(clear_m, climb_mps, passed_s);
    case Phase::descend:
      return over_target(settings_.clearance_m, lower_mps, passed_s);
    case Phase::load:
      return over_target(closing_since_ ? felt_height_m() : 0, touch_mps, passed_s);
    case Phase::drop:
      return over_target(-press_m, touch_mps, passed_s);
    case Phase::verify_load:
      return over_target(tries_hold() ? held_m : clear_m, climb_mps, passed_s);
    case Phase::verify_drop:
    case Phase::retry:
      return over_target(clear_m, climb_mps, passed_s);
    case Phase::go_home:
      return over_home(settings_.transit_height_m);
    case Phase::land:
      return over_home(settings_.land_height_m);
  }
  return std::nullopt;
}

Carry::Goal Carry::stay(double climb_rate_mps, double passed_s) {
  constexpr double most_m = 5;  // clear of all that stands on a deck; from there more height shows no more
  if (!stay_odometry_m_) stay_odometry_m_ = now_->position_odometry_m;
  if (climbed_m_ >= most_m) climb_rate_mps = 0;
  climbed_m_ += climb_rate_mps * passed_s;
  stay_odometry_m_->z() -= climb_rate_mps * passed_s;
  return {*stay_odometry_m_, {0, 0, -climb_rate_mps}, heading_rad_};
}

/// The hook over its goal. Lower only while the hook is inside a cone over it and the platform is in sight.
Carry::Goal Carry::over_target(double wanted_height_m, double rate_mps, double passed_s) {
  if (!has_target_place()) return stay(climb_mps, passed_s);
  stay_odometry_m_.reset();  // should its place be forgotten: from where the aircraft then is
  const Miss off = miss();
  double height_m = height_m_.value_or(off.height_m);  // after a restart: from where it is
  const bool lowers = wanted_height_m < height_m;
  // a cargo touches where it then is; above a handle there is time for the swing to come back
  const bool drops = record_.phase == Phase::drop;
  const double beside_m = drops ? off.horizontal_m : off.aim_m;
  const double within_m = drops ? settings_.release_m / 2 : settings_.aligned_m / 2;
  const bool may_lower =
      target_age_s() < settings_.oldest_s && beside_m < within_m + 0.15 * std::max(0.0, height_m);
  double wanted_rise_mps = std::clamp(2 * (wanted_height_m - height_m), -rate_mps, rate_mps);
  if (lowers && !may_lower) wanted_rise_mps = 0;
  rise_mps_ += std::clamp(wanted_rise_mps - rise_mps_, -smooth_mps2 * passed_s, smooth_mps2 * passed_s);
  height_m += rise_mps_ * passed_s;
  // a commanded height that the aircraft is far from would be made up for in one go
  height_m = std::clamp(height_m, off.height_m - 1.0, off.height_m + 1.0);
  height_m_ = height_m;

  if (record_.phase != Phase::load && record_.phase != Phase::drop) heading_rad_ = target_heading_rad();
  PointPath point = hook_goal(utime_);
  const Eigen::Vector2d shift_m = feeling_about_m(0);
  point.position_m.head<2>() += shift_m;
  const auto lag_us = static_cast<std::int64_t>(settings_.lag_s * 1e6);
  Eigen::Vector3d velocity_mps = hook_goal(utime_ + lag_us).velocity_mps;
  velocity_mps.head<2>() +=
      (feeling_about_m(settings_.lag_s + told_every_s) - feeling_about_m(settings_.lag_s)) / told_every_s;
  velocity_mps.head<2>() += damped_per_s * hanging_.swing_ned_m(settings_.lag_s + told_every_s / 2);
  const Eigen::Vector3d hook_m = point.position_m - Eigen::Vector3d(0, 0, height_m);
  if (record_.phase == Phase::load) work_jaws(off, shift_m.norm());
  if (record_.phase == Phase::drop && may_let_go(off)) opens_jaws_ = true;
  return {hook_m - hangs_ned_m(), velocity_mps - Eigen::Vector3d(0, 0, rise_mps_), heading_rad_};
}

/// Told to close while the hook is well inside of what they reach, and not to when it has swung out again:
/// what they catch at the edge of their reach slips off. A handle that is felt for may be as far off as that.
void Carry::work_jaws(const Miss& off, double felt_about_m) {
  constexpr double slow_mps = 0.2;      // two thirds of what they close at
  constexpr double swung_out_m = 0.12;  // their 0.08 m, and what the swing is known to
  const bool here = std::abs(off.height_m) < felt_m + 0.05 && target_age_s() < settings_.oldest_s;
  const double within_m = felt_about_m + (closes_jaws_ ? swung_out_m : settings_.grab_m);
  closes_jaws_ = here && off.horizontal_m < within_m && (closes_jaws_ || off.speed_mps < slow_mps);
  if (closes_jaws_ && !closing_since_) closing_since_ = utime_;
}

bool Carry::tries_hold() const {
  return in_phase_s() < settings_.hold_try_s && target_age_s() < settings_.oldest_s;
}

/// When the load cell tells that the deck carries the cargo; on what was said about its height alone only
/// when it is lower than that can be wrong.
bool Carry::may_let_go(const Miss& off) const {
  if (opens_jaws_ || target_age_s() > settings_.oldest_s) return opens_jaws_;
  const double radius_m = settings_.release_m * (1 + touches_off_);  // better there at last than never
  if (touch_) return touch_->off_ned_m.head<2>().norm() < radius_m;
  return off.height_m < 0.05 - press_m && off.horizontal_m < radius_m;
}

/// The jaws feel for a handle that is not where it was thought: a slow spiral out to where they could just
/// miss, or to where a cargo may stand whose rim was never made out: 0.4 radii from the middle.
Eigen::Vector2d Carry::feeling_about_m(double ahead_s) const {
  constexpr double patience_s = 5, turn_s = 8, growth_mps = 0.01;
  const double widest_m = knows_cargo_place() ? 0.08 : 0.2;  // 0.06 m/s, and 0.16
  const double felt_s = closing_since_ ? seconds(utime_ - *closing_since_) + ahead_s - patience_s : 0;
  if (felt_s <= 0) return Eigen::Vector2d::Zero();
  const double angle_rad = 2 * std::numbers::pi * felt_s / turn_s;
  return std::min(widest_m, growth_mps * felt_s) * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
}

double Carry::felt_height_m() const {
  return -felt_m * std::sin(2 * std::numbers::pi / felt_turn_s * seconds(utime_ - *closing_since_));
}

/// Where the platform that comes next is thought to be.
Eigen::Vector3d Carry::searched_place_m(std::int64_t utime) const {
  if (const DeckPath* course = deck(goal_platform())) return course->center(utime).position_m;
  return home_odometry_m_.value_or(now_->position_odometry_m);
}

/// The camera over the middle of the platform that comes next, or near over one of its circles; and when it
/// is not in view, along a spiral about where it is thought to be or where circles were seen.
Carry::Goal Carry::over_deck(double height_m) {
  constexpr double spiral_mps = 1.5, turns_apart_m = 6;  // from 7 m the image is 10 m high
  // a platform's own word of its height may be metres off: what is not found at once is looked for from
  // higher, as far as circles are still seen
  constexpr double rise_mps = 0.15, most_rise_m = 5;
  const DeckPath* course = deck(goal_platform());
  const bool seen = sees_deck();
  if (seen || !search_utime_) search_utime_ = utime_;
  Eigen::Vector3d place_m = searched_place_m(utime_);
  if (!seen && sighting_) place_m += sighting_->off_odometry_m;
  if (const auto slot = closer_slot(); slot && seen) {
    place_m = course->point(course->place_of(*slot), 0, utime_).position_m;
    height_m = settings_.closer_height_m;
  }
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero();
  if (course) velocity_mps.head<2>() = course->center(utime_).velocity_mps.head<2>();
  const Eigen::Vector2d ahead(std::cos(heading_rad_), std::sin(heading_rad_));
  Eigen::Vector3d aircraft_m = place_m;
  if (!seen) {
    const double searched_s = seconds(utime_ - *search_utime_);
    aircraft_m.head<2>() += spiral_m(spiral_mps * (searched_s - 4), turns_apart_m);
    height_m += std::clamp(rise_mps * (searched_s - 10), 0.0, most_rise_m);
  }
  aircraft_m.head<2>() -= settings_.camera_forward_m * ahead;
  aircraft_m.z() = deck_level_m(place_m.z()) - height_m - settings_.camera_down_m;
  // a platform's own word of its height may be metres off: while it is not seen, over what the laser meets as
  // well
  if (!seen && seconds(utime_ - ground_utime_) < 1)
    aircraft_m.z() = std::min(aircraft_m.z(), ground_m_ - height_m);
  return {aircraft_m, velocity_mps, heading_rad_};
}

/// A deck's mean height: its heave is not followed from far above.
double Carry::deck_level_m(double now_m) {
  constexpr double mean_over_s = 6;
  const bool first = level_utime_ == 0 || utime_ - level_utime_ > 1'000'000;
  const double share = first ? 1 : std::min(1.0, seconds(utime_ - level_utime_) / mean_over_s);
  level_utime_ = utime_;
  level_m_ += share * (now_m - level_m_);
  return level_m_;
}

Carry::Goal Carry::over_home(double height_m) {
  const Eigen::Vector3d home_m =
      pad_odometry_m_.value_or(home_odometry_m_.value_or(now_->position_odometry_m));
  Eigen::Vector3d aircraft_m = home_m;
  const bool lands = record_.phase == Phase::land;
  const double over_m = home_m.z() - now_->position_odometry_m.z();
  // the pad's height is known where its circle is in view; where the aircraft once stood, else
  aircraft_m.z() -= height_m;
  double sink_mps = 0;
  if (lands) {
    aircraft_m.z() = std::max(aircraft_m.z(), now_->position_odometry_m.z() + 0.3);
    sink_mps = over_m > height_m + 0.2 ? lower_mps : 0;
    if (over_m < height_m + 0.3) lands_ = true;
  }
  return {aircraft_m, {0, 0, sink_mps}, heading_rad_};
}

/// From the target towards the deck's middle: the camera, ahead of the hook, then looks at the other circles
/// when the target's own is below the nose.
double Carry::target_heading_rad() const {
  const DeckPath& course = *deck(record_.target->platform);
  const Eigen::Vector2d place_m = course.place_of(static_cast<std::size_t>(record_.target->slot));
  const Eigen::Vector2d inwards = -ned_from_deck(place_m, course.heading_rad(utime_));
  return std::atan2(inwards.y(), inwards.x());
}

}  // namespace stevedore
