#include "tools/replay_core.hpp"

#include <algorithm>
#include <any>
#include <array>
#include <deque>
#include <optional>
#include <tuple>

#include "detector_proc/detector_stage.hpp"
#include "mission_proc/mission_stage.hpp"
#include "pose_proc/pose_stage.hpp"
#include "runtime/camera_file.hpp"
#include "runtime/process.hpp"
#include "tracker_proc/tracker_stage.hpp"

namespace stevedore {
namespace {

// ---- what can be replayed ----

struct StageKind {
  const char* process;
  std::vector<std::string> outputs;
  std::function<std::shared_ptr<void>(const Config&, Bus&, FrameReader&)> make;
};

const std::vector<StageKind>& stage_kinds() {
  static const std::vector<StageKind> kinds = {
      {"detector_proc",
       {channels::ellipses.name},
       [](const Config& config, Bus& bus, FrameReader& frames) {
         return std::make_shared<DetectorStage>(config.section<DetectorSettings>("detector"), bus, frames,
                                                Delivery::every);
       }},
      {"tracker_proc",
       {channels::tracks.name},
       [](const Config& config, Bus& bus, FrameReader& frames) {
         return std::make_shared<TrackerStage>(config.section<TrackerSettings>("tracker"), bus, frames);
       }},
      {"pose_proc",
       {channels::poses.name},
       [](const Config& config, Bus& bus, FrameReader&) {
         return std::make_shared<PoseStage>(config.section<PoseSettings>("pose"), camera_of(config), bus);
       }},
      {"mission_proc",
       {channels::mission.name, channels::track_command.name},
       [](const Config& config, Bus& bus, FrameReader&) {
         return std::make_shared<MissionStage>(config.section<MissionSettings>("mission"), bus);
       }},
  };
  return kinds;
}

/// Carries nothing by itself: the replay hands messages in and takes them out.
class ReplayBus final : public Bus {
 public:
  using Output = std::function<void(const std::string& channel, const std::vector<uint8_t>& bytes)>;
  ReplayBus(int64_t run_id, Output output) : Bus(run_id), output_(std::move(output)) {}

  void deliver(const LogEvent& event, int64_t utime) {
    utime_ = utime;
    receive(event.channel, event.bytes.data(), event.bytes.size());
  }
  [[nodiscard]] bool hears(const std::string& channel) const { return heard_.contains(channel); }

 private:
  [[nodiscard]] int64_t now_utime() const override { return utime_; }
  void transmit(const std::string& channel, const std::vector<uint8_t>& bytes) override {
    output_(channel, bytes);
  }
  void listen(const std::string& channel) override { heard_.insert(channel); }

  Output output_;
  std::set<std::string> heard_;
  int64_t utime_ = 0;
};

/// One run of a stage: bus and stage live and die together, as its process did.
struct StageRun {
  ReplayBus bus;
  FrameReader frames;
  std::shared_ptr<void> stage;

  StageRun(const StageKind& kind, const Config& config, int64_t run_id, ReplayBus::Output output)
      : bus(run_id, std::move(output)), stage(kind.make(config, bus, frames)) {}
};

// ---- the log ----

using MessageKey = std::tuple<std::string, int64_t, int64_t>;  // channel, run_id, seq

struct IndexEntry {
  int64_t position = 0;
  int64_t utime = 0;
  std::string channel;
  std::optional<header_t> header;
};

uint64_t fnv1a(uint64_t hash, const void* data, size_t size) {  // Fowler, Noll, Vo: FNV-1a, 64 bits
  const auto* bytes = static_cast<const uint8_t*>(data);
  for (size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 0x100000001b3;
  return hash;
}

uint64_t fnv1a(uint64_t hash, const std::string& text) {
  return fnv1a(hash, text.data(), text.size());
}

class LogIndex {
 public:
  explicit LogIndex(const std::string& path) : reader_(path) {
    int64_t position = reader_.position();
    while (const auto event = reader_.next()) {
      hash_ = fnv1a(fnv1a(hash_, event->channel), event->bytes.data(), event->bytes.size());
      entries_.push_back({position, event->utime, event->channel, decode_header(event->bytes)});
      position = reader_.position();
    }
  }
  [[nodiscard]] const std::vector<IndexEntry>& entries() const { return entries_; }
  [[nodiscard]] uint64_t hash() const { return hash_; }
  LogEvent load(const IndexEntry& entry) {
    reader_.seek(entry.position);
    auto event = reader_.next();
    if (!event) throw std::runtime_error("the log changed while it was read");
    return *std::move(event);
  }

 private:
  LogReader reader_;
  std::vector<IndexEntry> entries_;
  uint64_t hash_ = 0xcbf29ce484222325;
};

template <class M>
std::optional<std::vector<uint8_t>> without_trace(const LogEvent& event, const Channel<M>& channel) {
  auto message = decode(event, channel);
  if (!message) return std::nullopt;
  message->header.trace = trace_t{};
  return encode(*message);
}

// ---- the replay ----

class Replay {
 public:
  Replay(const std::string& log, const ReplayOptions& options, const EventSink& write)
      : options_(options), write_(write), index_(log) {
    for (const StageKind& kind : stage_kinds()) {
      if (!options_.stages.contains(kind.process)) continue;
      kinds_.push_back(&kind);
      for (const auto& channel : kind.outputs) producer_[channel] = &kind;
    }
    for (const IndexEntry& entry :
         index_.entries()) {  // a log that starts in mid-flight: number as the flight did
      if (!entry.header || !producer_.contains(entry.channel)) continue;
      first_seq_.try_emplace({entry.channel, entry.header->trace.run_id}, entry.header->seq);
    }
    run_id_ = fnv1a(fnv1a(index_.hash(), options_.config_text), version());
  }

  ReplayResult run(const ProgressSink& progress) {
    if (options_.mode == ReplayMode::every_frame) {
      for (const StageKind* kind : kinds_) start(*kind, 0);
    }
    const auto& entries = index_.entries();
    result_.events = static_cast<int64_t>(entries.size());
    for (size_t i = 0; i < entries.size(); ++i) {
      if (progress && i % 256 == 0) progress(static_cast<double>(i) / static_cast<double>(entries.size()));
      options_.mode == ReplayMode::as_flown ? step_as_flown(i) : step_every_frame(entries[i]);
    }
    compare();
    return result_;
  }

 private:
  struct Running {
    std::unique_ptr<StageRun> run;
    int64_t flight_run_id = 0;
    std::map<std::pair<std::string, int64_t>, int64_t>
        delivered_seq;  ///< by channel and publisher's run in flight
  };

  /// A stage's process starts, in the flight's run of that id.
  Running& start(const StageKind& kind, int64_t flight_run_id) {
    Running& running = running_[kind.process];
    running = {};
    running.flight_run_id = flight_run_id;
    const auto id =
        static_cast<int64_t>(fnv1a(run_id_ + static_cast<uint64_t>(++starts_), kind.process) >> 1);
    running.run = std::make_unique<StageRun>(
        kind, options_.config, id,
        [this, flight_run_id](const std::string& channel, const std::vector<uint8_t>& bytes) {
          on_output(channel, flight_run_id, bytes);
        });
    for (const auto& channel : kind.outputs) {
      const auto first = first_seq_.find({channel, flight_run_id});
      if (first != first_seq_.end()) running.run->bus.set_next_seq(channel, first->second);
    }
    return running;
  }

  void on_output(const std::string& channel, int64_t flight_run_id, const std::vector<uint8_t>& bytes) {
    const LogEvent event{event_utime_, channel, bytes};
    write_(event);
    replayed_[{channel, flight_run_id, decode_header(bytes)->seq}] = event;
    if (options_.mode == ReplayMode::every_frame) queue_.push_back(event);
  }

  void step_every_frame(const IndexEntry& entry) {
    if (const auto producer = producer_.find(entry.channel); producer != producer_.end())
      return remember_logged(entry);
    const LogEvent event = index_.load(entry);
    event_utime_ = entry.utime;
    write_(event);
    queue_.push_back(event);
    const int64_t now = entry.header ? entry.header->trace.publish_utime : 0;
    while (!queue_.empty()) {
      const LogEvent next = std::move(queue_.front());
      queue_.pop_front();
      for (const StageKind* kind : kinds_) {
        ReplayBus& bus = running_.at(kind->process).run->bus;
        if (bus.hears(next.channel)) bus.deliver(next, now);
      }
    }
  }

  void step_as_flown(size_t position) {
    const IndexEntry& entry = index_.entries()[position];
    const auto producer = producer_.find(entry.channel);
    if (producer == producer_.end()) {
      if (entry.header) inputs_[{entry.channel, entry.header->trace.run_id}][entry.header->seq] = position;
      return write_(index_.load(entry));
    }
    remember_logged(entry);
    if (!entry.header) return;
    const header_t& logged = *entry.header;
    event_utime_ = entry.utime;
    auto running = running_.find(producer->second->process);
    if (running == running_.end() || running->second.flight_run_id != logged.trace.run_id) {
      start(*producer->second, logged.trace.run_id);
      running = running_.find(producer->second->process);
    }
    bring_up_to(running->second, logged.trace);
  }

  /// Hands the stage what it had read when it published, the cause last.
  void bring_up_to(Running& running, const trace_t& trace) {
    std::vector<std::pair<size_t, LogEvent>> others;  // by place in the log
    std::optional<LogEvent> cause;
    for (const input_mark_t& mark : trace.inputs) {
      auto known = running.delivered_seq.find({mark.channel, mark.run_id});
      const bool only_newest = mark.channel == channels::frame.name && !keeps_frames(running);
      const int64_t first = known == running.delivered_seq.end() || only_newest
                                ? first_wanted(mark, only_newest)
                                : known->second + 1;
      if (known != running.delivered_seq.end() && known->second >= mark.seq) continue;
      for (int64_t seq = first; seq <= mark.seq; ++seq) {
        auto found = find_input(mark.channel, mark.run_id, seq);
        if (!found) {
          ++result_.missing_inputs;
        } else if (mark.channel == trace.cause && seq == mark.seq) {
          cause = std::move(found->second);
        } else {
          others.push_back(*std::move(found));
        }
      }
      running.delivered_seq[{mark.channel, mark.run_id}] = mark.seq;
    }
    std::stable_sort(others.begin(), others.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    for (const auto& [place, event] : others) running.run->bus.deliver(event, trace.publish_utime);
    if (cause) running.run->bus.deliver(*cause, trace.publish_utime);
  }

  /// The detector looks at the newest frame only; what lies between was never handed to it.
  bool keeps_frames(const Running& running) const { return &running != find_running("detector_proc"); }
  const Running* find_running(const std::string& process) const {
    const auto found = running_.find(process);
    return found == running_.end() ? nullptr : &found->second;
  }

  /// Where a stage that has read nothing of this publisher yet begins.
  int64_t first_wanted(const input_mark_t& mark, bool only_newest) const {
    if (only_newest) return mark.seq;
    int64_t first = mark.seq;
    if (const auto logged = inputs_.find({mark.channel, mark.run_id}); logged != inputs_.end()) {
      first = std::min(first, logged->second.begin()->first);
    }
    if (const auto produced = first_seq_.find({mark.channel, mark.run_id}); produced != first_seq_.end()) {
      first = std::min(first, produced->second);
    }
    return first;
  }

  /// An input by the flight's numbers: from the log, or what a replayed stage said in its place.
  std::optional<std::pair<size_t, LogEvent>> find_input(const std::string& channel, int64_t run_id,
                                                        int64_t seq) {
    if (const auto made = replayed_.find({channel, run_id, seq}); made != replayed_.end()) {
      const auto place = logged_.find({channel, run_id, seq});
      return std::pair(place == logged_.end() ? size_t{0} : place->second, made->second);
    }
    const auto run = inputs_.find({channel, run_id});
    if (run == inputs_.end()) return std::nullopt;
    const auto entry = run->second.find(seq);
    if (entry == run->second.end()) return std::nullopt;
    return std::pair(entry->second, index_.load(index_.entries()[entry->second]));
  }

  void remember_logged(const IndexEntry& entry) {
    if (!entry.header) return;
    const auto place = static_cast<size_t>(&entry - index_.entries().data());
    logged_[{entry.channel, entry.header->trace.run_id, entry.header->seq}] = place;
  }

  void compare() {
    if (options_.mode != ReplayMode::as_flown) {
      for (const auto& [key, event] : replayed_) ++result_.channels[std::get<0>(key)].only_replayed;
      for (const auto& [key, place] : logged_) ++result_.channels[std::get<0>(key)].only_logged;
      return;
    }
    for (const auto& [key, place] : logged_) {
      ChannelComparison& comparison = result_.channels[std::get<0>(key)];
      const auto made = replayed_.find(key);
      if (made == replayed_.end()) {
        ++comparison.only_logged;
        continue;
      }
      const LogEvent logged = index_.load(index_.entries()[place]);
      const bool equal =
          payload_of(logged.channel, logged.bytes) == payload_of(logged.channel, made->second.bytes);
      ++(equal ? comparison.equal : comparison.different);
    }
    for (const auto& [key, event] : replayed_) {
      if (!logged_.contains(key)) ++result_.channels[std::get<0>(key)].only_replayed;
    }
  }

  const ReplayOptions& options_;
  const EventSink& write_;
  LogIndex index_;
  uint64_t run_id_ = 0;
  int starts_ = 0;
  int64_t event_utime_ = 0;
  std::vector<const StageKind*> kinds_;
  std::map<std::string, const StageKind*> producer_;  ///< by channel
  std::map<std::string, Running> running_;            ///< by process
  std::map<std::pair<std::string, int64_t>, std::map<int64_t, size_t>>
      inputs_;  ///< external: channel, run -> seq -> entry
  std::map<std::pair<std::string, int64_t>, int64_t>
      first_seq_;                            ///< of replayed channels in the log, by the flight's run
  std::map<MessageKey, size_t> logged_;      ///< outputs of the flight: entry
  std::map<MessageKey, LogEvent> replayed_;  ///< outputs of the replay, by the flight's numbers
  std::deque<LogEvent> queue_;
  ReplayResult result_;
};

}  // namespace

bool ReplayResult::as_flown() const {
  return missing_inputs == 0 && std::all_of(channels.begin(), channels.end(), [](const auto& entry) {
           return entry.second.different == 0 && entry.second.only_logged == 0 &&
                  entry.second.only_replayed == 0;
         });
}

std::optional<std::vector<uint8_t>> payload_of(const std::string& channel,
                                               const std::vector<uint8_t>& bytes) {
  const LogEvent event{0, channel, bytes};
  std::optional<std::vector<uint8_t>> payload;
  const auto look = [&](const auto& candidate) {
    if (channel == candidate.name) payload = without_trace(event, candidate);
  };
  std::apply([&look](const auto&... candidate) { (look(candidate), ...); }, channels::all);
  return payload;
}

ReplayResult replay(const std::string& log, const ReplayOptions& options, const EventSink& write,
                    const ProgressSink& progress) {
  return Replay(log, options, write).run(progress);
}

}  // namespace stevedore
