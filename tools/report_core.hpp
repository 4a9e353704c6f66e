// What a log says of a run: frames, losses and latencies, stage by stage; and of a mission what was brought,
// how well the height was known below 2 m (low_altitude.hpp says how that is computed), and what went wrong
// when.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "lcmtypes/channels.hpp"
#include "runtime/condition.hpp"
#include "runtime/event_log.hpp"
#include "tools/deliveries.hpp"
#include "tools/low_altitude.hpp"

namespace stevedore {

struct Percentiles {
  double p50_ms = 0;
  double p99_ms = 0;
};

/// Nearest rank; nothing for no values.
std::optional<Percentiles> percentiles_of(std::vector<int64_t> values_us);

/// A process of the line: what carries frames into it and out of it.
struct StageLine {
  const char* process;
  const char* input;      ///< the message that it answers; empty: the camera has none
  const char* frames_in;  ///< another input whose loss is a lost frame too; empty: none
  const char* output;
};

/// In the line's order: each one's input is the output of the one before. sim_proc may stand in for
/// camera_proc.
inline constexpr std::array<StageLine, 5> stage_lines{{
    {"camera_proc", "", source_channel, channels::frame.name},
    {"detector_proc", channels::frame.name, "", channels::ellipses.name},
    {"tracker_proc", channels::ellipses.name, channels::frame.name, channels::tracks.name},
    {"pose_proc", channels::tracks.name, "", channels::poses.name},
    {"mission_proc", channels::poses.name, "", channels::mission.name},
}};

int64_t lost_of(const input_health_t& input);

/// The newest HEALTH of every run of every process. Its counters count from a process' start, so what a
/// process did is the sum over its runs.
class HealthBook {
 public:
  using Runs = std::map<int64_t, health_t>;  ///< by run_id

  void add(const health_t& health);
  /// Empty for a process that was never heard.
  [[nodiscard]] const Runs& runs_of(const std::string& process) const;
  [[nodiscard]] const std::map<std::string, Runs>& processes() const { return processes_; }

 private:
  std::map<std::string, Runs> processes_;
};

/// What a process publishes FRAME as: one of the two is in a run.
inline bool is_camera(const std::string& process) {
  return process == "camera_proc" || process == "sim_proc";
}

/// The line of a run, the camera being the process that was heard.
std::array<StageLine, 5> stage_lines_of(const HealthBook& health);

struct StageReport {
  std::string process;
  int64_t in = 0;   ///< frames that reached it; of a process beside the line: messages
  int64_t out = 0;  ///< frames that it answered; of a process beside the line: messages that it published
  /// Nothing: no HEALTH of it in the log.
  std::optional<int64_t> lost;
  std::optional<int64_t> skipped;
  std::optional<int64_t> kernel_drops;
  int64_t missed = 0;  ///< of lost and skipped, those that left a frame unanswered: on the input it answers
  int64_t restarts = 0;
  /// Publish stamp minus that of the message it answers; the camera's: minus capture. So they add up.
  std::optional<Percentiles> latency;
  std::optional<double> cpu_share;  ///< of one core, mean over the run; nothing: not told
};

/// From the first MISSION that tells of it to the first that does not, in seconds of the log; until the
/// mission is complete or the camera is at its end.
struct EmergencyReport {
  std::int16_t kind = 0;
  std::string cause;  ///< as first told
  double raised_s = 0;
  std::optional<double> cleared_s;  ///< nothing: it stood when the log ended
};

/// What a mission that flew the aircraft did.
struct MissionReport {
  std::string phase;  ///< the last
  std::string reason;
  int told_delivered = 0;  ///< by MISSION
  int attempts = 0;
  double flown_s = 0;  ///< from the first set-point to the end of the mission, or of the log
  std::optional<std::vector<BroughtCargo>> brought;  ///< by TRUTH; nothing: no TRUTH
  LowAltitude low_altitude;
  std::vector<EmergencyReport> emergencies;

  /// By TRUTH; where there is none, as told.
  [[nodiscard]] int delivered() const { return brought ? static_cast<int>(brought->size()) : told_delivered; }
};

struct Report {
  double duration_s = 0;  ///< from the log's first event to its last
  int64_t frames = 0;     ///< published by the camera
  int64_t answered = 0;   ///< of them, those with a MISSION in the log
  int64_t tracked = 0;    ///< of them, those with the target measured
  int64_t frames_lost = 0;
  int64_t frames_skipped = 0;
  int64_t camera_drops = 0;            ///< frames that the camera owed and did not deliver
  int64_t messages_lost = 0;           ///< of every input of every process
  std::optional<Percentiles> latency;  ///< capture to MISSION
  std::vector<StageReport> stages;     ///< in the line's order
  std::vector<StageReport> beside;     ///< processes that no frame goes through
  std::optional<MissionReport> mission;
  int64_t unexplained = 0;     ///< unanswered though no process counted them
  int64_t missing_in_log = 0;  ///< messages of the line that were published but not logged
  int64_t unreadable = 0;      ///< messages on this system's channels that are not of its types
};

/// Fed with a log's events in any order.
class LogSummary {
 public:
  void add(const LogEvent& event);
  [[nodiscard]] Report report() const;

 private:
  struct Output {
    int64_t run_id, seq, utime, frame_seq, publish_utime;
  };
  using Outputs = std::vector<Output>;

  template <class M>
  void add_output(const LogEvent& event, const Channel<M>& channel);
  template <class M, class Handler>
  void hear(const LogEvent& event, const Channel<M>& channel, const Handler& handler);
  void add_health(const health_t& health, int64_t log_utime);
  void add_mission(const mission_t& mission, int64_t log_utime);
  void add_truth(truth_t truth);
  [[nodiscard]] std::optional<MissionReport> mission_report() const;
  [[nodiscard]] std::vector<EmergencyReport> emergency_reports() const;
  [[nodiscard]] StageReport stage_report(const StageLine& line) const;
  [[nodiscard]] StageReport beside_report(const std::string& process) const;
  [[nodiscard]] int64_t camera_drops() const;
  [[nodiscard]] std::optional<double> cpu_share_of(const std::string& process) const;
  [[nodiscard]] const Outputs& outputs_on(const std::string& channel) const;
  [[nodiscard]] std::optional<Percentiles> stage_latency(const StageLine& line) const;

  std::optional<int64_t> first_utime_;
  int64_t last_utime_ = 0;
  std::map<std::string, Outputs> outputs_;  ///< by channel
  std::optional<mission_t> newest_mission_;
  std::optional<int64_t> flown_since_utime_, complete_utime_;
  int64_t end_log_utime_ =
      std::numeric_limits<int64_t>::max();  ///< of mission or camera: what stops then is no news
  std::optional<truth_t> first_truth_, newest_truth_;
  LowAltitudeBook low_altitude_;
  std::multimap<int64_t, std::vector<emergency_t>> emergencies_;  ///< of each MISSION, by its time in the log
  std::set<int64_t> tracked_utimes_;
  HealthBook health_;
  std::map<std::string, std::vector<double>> cpu_shares_;  ///< by process, of each HEALTH
  int64_t unreadable_ = 0;
};

nlohmann::ordered_json to_json(const Report& report, const std::string& log);

/// For people, at most 100 columns wide.
std::string to_text(const Report& report);

}  // namespace stevedore
