// Runs the stages' real code over a log in lock step, without LCM, as fast as it can.
//
// As flown: every logged output says which inputs its stage had read (header.trace); the stage is given
// exactly those, in that order, so that it says the same again. Every frame: what is in the log is handed on
// in causal order (the log's, but for answers recorded before their causes), and each answer runs down the
// line before the next event.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "runtime/bus.hpp"
#include "runtime/config.hpp"
#include "runtime/event_log.hpp"
#include "runtime/frame_codec.hpp"

namespace stevedore {

enum class ReplayMode { as_flown, every_frame };

struct ReplayOptions {
  ReplayMode mode = ReplayMode::every_frame;
  /// Processes by name; empty: the line from detector_proc to mission_proc, and gimbal_proc where it flew.
  std::set<std::string> stages;
  Config config;
  std::string config_text;  ///< what config was read from; goes into run_id
};

/// How the replayed payloads of one channel (all but header.trace) compare with the logged ones
/// (tools/replay_compare.hpp).
struct ChannelComparison {
  int64_t equal = 0;
  int64_t within_tolerance = 0;  ///< of a log with lossy frames only
  int64_t different = 0;
  int64_t only_logged = 0;
  int64_t only_replayed = 0;
};

/// Names of the processes that can be replayed.
std::vector<std::string> replayable_processes();

struct ReplayResult {
  std::map<std::string, ChannelComparison> channels;
  int64_t events = 0;
  /// Inputs that a logged output names and the log does not hold: its replay can differ.
  int64_t missing_inputs = 0;
  /// What the log lacks.
  std::vector<DamagedPart> damage;
  int64_t unreadable = 0;  ///< messages on this system's channels that are damaged or of another version
  int64_t frames_elsewhere = 0;  ///< frames without their pixels, where a stage needs them
  bool frames_are_lossy = false;

  std::vector<std::string> asked;  ///< main channel of each stage replayed

  /// Nothing that was looked for is missing in the log.
  [[nodiscard]] bool complete() const { return damage.empty() && unreadable == 0 && frames_elsewhere == 0; }
  /// Every payload is equal (or within tolerance, where frames are lossy), each stage has some, and the log
  /// is complete.
  [[nodiscard]] bool as_flown() const;
  [[nodiscard]] bool equal_to_the_bit() const;
};

/// What a replay writes, event by event: the inputs as they were and the stages' answers.
using EventSink = std::function<void(const LogEvent&)>;

/// Progress from 0 to 1, now and then.
using ProgressSink = std::function<void(double)>;

/// Throws std::runtime_error if the log can't be read, holds no message of this system, or none of the pixels
/// that the stages need; ConfigError for a bad configuration.
ReplayResult replay(const std::string& log, const ReplayOptions& options, const EventSink& write,
                    const ProgressSink& progress = {});

/// The message with an empty trace: what a replay must reproduce. Nothing for bytes that are no message of
/// the channel.
std::optional<std::vector<uint8_t>> payload_of(const std::string& channel, const std::vector<uint8_t>& bytes);

}  // namespace stevedore
