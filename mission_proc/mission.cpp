#include "mission_proc/mission.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

namespace stevedore {
namespace {

const char* name_of(Label label) {
  switch (label) {
    case Label::unknown:
      return "unknown thing";
    case Label::circle:
      return "circle";
    case Label::cargo:
      return "cargo";
  }
  return "";
}

/// Why a mark can't be a target; empty: it can.
std::string objection(const Mark& mark, const MissionSettings& settings) {
  if (mark.label != Label::circle) return fmt::format("is a {}", name_of(mark.label));
  if (!mark.measured) return "is only predicted";
  if (mark.coverage < settings.min_coverage) {
    return fmt::format("shows {:.0f} % of its edge, {:.0f} wanted", 100 * mark.coverage,
                       100 * settings.min_coverage);
  }
  if (mark.age_frames < settings.min_age_frames) {
    return fmt::format("followed for {} frames, {} wanted", mark.age_frames, settings.min_age_frames);
  }
  return {};
}

/// Why the camera is not held level; empty: it is, or nobody knows.
std::string unlevel_cause(const CameraHold& level, const MissionSettings& settings) {
  if (level.gimbal == GimbalCondition::stuck) return "the pan-tilt does not follow its commands";
  if (level.gimbal == GimbalCondition::late) return "the pan-tilt does not say how it stands";
  if (level.off_level_rad.value_or(0) <= settings.off_level_deg * std::numbers::pi / 180) return {};
  return fmt::format("the camera is more than {:.1f} deg off level{}", settings.off_level_deg,
                     level.gimbal == GimbalCondition::at_limit ? ": the pan-tilt is at its limit" : "");
}

const Mark* find(const std::vector<Mark>& marks, int64_t track_id) {
  const auto found =
      std::find_if(marks.begin(), marks.end(), [&](const Mark& m) { return m.track_id == track_id; });
  return found == marks.end() ? nullptr : &*found;
}

}  // namespace

void Mission::start_clock(double time_s) {
  time_s_ = time_s;
  vision_time_s_ = mark_time_s_ = target_time_s_ = time_s;
  level_time_s_ = unlevel_since_s_ = level_since_s_ = std::nullopt;
  decision_.phase_since_s = time_s;
  decision_.emergencies.clear();
}

void Mission::tick(double time_s) {
  if (!vision_time_s_) start_clock(time_s);
  time_s_ = std::max(time_s_, time_s);
  const double stale_s = time_s_ - *vision_time_s_;
  set_emergency(Emergency::vision_stale, stale_s > settings_.stale_s,
                fmt::format("no POSES for more than {:.1f} s", settings_.stale_s));
  if (stale_s > settings_.stale_s && decision_.phase == Phase::approach) set_phase(Phase::search);
  set_emergency(Emergency::all_out_of_view, time_s_ - mark_time_s_ > settings_.out_of_view_s,
                fmt::format("no circle or cargo seen for more than {:.1f} s", settings_.out_of_view_s));
  if (level_time_s_ && time_s_ - *level_time_s_ > settings_.gimbal_silent_s) {
    level_since_s_.reset();
    set_emergency(Emergency::gimbal_not_level, true,
                  fmt::format("no GIMBAL_LEVEL for more than {:.1f} s", settings_.gimbal_silent_s));
  }
}

void Mission::hear(const CameraHold& level) {
  tick(level.time_s);
  level_time_s_ = level.time_s;
  const std::string cause = unlevel_cause(level, settings_);
  if (cause.empty()) {
    unlevel_since_s_.reset();
    if (!level_since_s_) level_since_s_ = level.time_s;
    if (level.time_s - *level_since_s_ >= settings_.level_again_s)
      set_emergency(Emergency::gimbal_not_level, false, "");
    return;
  }
  level_since_s_.reset();
  if (!unlevel_since_s_) unlevel_since_s_ = level.time_s;
  const bool told_by_gimbal =
      level.gimbal == GimbalCondition::stuck || level.gimbal == GimbalCondition::late;  // after its own delay
  if (told_by_gimbal || level.time_s - *unlevel_since_s_ >= settings_.off_level_s)
    set_emergency(Emergency::gimbal_not_level, true, cause);
}

void Mission::see(const View& view) {
  // another log, or the camera's host restarted; what is late only is not newer for that
  if (!vision_time_s_ || view.time_s < *vision_time_s_ - settings_.stale_s) start_clock(view.time_s);
  vision_time_s_ = std::max(*vision_time_s_, view.time_s);
  const bool any = std::any_of(view.marks.begin(), view.marks.end(),
                               [](const Mark& m) { return m.measured && m.label != Label::unknown; });
  if (any) mark_time_s_ = view.time_s;
  tick(view.time_s);

  const Mark* target = view.target_id ? find(view.marks, *view.target_id) : nullptr;
  constexpr double in_flight_s = 1;  // so long a command, sent twice a second, may take to be obeyed
  const auto is_obeyed = [&] {
    return target->track_id == decision_.wanted->track_id ||
           view.time_s - static_cast<double>(decision_.wanted->choice) * 1e-6 > in_flight_s;
  };
  const bool tracked =
      decision_.wanted && target && view.target_status == TargetStatus::tracking && is_obeyed();
  if (tracked) {  // also when a restarted tracker gave it a new id
    decision_.wanted->track_id = target->track_id;
    decision_.wanted->last_seen_px = target->center_px;
    target_time_s_ = view.time_s;
    set_emergency(Emergency::target_lost, false, "");
  } else if (decision_.wanted && view.time_s - target_time_s_ > settings_.give_up_s) {
    set_emergency(
        Emergency::target_lost, true,
        fmt::format("target {} not seen for {:.1f} s", decision_.wanted->track_id, settings_.give_up_s));
    decision_.wanted.reset();
    decision_.reason = "the target is lost: looking for another";
  }
  weigh_candidates(view);
  if (decision_.phase == Phase::search || decision_.phase == Phase::approach) {
    set_phase(tracked ? Phase::approach : Phase::search);
  }
}

void Mission::weigh_candidates(const View& view) {
  decision_.candidates.clear();
  std::vector<Candidate> candidates;
  bool metric = true;
  for (const Mark& mark : view.marks) {
    Candidate candidate;
    candidate.mark = mark;
    candidate.reason = objection(mark, settings_);
    candidate.eligible = candidate.reason.empty();
    if (candidate.eligible && !mark.range_m) metric = false;
    candidates.push_back(candidate);
  }
  Candidate* best = nullptr;
  for (Candidate& candidate : candidates) {
    if (!candidate.eligible) continue;
    candidate.cost = metric ? *candidate.mark.range_m : 1 / candidate.mark.semi_major_px;
    candidate.reason = metric ? fmt::format("{:.2f} m away", candidate.cost)
                              : fmt::format("semi-axis {:.0f} px", candidate.mark.semi_major_px);
    if (!best || candidate.cost < best->cost) best = &candidate;
  }
  const Mark* wished = operators_choice_ ? find(view.marks, *operators_choice_) : nullptr;
  if (wished) {
    follow(*wished,
           fmt::format("follows {} {}: the operator's choice", name_of(wished->label), wished->track_id));
    operators_choice_.reset();
  } else if (!decision_.wanted && best && decision_.phase == Phase::search) {
    const auto eligible =
        std::count_if(candidates.begin(), candidates.end(), [](const Candidate& c) { return c.eligible; });
    follow(best->mark, fmt::format("follows circle {}: {} of {} in view ({})", best->mark.track_id,
                                   metric ? "nearest" : "largest", eligible, best->reason));
  }
  for (Candidate& candidate : candidates) {
    candidate.chosen = decision_.wanted && decision_.wanted->track_id == candidate.mark.track_id;
  }
  decision_.candidates = std::move(candidates);
}

void Mission::follow(const Mark& mark, const std::string& reason) {
  // by the clock, so that a restarted mission does not repeat a number that meant something else
  last_choice_ = std::max(last_choice_ + 1, static_cast<int64_t>(time_s_ * 1e6));
  decision_.wanted = Wanted{last_choice_, mark.track_id, mark.center_px};
  decision_.reason = reason;
  target_time_s_ = time_s_;
}

void Mission::hold() {
  set_phase(Phase::hold);
  decision_.reason = "held by the operator";
}

void Mission::resume() {
  set_phase(Phase::search);
  decision_.reason = "resumed by the operator";
}

void Mission::abort() {
  set_phase(Phase::abort);
  decision_.wanted.reset();
  operators_choice_.reset();
  set_emergency(Emergency::target_lost, false, "");
  decision_.reason = "aborted by the operator";
}

void Mission::choose(int64_t track_id) {
  if (track_id < 0) {
    decision_.reason = "the operator's choice names no track";
    return;
  }
  operators_choice_ = track_id;
}

void Mission::set_phase(Phase phase) {
  if (phase == decision_.phase) return;
  decision_.phase = phase;
  decision_.phase_since_s = time_s_;
}

void Mission::set_emergency(Emergency kind, bool present, const std::string& cause) {
  auto& raised = decision_.emergencies;
  const auto found =
      std::find_if(raised.begin(), raised.end(), [&](const RaisedEmergency& e) { return e.kind == kind; });
  if (present && found == raised.end()) raised.push_back({kind, time_s_, cause});
  if (!present && found != raised.end()) raised.erase(found);
}

}  // namespace stevedore
