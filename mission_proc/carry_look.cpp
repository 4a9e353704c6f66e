// What each phase waits for.
#include <fmt/format.h>

#include <algorithm>

#include "mission_proc/carry.hpp"

namespace stevedore {
namespace {

double seconds(std::int64_t us) {
  return static_cast<double>(us) * 1e-6;
}

/// All circles of a platform are looked at together for so long, then each for itself: three seconds to get
/// there, three to look.
constexpr double look_about_s = 8, closer_look_s = 6;

/// Longer than any of them takes when it goes well, by about half.
double longest_s(Phase phase) {
  switch (phase) {
    case Phase::take_off:
      return 30;
    case Phase::search:
      return 240;  // five times round on the spiral, and every circle looked at from near by
    case Phase::approach:
      return 45;
    case Phase::descend:
      return 40;
    case Phase::load:
      return 40;  // five times up and down while the spiral goes out; another approach takes 30 s
    case Phase::verify_load:
      return 60;  // when the hook tells nothing
    case Phase::transit:
      return 90;
    case Phase::drop:
      return 30;  // it is lowered only while the swing lets it
    case Phase::verify_drop:
      return 20;
    case Phase::retry:
      return 12;
    case Phase::go_home:
      return 120;
    default:
      return 1e9;
  }
}

}  // namespace

std::optional<Event> Carry::look() {
  std::optional<Event> event;
  switch (record_.phase) {
    case Phase::take_off:
      event = look_in_take_off();
      break;
    case Phase::search:
      event = look_in_search();
      break;
    case Phase::approach:
      event = look_in_approach();
      break;
    case Phase::descend:
      event = look_in_descend();
      break;
    case Phase::load:
      event = look_in_load();
      break;
    case Phase::verify_load:
      event = look_in_verify_load();
      break;
    case Phase::transit:
      event = look_in_transit();
      break;
    case Phase::drop:
      event = look_in_drop();
      break;
    case Phase::verify_drop:
      event = look_in_verify_drop();
      break;
    case Phase::retry:
      event = look_in_retry();
      break;
    case Phase::go_home:
      event = look_in_go_home();
      break;
    case Phase::land:
    case Phase::abort:
    case Phase::suspended:
      event = look_in_land();
      break;
    default:
      break;
  }
  if (!event && in_phase_s() > longest_s(record_.phase)) {
    say(fmt::format("{} took more than {:.0f} s", name_of(record_.phase), longest_s(record_.phase)));
    event = Event::late;
  }
  return event;
}

std::optional<Event> Carry::look_in_take_off() {
  const double height_m = home_odometry_m_ ? home_odometry_m_->z() - now_->position_odometry_m.z() : 0;
  if (height_m < 0.9 * settings_.take_off_height_m) return std::nullopt;
  say("in the air: looks for the platform to load from");
  return Event::airborne;
}

/// All that was to be carried is, or given up.
std::optional<Event> Carry::none_left() {
  const auto done = static_cast<int>(record_.delivered.size()) + record_.written_off;
  if (record_.loaded || done < settings_.cargoes) return std::nullopt;
  say(fmt::format("goes home: {} of {} delivered", record_.delivered.size(), settings_.cargoes));
  return Event::none_left;
}

/// When all circles in view at a time offer nothing, each is looked at from nearer by.
std::optional<std::size_t> Carry::closer_slot() const {
  const DeckPath* course = deck(goal_platform());
  if (record_.phase != Phase::search || !nothing_since_ || !course) return std::nullopt;
  const double looked_s = seconds(utime_ - *nothing_since_) - look_about_s;
  if (looked_s < 0) return std::nullopt;
  const auto slot = static_cast<std::size_t>(looked_s / closer_look_s);
  return slot < course->news().slots.size() ? std::optional(slot) : std::nullopt;
}

/// By slot: whether a cargo was set down there, or taken away, as far as slots have kept their numbers.
std::vector<bool> Carry::done_slots(const DeckPath& course) const {
  std::vector<bool> done(course.news().slots.size());
  const auto note = [&](const SlotId& id) {
    const auto slot = static_cast<std::size_t>(id.slot);
    if (id.platform == course.news().platform && slot < done.size())
      done[slot] = course.news().identity_certain;
  };
  if (!record_.loaded) std::for_each(record_.taken.begin(), record_.taken.end(), note);
  if (!record_.loaded) return done;
  for (const DeliveredCargo& cargo : record_.delivered) note(cargo.slot);
  return done;
}

ChoiceInputs Carry::choice_inputs(const DeckPath& course) const {
  ChoiceInputs inputs;
  inputs.deck = &course;
  inputs.utime = utime_;
  inputs.hook_odometry_m = hook_odometry_m().head<2>();
  inputs.loaded = record_.loaded;
  inputs.kept = kept_;
  inputs.wished = wished_;
  inputs.most_failures = settings_.attempts_per_slot;
  inputs.failures.resize(course.news().slots.size());
  for (const auto& [slot, failures] : record_.failures) {
    if (slot.platform == goal_platform() && static_cast<std::size_t>(slot.slot) < inputs.failures.size())
      inputs.failures[static_cast<std::size_t>(slot.slot)] = failures;
  }
  inputs.done = done_slots(course);
  return inputs;
}

std::optional<Event> Carry::look_in_search() {
  if (const auto event = none_left()) return event;
  candidates_.clear();
  if (goal_age_s() >= settings_.oldest_s) {
    nothing_since_.reset();
    return std::nullopt;
  }
  const DeckPath* course = deck(goal_platform());
  const auto slots = course->news().slots.size();
  const double all_looked_at_s = look_about_s + closer_look_s * static_cast<double>(slots);
  const bool all_looked_at = nothing_since_ && seconds(utime_ - *nothing_since_) >= all_looked_at_s;
  ChoiceInputs inputs = choice_inputs(*course);
  // that each circle had a cargo is believed when half of them did
  const bool one_in_each =
      static_cast<std::size_t>(settings_.cargoes) >= slots && 2 * record_.taken.size() >= slots;
  inputs.last_resort = all_looked_at && course->news().identity_certain && (record_.loaded || one_in_each);
  candidates_ = weigh_slots(inputs);
  const auto best =
      std::find_if(candidates_.begin(), candidates_.end(), [](const auto& c) { return c.chosen; });
  if (best != candidates_.end()) {
    // every circle is to be judged before one is chosen, but not for ever
    const bool all_known =
        std::none_of(course->news().slots.begin(), course->news().slots.end(),
                     [](const SlotReport& s) { return s.condition == SlotCondition::unknown; });
    if (!nothing_since_) nothing_since_ = utime_;
    if (!all_known && seconds(utime_ - *nothing_since_) < 5) return std::nullopt;
    record_.target = best->slot;
    if (wished_ == best->slot) wished_.reset();
    say(fmt::format("{} circle {} of platform {}: {} (cost {:.1f})",
                    record_.loaded ? "drops in" : "loads from", best->slot.slot, best->slot.platform,
                    best->reason, best->cost));
    return Event::chosen;
  }
  if (camera_height_m(*course) > settings_.inspect_height_m + 0.5)
    nothing_since_.reset();
  else if (!nothing_since_)
    nothing_since_ = utime_;
  if (!all_looked_at) return std::nullopt;
  say(record_.loaded ? "goes home: no free circle is left" : "goes home: no cargo is left that can be taken");
  return Event::none_left;
}

std::optional<Event> Carry::look_in_approach() {
  if (record_.loaded && light_since_ && seconds(utime_ - *light_since_) > 0.5) return Event::cargo_gone;
  if (!has_target_place()) return Event::unchosen;
  if (target_age_s() > settings_.blind_s) {
    say("the platform is out of view");
    return Event::blind;
  }
  const Miss off = miss();
  const double wanted_m = hook_height_at(settings_.approach_height_m);
  const bool still = off.horizontal_m < settings_.aligned_m && std::abs(off.height_m - wanted_m) < 0.3 &&
                     off.speed_mps < 0.4 && target_age_s() < settings_.oldest_s;
  if (!still) aligned_since_.reset();
  if (still && !aligned_since_) aligned_since_ = utime_;
  if (!still) return std::nullopt;
  const double held_s = seconds(utime_ - *aligned_since_);
  const bool place_known = record_.loaded || knows_cargo_place();
  if (held_s < (place_known ? settings_.aligned_s : 6.0)) return std::nullopt;
  if (!deck(record_.target->platform)->safe_to_lower() && held_s < 15) return std::nullopt;
  say(place_known ? "aligned: goes down"
                  : "aligned, but the cargo's rim was not made out: goes down over the circle's middle");
  return Event::aligned;
}

/// Nothing is lowered, taken or let go without the hook's word.
std::optional<Event> Carry::hook_is_silent() {
  say("the hook tells nothing: goes up again");
  return Event::blind;
}

std::optional<Event> Carry::look_in_descend() {
  if (!hook_) return hook_is_silent();
  // one that was set down beside the middle is lifted first
  const bool lifted = in_phase_s() > 2;
  if (record_.loaded && lifted && light_since_ && seconds(utime_ - *light_since_) > 0.5)
    return Event::cargo_gone;
  if (!has_target_place() || target_age_s() > settings_.blind_s) {
    say(fmt::format("nothing of the platform was seen for {:.1f} s: goes up again", settings_.blind_s));
    return Event::blind;
  }
  const Miss off = miss();
  if (off.aim_m > 4 * settings_.aligned_m + 0.2 * off.height_m) {
    say(fmt::format("{:.2f} m off the target's axis: goes up again", off.aim_m));
    return Event::misaligned;
  }
  if (off.height_m > settings_.clearance_m + 0.05 || off.height_m < settings_.clearance_m / 2 ||
      off.horizontal_m > settings_.aligned_m / 2)
    aligned_since_.reset();
  else if (!aligned_since_)
    aligned_since_ = utime_;
  if (!aligned_since_ || seconds(utime_ - *aligned_since_) < 0.3) return std::nullopt;
  say(record_.loaded ? "just above the circle: sets the cargo down" : "just above the handle: takes hold");
  return record_.loaded ? Event::low_loaded : Event::low;
}

std::optional<Event> Carry::look_in_load() {
  if (!hook_) return hook_is_silent();
  if (hook_->closed) {
    say("the jaws are closed: lifts");
    return Event::gripped;
  }
  if (!has_target_place() || target_age_s() > settings_.blind_s) return Event::blind;
  return std::nullopt;
}

std::optional<Event> Carry::look_in_verify_load() {
  if (hook_ && !hook_->closed && in_phase_s() > 0.5) return Event::slipped;
  const bool lifted = in_phase_s() > 3;
  if (lifted && light_since_ && seconds(utime_ - *light_since_) > 1) {
    say("the hook bears nothing: not loaded");
    return Event::slipped;
  }
  const bool up = in_phase_s() > settings_.hold_try_s + 3;  // a metre over its circle, at the least
  if (!up || !heavy_since_ || seconds(utime_ - *heavy_since_) < 0.5) return std::nullopt;
  const DeckPath* course = record_.target ? deck(record_.target->platform) : nullptr;
  const auto slot = record_.target ? static_cast<std::size_t>(record_.target->slot) : 0;
  if (course && slot < course->news().slots.size()) {
    const SlotReport& report = course->news().slots[slot];
    if (report.condition == SlotCondition::empty && report.seen_utime > phase_utime_) {
      say("loaded: the hook bears it, and its circle is empty");
      return Event::loaded;
    }
  }
  if (in_phase_s() < settings_.hold_try_s + 10) return std::nullopt;
  say("loaded: the hook bears it; its circle was not seen empty");
  return Event::loaded;
}

std::optional<Event> Carry::look_in_transit() {
  if (record_.loaded && light_since_ && seconds(utime_ - *light_since_) > 0.5) {
    say("the cargo is lost");
    return Event::cargo_gone;
  }
  if (const auto event = none_left()) return event;
  const DeckPath* course = deck(goal_platform());
  if (!course) return in_phase_s() > 3 ? std::optional(Event::arrived) : std::nullopt;
  const double way_m = (course->center(utime_).position_m - now_->position_odometry_m).head<2>().norm();
  if (way_m > 4 || in_phase_s() < 1) return std::nullopt;
  say(fmt::format("arrived: looks over platform {}", goal_platform()));
  return Event::arrived;
}

std::optional<Event> Carry::look_in_drop() {
  if (!hook_) return hook_is_silent();
  if (opens_jaws_ && !hook_->closed) {
    say(touch_ ? fmt::format("stands {:.2f} m off the circle's middle: let go",
                             touch_->off_ned_m.head<2>().norm())
               : "let go");
    return Event::released;
  }
  if (touch_ && !opens_jaws_ && seconds(utime_ - *light_since_) > 0.1) {
    say(fmt::format("touched down {:.2f} m off the circle's middle: goes up a little",
                    touch_->off_ned_m.head<2>().norm()));
    return Event::misaligned;
  }
  if (!has_target_place() || target_age_s() > settings_.blind_s) return Event::blind;
  return std::nullopt;
}

std::optional<Event> Carry::look_in_verify_drop() {
  const DeckPath* course = record_.target ? deck(record_.target->platform) : nullptr;
  const auto slot = record_.target ? static_cast<std::size_t>(record_.target->slot) : 0;
  const bool circles_known = course && slot < course->news().slots.size();
  const SlotReport report = circles_known ? course->news().slots[slot] : SlotReport{};
  const auto cargo = circles_known ? places_.at(*record_.target) : std::nullopt;
  const bool seen_since = report.seen_utime > phase_utime_ + 1'000'000;
  const double waited_s = in_phase_s();
  if (seen_since && cargo && cargo->sightings >= 5 && waited_s > 3) {
    const double off_m = cargo->offset_m.norm();
    say(fmt::format("the cargo stands {:.2f} m off the circle's middle", off_m));
    return off_m < 0.5 ? Event::placed : Event::misplaced;  // the paper's circle has a radius of 0.5 m
  }
  if (waited_s < 8 || !seen_since) {
    if (waited_s < 18) return std::nullopt;
    say("nobody saw where the cargo went");
    return Event::misplaced;
  }
  if (report.condition == SlotCondition::occupied) {
    say("the cargo stands in its circle");
    return Event::placed;
  }
  if (waited_s < 12) return std::nullopt;
  say("the cargo does not stand in its circle");
  return Event::misplaced;
}

std::optional<Event> Carry::look_in_retry() {
  if (in_phase_s() < 2) return std::nullopt;
  if (!has_target_place()) return in_phase_s() > 5 ? std::optional(Event::clear) : std::nullopt;
  return miss().height_m > hook_height_at(settings_.approach_height_m) - 0.2 ? std::optional(Event::clear)
                                                                             : std::nullopt;
}

std::optional<Event> Carry::look_in_go_home() {
  if (!home_odometry_m_) return std::nullopt;
  const Eigen::Vector3d there_m = pad_odometry_m_.value_or(*home_odometry_m_);
  const double way_m = (there_m - now_->position_odometry_m).head<2>().norm();
  const bool over = way_m < (pad_odometry_m_ ? 0.3 : 1.0);
  if (!over) aligned_since_.reset();
  if (over && !aligned_since_) aligned_since_ = utime_;
  const double wait_s = pad_odometry_m_ ? 1.5 : 10.0;
  if (!over || seconds(utime_ - *aligned_since_) < wait_s) return std::nullopt;
  say(pad_odometry_m_ ? "over the pad's circle: lands"
                      : "the pad's circle is not seen: lands where it took off");
  return Event::arrived;
}

std::optional<Event> Carry::look_in_land() {
  const bool landed = autopilot_ && autopilot_->landed && in_phase_s() > 2;
  if (!landed) return std::nullopt;
  say(fmt::format("landed: {} delivered", record_.delivered.size()));
  return Event::landed;
}

}  // namespace stevedore
