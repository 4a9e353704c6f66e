#include "tools/campaign_core.hpp"

#include <cmath>
#include <set>

#include "lcmtypes/names.hpp"
#include "mission_proc/mission.hpp"

namespace stevedore {
namespace {

void judge(const truth_t& truth, int drop_platform, MissionOutcome& outcome) {
  for (const truth_cargo_t& cargo : truth.cargoes) {
    if (cargo.platform != drop_platform || cargo.slot < 0 || cargo.tipped || cargo.on_hook) continue;
    ++outcome.delivered;
    for (const truth_circle_t& circle : truth.circles) {
      if (circle.platform != cargo.platform || circle.slot != cargo.slot) continue;
      const double north_m = cargo.center_ned_m[0] - circle.center_ned_m[0],
                   east_m = cargo.center_ned_m[1] - circle.center_ned_m[1];
      outcome.drop_error_m.push_back(std::hypot(north_m, east_m));
    }
  }
}

}  // namespace

MissionOutcome fly_mission(LockStep& flight, const Config& config, double longest_s,
                           const std::function<void(double, const mission_t&)>& say) {
  const auto sim = config.section<SimSettings>("sim");
  const auto carry = config.section<MissionSettings>("mission").carry;
  MissionOutcome outcome;
  outcome.seed = sim.seed;
  outcome.sea_state = sim.sea_state;
  outcome.wanted = sim.cargoes;
  std::set<std::int16_t> raised;
  std::string last;
  while (flight.time_s() < longest_s && flight.mission().phase != mission_t::PHASE_COMPLETE) {
    flight.step();
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
  judge(flight.truth(), carry.drop_platform, outcome);
  if (outcome.delivered < outcome.wanted) outcome.cause = flight.mission().reason;
  return outcome;
}

}  // namespace stevedore
