// mission_proc dies twenty times in a mission of one cargo, in every phase of it: the mission is flown to its
// end, and nothing that was done is done again.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include "lcmtypes/names.hpp"
#include "tools/deliveries.hpp"
#include "tools/lock_step.hpp"

using namespace stevedore;

namespace {

Config one_cargo() {
  return Config::load(
      std::string(STEVEDORE_SOURCE_DIR) + "/config/world.yaml",
      {"sim.pilot=mission", "mission.job=carry", "mission.start_at_once=true", "mission.cargoes=1",
       "sim.cargoes=1", "sim.seed=1", "sim.sea_state=1", "sim.rate_hz=10"});
}

}  // namespace

TEST_CASE(
    "a mission whose process is killed twenty times and more, in every phase, delivers and repeats nothing") {
  constexpr double away_s = 0.3;  // runit's restart, and the process' own start
  constexpr double longest_s = 400;
  LockStep flight(one_cargo(), "mission-kills-" + std::to_string(getpid()));
  std::map<std::pair<int, bool>, int> kills;  // by phase, and whether a cargo has been loaded
  int all = 0, delivered = 0, last_phase = mission_t::PHASE_IDLE;
  bool has_been_loaded = false;
  double kill_at_s = HUGE_VAL;
  std::optional<truth_t> start;
  while (flight.time_s() < longest_s && flight.mission().phase != mission_t::PHASE_COMPLETE) {
    flight.step();
    if (!start && flight.truth().cargo_count > 0) start = flight.truth();
    const mission_t& mission = flight.mission();
    const int phase = mission.phase;
    if (phase != last_phase) kill_at_s = flight.time_s() + 0.05;
    last_phase = phase;
    has_been_loaded = has_been_loaded || phase == mission_t::PHASE_TRANSIT;
    const bool grips = phase == mission_t::PHASE_LOAD || phase == mission_t::PHASE_VERIFY_LOAD;
    if (has_been_loaded && grips) FAIL("what was loaded is loaded again");
    if (mission.delivered < delivered) FAIL("what was delivered is forgotten");
    delivered = mission.delivered;
    if (flight.time_s() < kill_at_s) continue;
    // once more in what takes long
    const bool is_long = phase == mission_t::PHASE_SEARCH || phase == mission_t::PHASE_APPROACH ||
                         phase == mission_t::PHASE_DESCEND || phase == mission_t::PHASE_TRANSIT;
    int& here = kills[{phase, has_been_loaded}];
    kill_at_s = flight.time_s() + 3;
    if (here == (is_long ? 2 : 1)) continue;
    flight.kill_mission(away_s);
    ++here;
    ++all;
    UNSCOPED_INFO(flight.time_s() << " s: killed in " << phase_name(mission.phase));
  }
  UNSCOPED_INFO("ended after " << flight.time_s() << " s in " << phase_name(flight.mission().phase) << ", "
                               << flight.mission().attempts << " attempts");
  CHECK(all >= 20);
  for (const int phase : {mission_t::PHASE_TAKE_OFF, mission_t::PHASE_SEARCH, mission_t::PHASE_APPROACH,
                          mission_t::PHASE_DESCEND, mission_t::PHASE_LOAD, mission_t::PHASE_VERIFY_LOAD,
                          mission_t::PHASE_TRANSIT, mission_t::PHASE_DROP, mission_t::PHASE_VERIFY_DROP,
                          mission_t::PHASE_RETURN, mission_t::PHASE_LAND})
    CHECK(kills.contains({phase, has_been_loaded && phase > mission_t::PHASE_VERIFY_LOAD}));
  CHECK(flight.mission().phase == mission_t::PHASE_COMPLETE);
  CHECK(flight.mission().delivered == 1);
  REQUIRE(start);
  CHECK(drop_errors_m(*start, flight.truth()).size() == 1);
}
