// A flight in the simulated world in lock step: the stages' real code, real pixels and real messages, in one
// process and in a time of its own, as fast as the machine allows.
#pragma once

#include <stevedore/mission_t.hpp>
#include <stevedore/truth_t.hpp>

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/config.hpp"
#include "runtime/event_log.hpp"
#include "sim_proc/sim_stage.hpp"

namespace stevedore {

class LockStep {
 public:
  /// Told of every message, in order; the log's time is the flight's.
  using Sink = std::function<void(const LogEvent&)>;

  /// config: config/world.yaml, as ./run has it. ring_name: of the frames' shared memory, unique on this
  /// machine.
  LockStep(const Config& config, const std::string& ring_name, Sink sink = {});
  ~LockStep();
  LockStep(const LockStep&) = delete;
  LockStep& operator=(const LockStep&) = delete;

  /// 5 ms of flight.
  void step();
  void fly(double seconds);
  [[nodiscard]] double time_s() const;

  /// As kill -9 and a restart: the mission's memory is gone but for its journal.
  void kill_mission(double away_s);
  /// A message from outside, e.g. an operator's.
  template <class M>
  void say(const Channel<M>& channel, const M& message) {
    queue_.push_back({now_utime_, channel.name, encode(message)});
  }
  /// Messages for which this says no are lost. For tests of what fails.
  std::function<bool(LogEvent&)> passes;

  [[nodiscard]] const mission_t& mission() const { return mission_; }
  [[nodiscard]] const truth_t& truth() const { return truth_; }
  [[nodiscard]] std::int64_t now_utime() const { return now_utime_; }

  /// From the camera's exposure to the detector: what drawing takes on the machine that flies in real time.
  static constexpr std::int64_t frame_latency_us = 60'000;

 private:
  struct Stage;
  class StageBus;

  void make_mission();
  void exchange();
  void hand_out(const LogEvent& event);

  Config config_;
  Sink sink_;
  std::int64_t now_utime_;
  std::deque<LogEvent> queue_;
  std::deque<LogEvent> delayed_;  ///< frames
  std::vector<std::unique_ptr<Stage>> stages_;
  std::unique_ptr<StageBus> sim_bus_;
  std::unique_ptr<SimStage> sim_;
  std::optional<mission_journal_t> journal_;
  std::int64_t mission_back_utime_ = 0;
  mission_t mission_{};
  truth_t truth_{};
};

}  // namespace stevedore
