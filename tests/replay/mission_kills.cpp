// mission_proc dies twenty times in a mission of one cargo, in every phase of it: the mission is flown to its
// end, and nothing that was done is done again.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "lcmtypes/names.hpp"
#include "tools/deliveries.hpp"
#include "tools/lock_step.hpp"
#include "tools/replay_core.hpp"

using namespace stevedore;

namespace {

Config one_cargo(int seed) {
  return Config::load(std::string(STEVEDORE_SOURCE_DIR) + "/config/world.yaml",
                      {"sim.pilot=mission", "mission.job=carry", "mission.start_at_once=true",
                       "mission.cargoes=1", "mission.journal=kept", "sim.cargoes=1",
                       "sim.seed=" + std::to_string(seed), "sim.sea_state=1", "sim.rate_hz=10"});
}

bool hangs(const truth_t& truth) {
  return truth.cargo_count > 0 && truth.cargoes[0].on_hook;
}

/// Kills at the first word of each phase, since some are over at once, and once more in what takes long.
struct Killer {
  std::map<std::pair<int, bool>, int> kills;  ///< by phase, and whether a cargo has been loaded
  int all = 0, last_phase = mission_t::PHASE_IDLE;
  double at_s = HUGE_VAL;

  void look(LockStep& flight, bool has_been_loaded) {
    constexpr double away_s = 0.3;  // runit's restart, and the process' own start
    const int phase = flight.mission().phase;
    if (phase != last_phase) at_s = flight.time_s();
    last_phase = phase;
    if (flight.time_s() < at_s) return;
    at_s = flight.time_s() + 3;
    const bool is_long = phase == mission_t::PHASE_SEARCH || phase == mission_t::PHASE_APPROACH ||
                         phase == mission_t::PHASE_DESCEND || phase == mission_t::PHASE_TRANSIT;
    int& here = kills[{phase, has_been_loaded}];
    if (here == (is_long ? 2 : 1)) return;
    flight.kill_mission(away_s);
    ++here;
    ++all;
    UNSCOPED_INFO(flight.time_s() << " s: killed in " << phase_name(flight.mission().phase));
  }
};

/// Whether the cargo slipped off: one that was badly taken does so in the world, whoever flies.
bool fly(LockStep& flight, Killer& killer, std::optional<truth_t>& start) {
  constexpr double longest_s = 400;
  int delivered = 0;
  bool has_been_loaded = false, hung = false;
  while (flight.time_s() < longest_s && flight.mission().phase != mission_t::PHASE_COMPLETE) {
    flight.step();
    if (!start && flight.truth().cargo_count > 0) start = flight.truth();
    const mission_t& mission = flight.mission();
    if (hung && !hangs(flight.truth()) && mission.action != mission_t::ACTION_RELEASE) return true;
    hung = hangs(flight.truth());
    has_been_loaded = has_been_loaded || mission.phase == mission_t::PHASE_TRANSIT;
    const bool grips =
        mission.phase == mission_t::PHASE_LOAD || mission.phase == mission_t::PHASE_VERIFY_LOAD;
    if (has_been_loaded && grips) FAIL("what was loaded is loaded again");
    if (mission.delivered < delivered) FAIL("what was delivered is forgotten");
    delivered = mission.delivered;
    killer.look(flight, has_been_loaded);
  }
  return false;
}

/// All that mission_proc heard and said, in a log.
class MissionLog {
 public:
  MissionLog()
      : path_(std::filesystem::temp_directory_path() / ("mission-kills-" + std::to_string(getpid()))) {}
  ~MissionLog() { std::filesystem::remove(path_); }
  MissionLog(const MissionLog&) = delete;
  MissionLog& operator=(const MissionLog&) = delete;

  void begin() { writer_.emplace(path_.string()); }
  void write(const LogEvent& event) {
    if (event.channel != channels::frame.name) writer_->write(event);
  }
  ReplayResult replayed(const Config& config) {
    writer_.reset();
    ReplayOptions options;
    options.mode = ReplayMode::as_flown;
    options.stages = {"mission_proc"};
    options.config = config;
    return replay(path_.string(), options, [](const LogEvent&) {});
  }

 private:
  std::filesystem::path path_;
  std::optional<LogWriter> writer_;
};

}  // namespace

TEST_CASE(
    "a mission whose process is killed twenty times and more, in every phase, delivers and repeats nothing") {
  // a phase may be over between two words of MISSION, as setting down where the deck comes up: another seed,
  // then
  std::set<int> left{mission_t::PHASE_TAKE_OFF, mission_t::PHASE_SEARCH, mission_t::PHASE_APPROACH,
                     mission_t::PHASE_DESCEND,  mission_t::PHASE_LOAD,   mission_t::PHASE_VERIFY_LOAD,
                     mission_t::PHASE_TRANSIT,  mission_t::PHASE_DROP,   mission_t::PHASE_VERIFY_DROP,
                     mission_t::PHASE_RETURN,   mission_t::PHASE_LAND};
  constexpr int first_seed = 4, last_seed = 6;  // of the first four the one that shows most phases
  MissionLog log;
  for (int seed = first_seed; !left.empty() && seed <= last_seed; ++seed) {
    log.begin();
    LockStep flight(one_cargo(seed), "mission-kills-" + std::to_string(getpid()),
                    [&log](const LogEvent& event) { log.write(event); });
    Killer killer;
    std::optional<truth_t> start;
    if (fly(flight, killer, start)) continue;
    UNSCOPED_INFO("seed " << seed << " ended after " << flight.time_s() << " s in "
                          << phase_name(flight.mission().phase) << ", " << flight.mission().attempts
                          << " attempts");
    CHECK(killer.all >= 20);
    std::erase_if(left, [&](int phase) {
      return killer.kills.contains({phase, phase > mission_t::PHASE_VERIFY_LOAD});
    });
    CHECK(flight.mission().phase == mission_t::PHASE_COMPLETE);
    CHECK(flight.mission().delivered == 1);
    REQUIRE(start);
    CHECK(drop_errors_m(*start, flight.truth()).size() == 1);
    const ReplayResult replayed = log.replayed(one_cargo(seed));
    CHECK(replayed.as_flown());  // each run went on from the journal of the one before
    CHECK(replayed.channels.at(channels::mission_journal.name).equal > 10);
  }
  CHECK(left == std::set<int>());
}
