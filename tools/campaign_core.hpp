// Whole missions in the simulated world, one after another, and what came of each.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "runtime/config.hpp"
#include "tools/campaign_lines.hpp"
#include "tools/lock_step.hpp"

namespace stevedore {

/// What kept a mission from delivering all, by its own words.
class CauseBook {
 public:
  /// Every MISSION in its order; the same one may come again.
  void add(const mission_t& mission);
  /// What cost a cargo last; where nothing did, what went wrong last. The particulars stand in parentheses.
  [[nodiscard]] std::string cause() const;

 private:
  std::optional<mission_t> last_;
  std::set<std::int16_t> raised_;
  std::string cost_, went_wrong_, end_;
};

/// By TRUTH.
struct MissionOutcome {
  std::int64_t seed = 0;
  int sea_state = 0;
  int wanted = 0;
  int delivered = 0;  ///< stand upright in a circle of the other platform
  int told_delivered = 0;
  int attempts = 0;
  double duration_s = 0;
  double flown_s = 0;  ///< since the first set-point
  std::vector<double> drop_error_m;
  std::string phase;                         ///< the last
  std::string cause;                         ///< of failure; empty: none
  std::map<std::string, double> seconds_in;  ///< by phase
  std::map<std::string, int> emergencies;    ///< times raised
};

/// Flies until the mission is complete or time is up. say: told of every change of phase.
MissionOutcome fly_mission(LockStep& flight, const Config& config, double longest_s,
                           const std::function<void(double time_s, const mission_t&)>& say = {});

/// wall_s: what it took.
MissionLine to_line(const MissionOutcome& outcome, double wall_s);

}  // namespace stevedore
