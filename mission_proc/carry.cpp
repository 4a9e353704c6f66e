#include "mission_proc/carry.hpp"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace stevedore {
namespace {

double seconds(std::int64_t us) {
  return static_cast<double>(us) * 1e-6;
}

/// How far from a platform's middle, or the pad's, a mark may be and be one of its own: half a deck of 5 m,
/// and what both places are off.
constexpr double own_place_m = 4;

bool is_in_air(Phase phase) {
  return phase != Phase::idle && phase != Phase::complete && phase != Phase::suspended;
}

/// A mission that was killed goes on with the same step, or with the one before it where the step needs what
/// only its beginning knows.
Phase resumed(Phase phase) {
  switch (phase) {
    case Phase::approach:
    case Phase::descend:
    case Phase::load:
    case Phase::drop:
    case Phase::retry:
      return Phase::retry;
    default:
      return phase;
  }
}

}  // namespace

Carry::Carry(const CarrySettings& settings, const std::optional<CarryRecord>& restored)
    : settings_(settings), hanging_(settings) {
  board_.set_delay(Emergency::platform_not_found, {30, 0});
  board_.set_delay(Emergency::identity_uncertain, {1, 1});
  board_.set_delay(Emergency::altitude_disagrees, {1, 1});
  board_.set_delay(Emergency::cargo_lost, {0, 10});  // it stays to be read
  board_.set_delay(Emergency::camera_frozen, {0, 0});
  board_.set_delay(Emergency::target_lost, {0, 0.2});
  if (!restored) return;
  record_ = *restored;
  record_.phase = resumed(restored->phase);
  may_have_let_go_ = restored->phase == Phase::drop;
  say(fmt::format("goes on after a restart: {}", name_of(record_.phase)));
}

// ---- what is told ----

void Carry::hear(const VehicleSample& vehicle) {
  if (vehicle.utime < utime_ - 1'000'000) forget_stream();
  const double passed_s = utime_ > 0 ? std::clamp(seconds(vehicle.utime - utime_), 0.0, 0.2) : 0;
  if (utime_ == 0) phase_utime_ = vehicle.utime;
  utime_ = std::max(utime_, vehicle.utime);
  vehicle_.add(vehicle);
  // what stood on the deck, its rope slack, begins to swing anew when it is lifted again
  hanging_.hear(vehicle, record_.loaded && heavy_since_);
  now_ = vehicle_.at(utime_);
  if (!now_) return;
  velocity_mps_ += std::min(1.0, passed_s / 0.2) * (vehicle.velocity_ned_mps - velocity_mps_);
  if (!home_odometry_m_ && record_.phase != Phase::idle) {  // after a restart
    home_odometry_m_ = record_.home_ned_m - now_->ned_from_odometry_m;
    heading_rad_ = hanging_.heading_rad();
  }
  note_silence(passed_s);
  tick();
  guide(passed_s);
}

/// Another stream: nothing that is known belongs to it, and no time that was noted.
void Carry::forget_stream() {
  vehicle_ = VehicleHistory();
  decks_.clear();
  numbered_.clear();
  places_ = CargoPlaces();
  board_.clear();
  home_odometry_m_.reset();
  pad_odometry_m_.reset();
  stay_odometry_m_.reset();
  target_track_.reset();
  touch_.reset();
  sighting_.reset();
  height_m_.reset();
  last_frame_ = {};
  for (auto* since :
       {&aligned_since_, &light_since_, &heavy_since_, &nothing_since_, &closing_since_, &search_utime_})
    since->reset();
  utime_ = ground_utime_ = pad_utime_ = level_utime_ = unchanged_since_ = 0;
  hook_silent_s_ = autopilot_silent_s_ = 0;
}

/// What a hook said that tells nothing any more is not known. Time in which nobody told anything counts
/// little.
void Carry::note_silence(double passed_s) {
  constexpr double longest_s = 1;  // ten of its messages
  hook_silent_s_ += passed_s;
  autopilot_silent_s_ += passed_s;
  if (!hook_ || hook_silent_s_ <= longest_s) return;
  hook_.reset();
  touch_.reset();
  light_since_.reset();
  heavy_since_.reset();
}

void Carry::hear(const HookReport& hook) {
  hook_ = hook;
  hook_silent_s_ = 0;
  if (may_have_let_go_ && !hook.closed) {  // killed after the jaws opened, before that was written down
    record_.phase = Phase::drop;
    fire(Event::released);
  }
  may_have_let_go_ = false;
  if (!hook.closed && !record_.loaded && empty_readings_ < 50) {
    ++empty_readings_;
    empty_load_n_ += (hook.load_n - empty_load_n_) / empty_readings_;
  }
  const bool light = hook.load_n - empty_load_n_ < settings_.loaded_n;
  auto& running = light ? light_since_ : heavy_since_;
  (light ? heavy_since_ : light_since_).reset();
  if (!running && utime_ > 0) running = utime_;
  feel_touch();
}

void Carry::hear_laser(std::int64_t utime, double range_m) {
  const auto moment = vehicle_.at(utime);
  if (!moment) return;
  const Eigen::Matrix3d axes = moment->ned_from_body.toRotationMatrix();
  const Eigen::Vector3d arm_m(settings_.altimeter_forward_m, settings_.altimeter_right_m,
                              settings_.altimeter_down_m);
  const Eigen::Vector3d laser_m = moment->position_odometry_m + axes * arm_m, beam = axes.col(2);
  watch_laser(utime, range_m, laser_m, beam);
  // beside a deck it falls on the sea, and on the deck again
  constexpr double mean_over_s = 2;
  const double met_m = laser_m.z() + range_m * beam.z(), passed_s = seconds(utime - ground_utime_);
  ground_m_ += std::clamp(passed_s / mean_over_s, 0.0, 1.0) * (met_m - ground_m_);
  ground_utime_ = utime;
}

void Carry::hear(const AutopilotReport& autopilot) {
  autopilot_ = autopilot;
  autopilot_silent_s_ = 0;
}

void Carry::hear(const DeckNews& report) {
  const auto moment = vehicle_.at(report.utime);
  if (!moment || report.knots.empty()) return;
  const DeckPath course(report, *moment);
  if (!report.slots.empty()) {
    follow_numbers(course, report.utime);
    numbered_.insert_or_assign(report.platform, course);
  }
  decks_.insert_or_assign(report.platform, course);
}

/// When a platform's circles get other numbers, what is remembered by number goes along with the circle: told
/// by where it lies about the deck's middle, since all of a deck may be found elsewhere than it was thought
/// to be.
void Carry::follow_numbers(const DeckPath& after, std::int64_t utime) {
  constexpr double elsewhere_m = 0.5;  // half of what two circles are apart at least
  const int platform = after.news().platform;
  const auto found = numbered_.find(platform);
  if (found == numbered_.end()) return;
  const DeckPath& before = found->second;
  const auto about_middle = [utime](const DeckPath& course, std::size_t slot) {
    return ned_from_deck(course.place_of(slot), course.heading_rad(utime));
  };
  const std::size_t old_count = before.news().slots.size(), count = after.news().slots.size();
  std::map<SlotId, SlotId> renumbered;
  for (std::size_t old_slot = 0; old_slot < old_count; ++old_slot)
    for (std::size_t slot = 0; slot < count; ++slot)
      if ((about_middle(after, slot) - about_middle(before, old_slot)).norm() < elsewhere_m &&
          slot != old_slot)
        renumbered[{platform, static_cast<int>(old_slot)}] = {platform, static_cast<int>(slot)};
  const auto place = [utime](const DeckPath& course) {
    return Eigen::Vector2d(course.point(course.place_of(0), 0, utime).position_m.head<2>());
  };
  if (old_count != count || (place(before) - place(after)).norm() >= elsewhere_m)
    places_.forget_platform(platform);  // what stands there is looked at again
  if (!renumbered.empty()) renumber(renumbered);
}

void Carry::renumber(const std::map<SlotId, SlotId>& renumbered) {
  const auto now = [&renumbered](SlotId id) {
    const auto found = renumbered.find(id);
    return found == renumbered.end() ? id : found->second;
  };
  for (auto* id : {&record_.target, &kept_, &wished_})
    if (*id) *id = now(**id);
  for (DeliveredCargo& cargo : record_.delivered) cargo.slot = now(cargo.slot);
  for (SlotId& id : record_.taken) id = now(id);
  std::map<SlotId, int> failures;
  for (const auto& [id, times] : record_.failures) failures[now(id)] += times;
  record_.failures = std::move(failures);
  ++record_number_;
}

/// How far beside their places the deck's circles are seen in a frame, per metre of depth: an error of
/// attitude turns all marks about the camera alike. Nothing where no circle is seen.
std::optional<Eigen::Vector2d> Carry::turned_by(const DeckPath& course, const LevelFrame& frame,
                                                const VehicleMoment& moment) const {
  constexpr double own_m = 0.4;
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (const LevelMark& mark : frame.marks) {
    if (mark.label != Label::circle || mark.from_camera_level_m.z() <= 0) continue;
    for (std::size_t slot = 0; slot < course.news().slots.size(); ++slot) {
      const Eigen::Vector3d known_m = course.point(course.place_of(slot), 0, frame.utime).position_m;
      const Eigen::Vector3d off_m = odometry_of(mark, moment) - known_m;
      if (off_m.norm() > own_m) continue;
      sum += off_m.head<2>() / mark.from_camera_level_m.z();
      ++count;
    }
  }
  return count > 0 ? std::optional<Eigen::Vector2d>(sum / count) : std::nullopt;
}

/// Where on their deck the cargoes of a frame stand.
void Carry::see_cargoes(const DeckPath& course, const LevelFrame& frame, const VehicleMoment& moment) {
  constexpr double attitude_rad = 0.0175,
                   attitude_left_rad = 0.005;  // one degree; what circles beside it leave of it
  const auto turned = turned_by(course, frame, moment);
  for (const LevelMark& mark : frame.marks) {
    if (mark.label != Label::cargo) continue;
    Eigen::Vector3d rim_m = odometry_of(mark, moment);
    if (turned) rim_m.head<2>() -= mark.from_camera_level_m.z() * *turned;
    const auto place =
        course.place_below(camera_odometry_m(moment), rim_m, settings_.rim_over_deck_m, frame.utime);
    if (!place) continue;
    const double by_attitude_m =
        (turned ? attitude_left_rad : attitude_rad) * mark.from_camera_level_m.norm();
    for (std::size_t slot = 0; slot < course.news().slots.size(); ++slot) {
      constexpr double own_m = 0.6;  // half of what two circles are apart at least
      const Eigen::Vector2d off_m = *place - course.place_of(slot);
      const SlotId id{course.news().platform, static_cast<int>(slot)};
      const bool hangs_there = record_.phase == Phase::verify_load && record_.target == id;
      if (off_m.norm() < own_m && !hangs_there)
        places_.see(id, off_m, by_attitude_m * by_attitude_m + mark.across_variance_m2);
    }
  }
}

void Carry::see(const LevelFrame& frame) {
  const auto moment = vehicle_.at(frame.utime);
  if (!moment) return;
  watch_frames(frame);
  look_for_pad(frame);
  look_for_circles(frame);
  for (const auto& [platform, course] : decks_)
    if (course.age_s(frame.utime) < 0.5) see_cargoes(course, frame, *moment);
  target_track_.reset();
  if (!has_target_place()) return;
  const DeckPath* course = deck(record_.target->platform);
  const Eigen::Vector3d there_m =
      course->point(course->place_of(static_cast<std::size_t>(record_.target->slot)), 0, frame.utime)
          .position_m;
  double nearest_m = 0.4;
  for (const LevelMark& mark : frame.marks) {
    if (mark.label != Label::circle) continue;
    const double off_m = (odometry_of(mark, *moment) - there_m).norm();
    if (off_m < nearest_m) nearest_m = off_m, target_track_ = mark.track_id;
  }
}

// ---- the operator ----

void Carry::start() {
  if (!now_ || record_.phase != Phase::idle) return;
  if (!(autopilot_ && autopilot_->guided)) {
    say("not started: the autopilot does not tell that it is in guided mode");
    return;
  }
  home_odometry_m_ = now_->position_odometry_m;
  heading_rad_ = hanging_.heading_rad();
  record_.home_ned_m = now_->position_odometry_m + now_->ned_from_odometry_m;
  record_.homeward = false;
  fire(Event::start);
}

void Carry::hold() {
  fire(Event::hold);
  if (record_.phase == Phase::hold) say("held by the operator");
}

void Carry::abort() {
  if (record_.phase == Phase::idle || record_.phase == Phase::complete) return;
  if (!record_.homeward) ++record_number_;
  record_.homeward = true;
  fire(Event::abort);
  if (record_.phase == Phase::abort) say("aborted by the operator: nothing more is carried");
}

void Carry::resume() {
  if (record_.phase == Phase::suspended && !(autopilot_ && autopilot_->guided)) {
    say("not resumed: the autopilot is not in guided mode");
    return;
  }
  const Phase before = record_.phase;
  fire(record_.homeward ? Event::resume_home : Event::resume);
  if (record_.phase != before) say("resumed by the operator");
}

void Carry::wish(SlotId slot) {
  if (slot.platform < 0 || slot.slot < 0)
    say("the operator's choice names no circle: it wants platform and slot");
  else
    wished_ = slot;
}

// ---- one step of time ----

void Carry::tick() {
  obey_autopilot();
  if (record_.phase == Phase::idle && settings_.start_at_once && autopilot_ && autopilot_->guided) start();
  watch_target();
  if (const auto event = look()) fire(*event);
}

void Carry::obey_autopilot() {
  const bool obeys =
      autopilot_ && (autopilot_->guided || (autopilot_->lands && record_.phase == Phase::land));
  if (autopilot_ && !obeys && is_in_air(record_.phase)) {
    say("another pilot flies: the autopilot is not in guided mode");
    fire(Event::other_pilot);
  }
  constexpr double silent_s = 3;  // six of its messages
  if (autopilot_ && autopilot_silent_s_ > silent_s && is_in_air(record_.phase)) {
    say(fmt::format("the autopilot's mode is not known: it has told none for {:.0f} s", silent_s));
    fire(Event::other_pilot);
  }
  const bool on_the_way = is_in_air(record_.phase) && record_.phase != Phase::go_home &&
                          record_.phase != Phase::land && record_.phase != Phase::abort;
  if (!on_the_way) return;
  const bool low = autopilot_ && autopilot_->battery_share < settings_.battery_floor;
  const double from_home_m =
      home_odometry_m_ ? (now_->position_odometry_m - *home_odometry_m_).head<2>().norm() : 0;
  if (!low && from_home_m < settings_.fence_m) return;
  say(low ? fmt::format("goes home: battery below {:.0f} %", 100 * settings_.battery_floor)
          : fmt::format("goes home: more than {:.0f} m from it", settings_.fence_m));
  record_.homeward = true;
  fire(Event::must_go_home);
}

void Carry::fire(Event event) {
  const Phase next = after(record_.phase, event);
  if (next == record_.phase) return;
  take_effect(event);
  record_.phase = next;
  phase_utime_ = utime_;
  ++record_number_;
  aligned_since_.reset();
  nothing_since_.reset();
  if (next == Phase::load) ++record_.attempts;
  if (next == Phase::drop && record_.target) places_.forget(*record_.target);
  if (next == Phase::search) {
    kept_ = record_.target;
    record_.target.reset();
    touches_off_ = 0;
  }
  if (next == Phase::go_home) record_.homeward = true;
  closes_jaws_ = opens_jaws_ = lands_ = false;
  closing_since_.reset();
  if (next != Phase::verify_drop) touch_.reset();
  search_utime_.reset();
  sighting_.reset();
  stay_odometry_m_ = now_ ? std::optional(now_->position_odometry_m) : std::nullopt;
  climbed_m_ = 0;
  height_m_ = has_target_place() ? std::optional(miss().height_m) : std::nullopt;
  rise_mps_ = 0;
}

void Carry::fail_target() {
  if (record_.target) ++record_.failures[*record_.target];
}

void Carry::note_loaded() {
  record_.loaded = true;
  if (record_.target) {
    places_.forget(*record_.target);
    record_.taken.push_back(*record_.target);
  }
  record_.target.reset();
}

void Carry::note_delivered() {
  const auto place = record_.target ? places_.at(*record_.target) : std::nullopt;
  record_.delivered.push_back({record_.target.value_or(SlotId{}), place ? place->offset_m.norm() : -1});
  record_.target.reset();
}

/// What was being verified when something else came first: what hangs is a cargo, and what was let go over a
/// circle stands in it, as far as anybody can tell.
void Carry::settle() {
  if (record_.phase == Phase::verify_load && heavy_since_) note_loaded();
  if (record_.phase == Phase::verify_drop) note_delivered();
}

/// What an event means for what is remembered.
void Carry::take_effect(Event event) {
  const bool hands_on = record_.phase == Phase::descend || record_.phase == Phase::load ||
                        record_.phase == Phase::drop || record_.phase == Phase::approach;
  switch (event) {
    case Event::gripped:
      if (has_target_place()) learn_hook(hook_miss_ned_m(), hanging_.heading_rad());
      break;
    case Event::loaded:
      note_loaded();
      break;
    case Event::slipped:
      fail_target();
      break;
    case Event::misaligned:
    case Event::blind:
    case Event::late:
      if (event == Event::misaligned && record_.phase == Phase::drop)
        ++touches_off_;  // set down again at once: nothing has failed yet
      else if (hands_on && record_.phase != Phase::approach)
        fail_target();
      break;
    case Event::released:
      record_.loaded = false;
      break;
    case Event::cargo_gone:
      record_.loaded = false;
      board_.set(Emergency::cargo_lost, true, seconds(utime_), "the hook bears nothing any more");
      if (!hands_on || record_.phase == Phase::approach) ++record_.written_off;
      break;
    case Event::placed:
      learn_from_drop();
      note_delivered();
      break;
    case Event::misplaced:
      ++record_.written_off;
      record_.target.reset();
      break;
    case Event::hold:
    case Event::abort:
    case Event::must_go_home:
    case Event::other_pilot:
      settle();
      break;
    default:
      break;
  }
}

// ---- where things are ----

const DeckPath* Carry::deck(int platform) const {
  const auto found = decks_.find(platform);
  return found == decks_.end() ? nullptr : &found->second;
}

int Carry::goal_platform() const {
  return record_.loaded ? settings_.drop_platform : settings_.load_platform;
}

double Carry::goal_age_s() const {
  const DeckPath* course = deck(goal_platform());
  return course && !course->news().slots.empty() ? course->age_s(utime_) : HUGE_VAL;
}

bool Carry::sees_deck() const {
  constexpr double a_moment_s = 3;
  return goal_age_s() < a_moment_s;
}

double Carry::camera_height_m(const DeckPath& course) const {
  return course.center(utime_).position_m.z() - now_->position_odometry_m.z() - settings_.camera_down_m;
}

bool Carry::has_target_place() const {
  const DeckPath* course = record_.target ? deck(record_.target->platform) : nullptr;
  return course && static_cast<std::size_t>(record_.target->slot) < course->news().slots.size();
}

PointPath Carry::hook_goal(std::int64_t utime) const {
  const double handle_m = settings_.rim_over_deck_m + settings_.handle_over_rim_m;
  const SlotId target = *record_.target;
  const DeckPath& course = *deck(target.platform);
  Eigen::Vector2d place = course.place_of(static_cast<std::size_t>(target.slot));
  const auto cargo = places_.at(target);
  if (!record_.loaded && target.platform == settings_.load_platform && cargo) place += cargo->offset_m;
  return course.point(place, handle_m, utime);
}

double Carry::hook_height_at(double camera_height_m) const {
  return camera_height_m + settings_.camera_down_m - settings_.hook_down_m - settings_.rope_m -
         settings_.rim_over_deck_m - settings_.handle_over_rim_m;
}

Eigen::Vector3d Carry::hook_odometry_m() const {
  Eigen::Vector3d hook_m = now_->position_odometry_m + hangs_ned_m();
  hook_m.head<2>() += hanging_.swing_ned_m();
  return hook_m;
}

Eigen::Vector3d Carry::hangs_ned_m() const {
  Eigen::Vector3d hangs_m = hanging_.mean_ned_m();
  hangs_m.head<2>() += ned_from_deck(record_.hook_off_m.head<2>(), hanging_.heading_rad());
  hangs_m.z() += record_.hook_off_m.z();
  return hangs_m;
}

Eigen::Vector3d Carry::hook_miss_ned_m() const {
  return hook_odometry_m() - hook_goal(utime_).position_m;
}

bool Carry::knows_cargo_place() const {
  constexpr int enough = 8;
  const auto cargo = record_.target ? places_.at(*record_.target) : std::nullopt;
  return cargo && cargo->sightings >= enough;
}

double Carry::target_age_s() const {
  const DeckPath* course = record_.target ? deck(record_.target->platform) : nullptr;
  return course ? course->age_s(utime_) : 1e9;
}

Carry::Miss Carry::miss() const {
  const PointPath goal = hook_goal(utime_);
  const Eigen::Vector3d off_m = hook_miss_ned_m();
  Eigen::Vector3d speed_mps = velocity_mps_ - goal.velocity_mps;
  speed_mps.head<2>() = hanging_.velocity_ned_mps() - goal.velocity_mps.head<2>();
  return {(off_m.head<2>() - hanging_.swing_ned_m()).norm(), off_m.head<2>().norm(), -off_m.z(),
          speed_mps.norm()};
}

/// A cargo that stands stays where it touched, whatever the aircraft does then on its slack rope.
void Carry::feel_touch() {
  if (record_.phase != Phase::drop || opens_jaws_) return;
  if (!light_since_ || !now_ || !has_target_place())
    touch_.reset();
  else if (!touch_)
    touch_ = Touch{hook_miss_ned_m(), hanging_.heading_rad()};
}

/// Camera, hook and rope are where they are told to be to 0.02 m each, and what is wrong with that stays the
/// same in the aircraft's own axes: a hook that took hold, or set down, shows it to some centimetres. The
/// mean of what was so learnt, with one lesson of nought beforehand.
void Carry::learn_hook(const Eigen::Vector3d& off_ned_m, double heading_rad) {
  constexpr double most_m = 0.15;  // more is no lever arm
  if (off_ned_m.norm() > most_m) return;
  ++record_.hook_lessons;
  Eigen::Vector3d lesson_m = off_ned_m;
  lesson_m.head<2>() = deck_from_ned(off_ned_m.head<2>(), heading_rad);
  record_.hook_off_m -= lesson_m / (1 + record_.hook_lessons);
}

/// Where a cargo was thought to touch against where it stands now.
void Carry::learn_from_drop() {
  const auto cargo = record_.target ? places_.at(*record_.target) : std::nullopt;
  if (!touch_ || !cargo || !has_target_place()) return;
  Eigen::Vector3d wrong_m = touch_->off_ned_m;
  wrong_m.head<2>() -= ned_from_deck(cargo->offset_m, deck(record_.target->platform)->heading_rad(utime_));
  learn_hook(wrong_m, touch_->heading_rad);
}

Eigen::Vector3d Carry::camera_odometry_m(const VehicleMoment& moment) const {
  const Eigen::Vector3d arm_m(settings_.camera_forward_m, settings_.camera_right_m, settings_.camera_down_m);
  return moment.position_odometry_m + moment.ned_from_body * arm_m;
}

Eigen::Vector3d Carry::odometry_of(const LevelMark& mark, const VehicleMoment& moment) const {
  const Eigen::Matrix3d axes = moment.ned_from_body.toRotationMatrix();
  const double heading_rad = std::atan2(axes(1, 0), axes(0, 0));
  const Eigen::Vector3d& level_m = mark.from_camera_level_m;
  const Eigen::Vector2d out_m = ned_from_deck({-level_m.y(), level_m.x()}, heading_rad);
  return camera_odometry_m(moment) + Eigen::Vector3d(out_m.x(), out_m.y(), level_m.z());
}

/// Whether a point is on a known platform, `but` aside.
bool Carry::is_on_deck(const Eigen::Vector3d& point_odometry_m, std::int64_t utime,
                       std::optional<int> but) const {
  return std::any_of(decks_.begin(), decks_.end(), [&](const auto& entry) {
    const Eigen::Vector3d off_m = entry.second.center(utime).position_m - point_odometry_m;
    return entry.first != but && off_m.head<2>().norm() < own_place_m;
  });
}

/// A circle near where the aircraft took off, and on no platform. One that was found and is not seen again
/// while another one is was none.
void Carry::look_for_pad(const LevelFrame& frame) {
  const bool homing = record_.phase == Phase::go_home || record_.phase == Phase::land;
  const auto moment = vehicle_.at(frame.utime);
  if (!homing || !home_odometry_m_ || !moment) return;
  constexpr double about_home_m = 6;  // odometry is off by a metre in an hour; after a restart by what GPS is
  constexpr double about_height_m = 4;  // the same, and the aircraft's own height
  constexpr std::int64_t unseen_us = 1'000'000;
  const bool known =
      pad_odometry_m_ && (record_.phase == Phase::land || frame.utime - pad_utime_ < unseen_us);
  const Eigen::Vector3d expected_m = known ? *pad_odometry_m_ : *home_odometry_m_;
  double nearest_m = known ? 1.0 : about_home_m;
  for (const LevelMark& mark : frame.marks) {
    if (mark.label != Label::circle) continue;
    const Eigen::Vector3d there_m = odometry_of(mark, *moment);
    const double off_m = (there_m - expected_m).head<2>().norm();
    if (off_m > nearest_m || std::abs(there_m.z() - home_odometry_m_->z()) > about_height_m ||
        is_on_deck(there_m, frame.utime))
      continue;
    nearest_m = off_m;
    pad_odometry_m_ =
        known ? Eigen::Vector3d(*pad_odometry_m_ + 0.2 * (there_m - *pad_odometry_m_)) : there_m;
    pad_utime_ = frame.utime;
  }
}

/// Of a platform that is searched for some circles may be in view, too few to tell it by: it is there that
/// the rest has to be looked for. What makes no platform in ten seconds is none.
void Carry::look_for_circles(const LevelFrame& frame) {
  constexpr std::size_t fewest = 2;  // one alone is now and then nothing but foam
  constexpr double about_m = 15;     // platforms are so far apart; less what both positions are off
  constexpr double patience_s = 10;
  const auto moment = vehicle_.at(frame.utime);
  const bool searching = record_.phase == Phase::search || record_.phase == Phase::transit;
  if (!searching || !search_utime_ || sees_deck() || !moment) return;
  const Eigen::Vector3d place_m = searched_place_m(frame.utime);
  Eigen::Vector3d sum_m = Eigen::Vector3d::Zero();
  std::size_t count = 0;
  for (const LevelMark& mark : frame.marks) {
    if (mark.label != Label::circle) continue;
    const Eigen::Vector3d there_m = odometry_of(mark, *moment);
    const bool is_home = home_odometry_m_ && (*home_odometry_m_ - there_m).head<2>().norm() < own_place_m;
    const bool is_far = (place_m - there_m).head<2>().norm() > about_m;
    if (is_home || is_far || is_on_deck(there_m, frame.utime, goal_platform())) continue;
    sum_m += there_m;
    ++count;
  }
  if (count < fewest) return;
  if (!sighting_) sighting_ = Sighting{Eigen::Vector3d::Zero(), frame.utime};
  if (seconds(frame.utime - sighting_->first_utime) > patience_s) return;
  sighting_->off_odometry_m = sum_m / static_cast<double>(count) - place_m;
  search_utime_ = utime_;  // the spiral begins anew, about them
}

// ---- what comes out ----

std::optional<Setpoint> Carry::setpoint() const {
  if (!goal_ || !now_) return std::nullopt;
  return Setpoint{goal_->aircraft_odometry_m + now_->ned_from_odometry_m, goal_->velocity_mps,
                  goal_->heading_rad};
}

std::optional<CarryTarget> Carry::target(std::int64_t utime) const {
  const auto moment = vehicle_.at(utime);
  if (!has_target_place() || !moment) return std::nullopt;
  const DeckPath* course = deck(record_.target->platform);
  const auto slot = static_cast<std::size_t>(record_.target->slot);
  const PointPath point = course->point(course->place_of(slot), 0, utime);
  const Eigen::Matrix3d axes = moment->ned_from_body.toRotationMatrix();
  const Eigen::Vector3d arm_m(settings_.camera_forward_m, settings_.camera_right_m, settings_.camera_down_m);
  const Eigen::Vector3d from_camera_m = point.position_m - moment->position_odometry_m - axes * arm_m;
  const Eigen::Vector2d ahead = deck_from_ned(from_camera_m.head<2>(), std::atan2(axes(1, 0), axes(0, 0)));
  CarryTarget target;
  target.slot = *record_.target;
  target.from_camera_level_m = {ahead.y(), -ahead.x(), from_camera_m.z()};
  target.covariance_ned_m2 = course->news().slots[slot].covariance_m2;
  Eigen::Matrix3d level_from_ned = Eigen::Matrix3d::Identity();
  const double heading_rad = std::atan2(axes(1, 0), axes(0, 0)), c = std::cos(heading_rad),
               s = std::sin(heading_rad);
  level_from_ned.topLeftCorner<2, 2>() << -s, c, -c, -s;  // right, back
  target.covariance_level_m2 = level_from_ned * target.covariance_ned_m2 * level_from_ned.transpose();
  target.ned_m = point.position_m + moment->ned_from_odometry_m;
  target.velocity_ned_mps = point.velocity_mps;
  target.age_s = course->age_s(utime);
  return target;
}

bool Carry::expects_marks() const {
  return record_.phase == Phase::approach || record_.phase == Phase::verify_drop;
}

}  // namespace stevedore
