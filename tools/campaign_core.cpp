#include "tools/campaign_core.hpp"

#include <optional>
#include <set>

#include "lcmtypes/names.hpp"
#include "tools/deliveries.hpp"

namespace stevedore {
MissionOutcome fly_mission(LockStep& flight, const Config& config, double longest_s,
                           const std::function<void(double, const mission_t&)>& say) {
  const auto sim = config.section<SimSettings>("sim");
  MissionOutcome outcome;
  outcome.seed = sim.seed;
  outcome.sea_state = sim.sea_state;
  outcome.wanted = sim.cargoes;
  std::optional<truth_t> start;
  std::set<std::int16_t> raised;
  std::string last;
  while (flight.time_s() < longest_s && flight.mission().phase != mission_t::PHASE_COMPLETE) {
    flight.step();
    if (!start && flight.truth().cargo_count > 0) start = flight.truth();
    const mission_t& mission = flight.mission();
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
  outcome.told_delivered = flight.mission().delivered;
  outcome.attempts = flight.mission().attempts;
  outcome.drop_error_m = start ? drop_errors_m(*start, flight.truth()) : std::vector<double>{};
  outcome.delivered = static_cast<int>(outcome.drop_error_m.size());
  if (outcome.delivered < outcome.wanted) outcome.cause = flight.mission().reason;
  return outcome;
}

}  // namespace stevedore
