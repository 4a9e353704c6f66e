#include "tools/campaign_core.hpp"

#include <fmt/format.h>

#include "lcmtypes/names.hpp"
#include "tools/deliveries.hpp"

namespace stevedore {

void CauseBook::add(const mission_t& mission) {
  std::set<std::int16_t> now;
  for (const emergency_t& e : mission.emergencies) {
    now.insert(e.kind);
    if (raised_.contains(e.kind)) continue;
    const bool costs = e.kind == emergency_t::KIND_CARGO_LOST;
    (costs ? cost_ : went_wrong_) = fmt::format("{} ({})", emergency_name(e.kind), e.cause);
  }
  raised_ = now;
  if (last_ && last_->phase != mission.phase) {
    const std::string what = fmt::format("{} failed ({})", phase_name(last_->phase), mission.reason);
    const bool undelivered =
        last_->phase == mission_t::PHASE_VERIFY_DROP && mission.delivered == last_->delivered;
    if (undelivered) cost_ = what;
    if (mission.phase == mission_t::PHASE_RETRY) went_wrong_ = what;
    if (mission.phase == mission_t::PHASE_SUSPENDED || mission.phase == mission_t::PHASE_ABORT)
      went_wrong_ = fmt::format("{} ({})", phase_name(mission.phase), mission.reason);
    if (mission.phase == mission_t::PHASE_RETURN) end_ = mission.reason;
  }
  last_ = mission;
}

std::string CauseBook::cause() const {
  std::string what = cost_.empty() ? went_wrong_ : cost_;
  if (!end_.empty()) what += fmt::format("{}{}", what.empty() ? "" : "; ", end_);
  if (!last_ || last_->phase == mission_t::PHASE_COMPLETE) return what.empty() ? "not told" : what;
  return fmt::format("time is up (in {}{}{})", phase_name(last_->phase),
                     what.empty() ? "" : "; before: ", what);
}

MissionLine to_line(const MissionOutcome& outcome, double wall_s) {
  return {outcome.seed,       outcome.sea_state, outcome.delivered,    outcome.wanted, outcome.attempts,
          outcome.duration_s, outcome.flown_s,   outcome.drop_error_m, outcome.cause,  wall_s};
}

MissionOutcome fly_mission(LockStep& flight, const Config& config, double longest_s,
                           const std::function<void(double, const mission_t&)>& say) {
  const auto sim = config.section<SimSettings>("sim");
  MissionOutcome outcome;
  outcome.seed = sim.seed;
  outcome.sea_state = sim.sea_state;
  outcome.wanted = sim.cargoes;
  std::optional<truth_t> start;
  std::set<std::int16_t> raised;
  std::optional<double> first_setpoint_s;
  CauseBook causes;
  std::string last;
  while (flight.time_s() < longest_s && flight.mission().phase != mission_t::PHASE_COMPLETE) {
    flight.step();
    if (!start && flight.truth().cargo_count > 0) start = flight.truth();
    const mission_t& mission = flight.mission();
    causes.add(mission);
    if (!first_setpoint_s && mission.has_setpoint) first_setpoint_s = flight.time_s();
    outcome.phase = phase_name(mission.phase);
    outcome.seconds_in[outcome.phase] += 0.005;
    std::set<std::int16_t> now;
    for (const emergency_t& e : mission.emergencies) {
      now.insert(e.kind);
      if (!raised.contains(e.kind)) ++outcome.emergencies[emergency_name(e.kind)];
    }
    const std::string news = outcome.phase + mission.reason;
    if (say && (news != last || now != raised)) say(flight.time_s(), mission);
    last = news;
    raised = now;
  }
  outcome.duration_s = flight.time_s();
  outcome.flown_s = first_setpoint_s ? flight.time_s() - *first_setpoint_s : 0;
  outcome.told_delivered = flight.mission().delivered;
  outcome.attempts = flight.mission().attempts;
  outcome.drop_error_m = start ? drop_errors_m(*start, flight.truth()) : std::vector<double>{};
  outcome.delivered = static_cast<int>(outcome.drop_error_m.size());
  if (outcome.delivered < outcome.wanted)
    outcome.cause = outcome.told_delivered < outcome.wanted
                        ? causes.cause()
                        : fmt::format("counted as delivered by MISSION, not by TRUTH ({} of {} by TRUTH)",
                                      outcome.delivered, outcome.wanted);
  return outcome;
}

}  // namespace stevedore
