#include "tools/replay_core.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <iterator>
#include <optional>
#include <tuple>

#include "detector_proc/detector_stage.hpp"
#include "gimbal_proc/gimbal_stage.hpp"
#include "mission_proc/mission_stage.hpp"
#include "pose_proc/pose_stage.hpp"
#include "runtime/camera_file.hpp"
#include "runtime/command_line.hpp"
#include "tools/replay_compare.hpp"
#include "tracker_proc/tracker_stage.hpp"

namespace stevedore {
namespace {

// ---- what can be replayed ----

struct StageKind {
  const char* process;
  std::vector<std::string> outputs;
  bool in_the_line;  ///< replayed though the log knows nothing of it; any other only where it flew
  /// journal: what an earlier run of mission_proc had kept; to the others nothing.
  std::function<std::shared_ptr<void>(const Config&, Bus&, FrameReader&,
                                      const std::optional<mission_journal_t>& journal)>
      make;
};

const std::vector<StageKind>& stage_kinds() {
  static const std::vector<StageKind> kinds = {
      {"detector_proc",
       {channels::ellipses.name},
       true,
       [](const Config& config, Bus& bus, FrameReader& frames, const auto&) {
         return std::make_shared<DetectorStage>(config.section<DetectorSettings>("detector"),
                                                camera_of(config), bus, frames, Delivery::every);
       }},
      {"tracker_proc",
       {channels::tracks.name},
       true,
       [](const Config& config, Bus& bus, FrameReader& frames, const auto&) {
         return std::make_shared<TrackerStage>(config.section<TrackerSettings>("tracker"), camera_of(config),
                                               bus, frames);
       }},
      {"pose_proc",
       {channels::poses.name, channels::platform_estimate.name},
       true,
       [](const Config& config, Bus& bus, FrameReader&, const auto&) {
         return std::make_shared<PoseStage>(config.section<PoseSettings>("pose"), camera_of(config), bus,
                                            config.section<PlatformSettings>("platform"));
       }},
      {"mission_proc",
       {channels::mission.name, channels::track_command.name, channels::mission_journal.name},
       true,
       [](const Config& config, Bus& bus, FrameReader&, const auto& journal) {
         const auto settings = config.section<MissionSettings>("mission");
         return std::make_shared<MissionStage>(settings, bus,
                                               settings.journal.empty() ? std::nullopt : journal);
       }},
      {"gimbal_proc",
       {channels::gimbal_command.name, channels::gimbal_level.name},
       false,
       [](const Config& config, Bus& bus, FrameReader&, const auto&) {
         const auto camera = camera_of(config);
         return std::make_shared<GimbalStage>(config.section<GimbalSettings>("gimbal"),
                                              camera ? camera->mount : CameraMount{}, bus);
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

  StageRun(const StageKind& kind, const Config& config, int64_t run_id,
           const std::optional<mission_journal_t>& journal, ReplayBus::Output output)
      : bus(run_id, std::move(output)), stage(kind.make(config, bus, frames, journal)) {}
};

// ---- the log ----

using MessageKey = std::tuple<std::string, int64_t, int64_t>;  // channel, run_id, seq

struct IndexEntry {
  int64_t position = 0;
  int64_t utime = 0;
  std::string channel;
  std::optional<header_t> header;
};

/// Each message after what its trace says had been read, and after its publisher's message before it; else as
/// in the log. On a host with several cores an answer can reach the recorder before its cause does: the
/// kernel hands a multicast to one socket after another, and who has it answers meanwhile.
std::vector<IndexEntry> in_causal_order(std::vector<IndexEntry> entries) {
  std::map<MessageKey, size_t> places;
  for (size_t i = 0; i < entries.size(); ++i) {
    if (const auto& header = entries[i].header)
      places.try_emplace({entries[i].channel, header->trace.run_id, header->seq}, i);
  }
  std::vector<char> asked(entries.size()), placed(entries.size());
  std::vector<IndexEntry> ordered;
  ordered.reserve(entries.size());
  std::vector<size_t> waiting;  // each but the first is a cause of the one below it
  const auto ask_for_cause = [&](size_t answer, const std::string& channel, int64_t run_id, int64_t seq) {
    const auto cause = places.find({channel, run_id, seq});
    if (cause != places.end() && cause->second > answer && !asked[cause->second])
      waiting.push_back(cause->second);
  };
  for (size_t i = 0; i < entries.size(); ++i) {
    waiting.push_back(i);
    while (!waiting.empty()) {
      const size_t next = waiting.back();
      const auto& header = entries[next].header;
      if (header && !asked[next]) {
        asked[next] = 1;
        for (const input_mark_t& mark : header->trace.inputs)
          ask_for_cause(next, mark.channel, mark.run_id, mark.seq);
        ask_for_cause(next, entries[next].channel, header->trace.run_id, header->seq - 1);
        if (waiting.back() != next) continue;
      }
      waiting.pop_back();
      if (!placed[next]) ordered.push_back(std::move(entries[next]));
      placed[next] = 1;
    }
  }
  return ordered;
}

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
    while (const auto event = reader_.next()) {
      hash_ = fnv1a(fnv1a(hash_, event->channel), event->bytes.data(), event->bytes.size());
      entries_.push_back({reader_.position(), event->utime, event->channel, decode_header(event->bytes)});
      std::apply([&](const auto&... channel) { (look_at(*event, channel), ...); }, channels::all);
    }
    damage_ = reader_.damage();
    entries_ = in_causal_order(std::move(entries_));
    if (readable_ == 0) {
      throw std::runtime_error(
          fmt::format("{}: no message of this system can be read in it ({} are unreadable). {}", path,
                      unreadable_, describe(damage_)));
    }
  }
  /// In causal order.
  [[nodiscard]] const std::vector<IndexEntry>& entries() const { return entries_; }
  [[nodiscard]] uint64_t hash() const { return hash_; }
  /// run_ids of each process, as far as HEALTH tells.
  [[nodiscard]] const std::map<std::string, std::set<int64_t>>& runs() const { return runs_; }
  [[nodiscard]] const std::vector<DamagedPart>& damage() const { return damage_; }
  /// Messages on this system's channels that can't be decoded.
  [[nodiscard]] int64_t unreadable() const { return unreadable_; }
  [[nodiscard]] int64_t frames_with_pixels() const { return frames_with_pixels_; }
  [[nodiscard]] int64_t frames_elsewhere() const { return frames_elsewhere_; }
  [[nodiscard]] bool frames_are_lossy() const { return frames_are_lossy_; }
  LogEvent load(const IndexEntry& entry) {
    reader_.seek(entry.position);
    auto event = reader_.next();
    if (!event) throw std::runtime_error("the log changed while it was read");
    return *std::move(event);
  }

 private:
  template <class M>
  void look_at(const LogEvent& event, const Channel<M>& channel) {
    if (event.channel != channel.name) return;
    const auto message = decode(event, channel);
    message ? ++readable_ : ++unreadable_;
    if (message) note(*message);
  }
  template <class M>
  void note(const M& /*message*/) {}
  void note(const health_t& health) { runs_[health.process].insert(health.header.trace.run_id); }
  void note(const frame_t& frame) {
    frame.encoding == frame_t::ENCODING_RING ? ++frames_elsewhere_ : ++frames_with_pixels_;
    frames_are_lossy_ = frames_are_lossy_ || frame.encoding == frame_t::ENCODING_JPEG;
  }

  LogReader reader_;
  std::vector<IndexEntry> entries_;
  std::map<std::string, std::set<int64_t>> runs_;
  std::vector<DamagedPart> damage_;
  int64_t readable_ = 0;
  int64_t unreadable_ = 0;
  int64_t frames_with_pixels_ = 0;
  int64_t frames_elsewhere_ = 0;
  bool frames_are_lossy_ = false;
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
      if (!is_asked(kind)) continue;
      kinds_.push_back(&kind);
      for (const auto& channel : kind.outputs) producer_[channel] = &kind;
    }
    need_pixels(log);
    for (const IndexEntry& entry :
         index_.entries()) {  // a log that starts in mid-flight: number as the flight did
      if (!entry.header || !producer_.contains(entry.channel)) continue;
      first_seq_.try_emplace({entry.channel, entry.header->trace.run_id}, entry.header->seq);
    }
    run_id_ = fnv1a(fnv1a(index_.hash(), options_.config_text), version());
    run_id_ = fnv1a(run_id_, options_.mode == ReplayMode::as_flown ? "as flown" : "every frame");
    for (const StageKind* kind : kinds_) run_id_ = fnv1a(run_id_, kind->process);
  }

  ReplayResult run(const ProgressSink& progress) {
    if (options_.mode == ReplayMode::every_frame) {
      for (const StageKind* kind : kinds_) running(*kind, 0);
    }
    const auto& entries = index_.entries();
    result_.events = static_cast<int64_t>(entries.size());
    result_.damage = index_.damage();
    result_.unreadable = index_.unreadable();
    result_.frames_are_lossy = index_.frames_are_lossy();
    for (size_t i = 0; i < entries.size(); ++i) {
      if (progress && i % 256 == 0) progress(static_cast<double>(i) / static_cast<double>(entries.size()));
      options_.mode == ReplayMode::as_flown ? step_as_flown(i) : step_every_frame(entries[i]);
    }
    compare();
    return result_;
  }

 private:
  /// Some of the pixels missing is told in the result, all of them is an error: every answer would be
  /// missing.
  void need_pixels(const std::string& log) {
    const auto& stages = options_.stages;
    if (!stages.empty() && !stages.contains("detector_proc") && !stages.contains("tracker_proc")) return;
    result_.frames_elsewhere = index_.frames_elsewhere();
    if (index_.frames_with_pixels() > 0) return;
    throw std::runtime_error(
        index_.frames_elsewhere() > 0
            ? fmt::format(
                  "{}: its {} frames are references to shared memory that is gone, their pixels are not in "
                  "the log. Write logs with `record`, which takes the pixels from there, or start the set "
                  "with camera.transport=jpeg",
                  log, index_.frames_elsewhere())
            : fmt::format("{}: there is no FRAME in it; --stages names stages that need none", log));
  }

  struct Running {
    std::unique_ptr<StageRun> run;
    std::map<std::pair<std::string, int64_t>, int64_t>
        delivered_seq;  ///< by channel and publisher's run in flight
  };

  [[nodiscard]] bool is_asked(const StageKind& kind) const {
    if (!options_.stages.empty()) return options_.stages.contains(kind.process);
    return kind.in_the_line || index_.runs().contains(kind.process);
  }

  /// The process' run of that id in the flight; made when it is first asked for.
  Running& running(const StageKind& kind, int64_t flight_run_id) {
    Running& running = running_[{kind.process, flight_run_id}];
    if (running.run) return running;
    const auto id =
        static_cast<int64_t>(fnv1a(run_id_ + static_cast<uint64_t>(++starts_), kind.process) >> 1);
    running.run = std::make_unique<StageRun>(
        kind, options_.config, id, journal_,
        [this, flight_run_id](const std::string& channel, const std::vector<uint8_t>& bytes) {
          on_output(channel, flight_run_id, bytes);
        });
    for (const auto& channel : kind.outputs) {
      const auto first = first_seq_.find({channel, flight_run_id});
      if (first != first_seq_.end()) running.run->bus.set_next_seq(channel, first->second);
    }
    return running;
  }

  /// A message on a replayed channel is its stage's own, unless HEALTH knows the stage's runs and this is
  /// none of them: an operator's.
  [[nodiscard]] const StageKind* producer_of(const IndexEntry& entry) const {
    const auto producer = producer_.find(entry.channel);
    if (producer == producer_.end()) return nullptr;
    const auto runs = index_.runs().find(producer->second->process);
    const bool known_stranger =
        entry.header && runs != index_.runs().end() && !runs->second.contains(entry.header->trace.run_id);
    return known_stranger ? nullptr : producer->second;
  }

  void on_output(const std::string& channel, int64_t flight_run_id, const std::vector<uint8_t>& bytes) {
    const LogEvent event{event_utime_, channel, bytes};
    write_(event);
    replayed_[{channel, flight_run_id, decode_header(bytes)->seq}] = event;
    if (options_.mode == ReplayMode::every_frame) queue_.push_back(event);
  }

  void step_every_frame(const IndexEntry& entry) {
    if (producer_of(entry)) return remember_logged(entry);
    const LogEvent event = index_.load(entry);
    event_utime_ = entry.utime;
    write_(event);
    queue_.push_back(event);
    const int64_t now = entry.header ? entry.header->trace.publish_utime : 0;
    while (!queue_.empty()) {
      const LogEvent next = std::move(queue_.front());
      queue_.pop_front();
      for (const StageKind* kind : kinds_) {
        ReplayBus& bus = running(*kind, 0).run->bus;
        if (bus.hears(next.channel)) bus.deliver(next, now);
      }
    }
  }

  void step_as_flown(size_t position) {
    const IndexEntry& entry = index_.entries()[position];
    const StageKind* producer = producer_of(entry);
    event_utime_ = entry.utime;
    if (!producer) {
      if (entry.header) inputs_[{entry.channel, entry.header->trace.run_id}][entry.header->seq] = position;
      return write_(index_.load(entry));
    }
    remember_logged(entry);
    if (!entry.header) return;
    Running& stage = running(*producer, entry.header->trace.run_id);
    bring_up_to(stage, producer->process == std::string("detector_proc"), entry.header->trace);
    // also where an input was missing and nothing was said: the next answer has the flight's number again
    stage.run->bus.set_next_seq(entry.channel, entry.header->seq + 1);
    if (entry.channel == channels::mission_journal.name)
      journal_ = decode(index_.load(entry), channels::mission_journal);
  }

  /// Hands the stage what it had read when it published, the cause last. newest_frames: it looks at the
  /// newest FRAME only, and what lies between was never handed to it.
  void bring_up_to(Running& stage, bool newest_frames, const trace_t& trace) {
    Inputs inputs, causes;
    for (const input_mark_t& mark : trace.inputs) {
      const auto known = stage.delivered_seq.find({mark.channel, mark.run_id});
      if (known != stage.delivered_seq.end() && known->second >= mark.seq) continue;
      int64_t first = known == stage.delivered_seq.end() ? mark.first_seq : known->second + 1;
      if (newest_frames && mark.channel == channels::frame.name) first = mark.seq;
      Inputs found = find_inputs(mark.channel, mark.run_id, first, mark.seq);
      if (mark.channel == trace.cause && !found.empty()) {
        causes.push_back(std::move(found.back()));
        found.pop_back();
      }
      std::move(found.begin(), found.end(), std::back_inserter(inputs));
      stage.delivered_seq[{mark.channel, mark.run_id}] = mark.seq;
    }
    const auto earlier = [](const auto& a, const auto& b) { return a.first < b.first; };
    std::stable_sort(inputs.begin(), inputs.end(), earlier);
    std::stable_sort(causes.begin(), causes.end(), earlier);
    for (const auto& [place, event] : inputs) stage.run->bus.deliver(event, trace.publish_utime);
    for (const auto& [place, event] : causes) stage.run->bus.deliver(event, trace.publish_utime);
  }

  using Inputs = std::vector<std::pair<size_t, LogEvent>>;  ///< with their places in the log

  /// Messages first to last by the flight's numbers: from the log, or what a replayed stage said in their
  /// place.
  Inputs find_inputs(const std::string& channel, int64_t run_id, int64_t first, int64_t last) {
    Inputs found;
    const MessageKey end_key{channel, run_id, last};
    for (auto made = replayed_.lower_bound({channel, run_id, first});
         made != replayed_.end() && made->first <= end_key; ++made) {
      const auto place = logged_.find(made->first);
      found.emplace_back(place == logged_.end() ? size_t{0} : place->second, made->second);
    }
    if (const auto run = inputs_.find({channel, run_id}); run != inputs_.end()) {
      for (auto entry = run->second.lower_bound(first); entry != run->second.end() && entry->first <= last;
           ++entry) {
        LogEvent event = index_.load(index_.entries()[entry->second]);
        const auto frame = decode(event, channels::frame);
        const bool pixels_elsewhere =
            frame && frame->encoding == frame_t::ENCODING_RING;  // of a ring that is long gone
        if (!pixels_elsewhere) found.emplace_back(entry->second, std::move(event));
      }
    }
    result_.missing_inputs += std::max<int64_t>(0, last - first + 1 - static_cast<int64_t>(found.size()));
    return found;
  }

  void remember_logged(const IndexEntry& entry) {
    if (!entry.header) return;
    const auto place = static_cast<size_t>(&entry - index_.entries().data());
    logged_[{entry.channel, entry.header->trace.run_id, entry.header->seq}] = place;
  }

  void compare() {
    for (const StageKind* kind : kinds_) result_.asked.push_back(kind->outputs.front());
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
      switch (match_of(logged, made->second, index_.frames_are_lossy())) {
        case Match::equal:
          ++comparison.equal;
          break;
        case Match::within_tolerance:
          ++comparison.within_tolerance;
          break;
        case Match::different:
          ++comparison.different;
          break;
      }
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
  std::map<std::string, const StageKind*> producer_;            ///< by channel
  std::map<std::pair<std::string, int64_t>, Running> running_;  ///< by process and its run in flight
  std::map<std::pair<std::string, int64_t>, std::map<int64_t, size_t>>
      inputs_;  ///< external: channel, run -> seq -> entry
  std::map<std::pair<std::string, int64_t>, int64_t>
      first_seq_;                             ///< of replayed channels in the log, by the flight's run
  std::map<MessageKey, size_t> logged_;       ///< outputs of the flight: entry
  std::map<MessageKey, LogEvent> replayed_;   ///< outputs of the replay, by the flight's numbers
  std::optional<mission_journal_t> journal_;  ///< the flight's newest so far
  std::deque<LogEvent> queue_;
  ReplayResult result_;
};

}  // namespace

std::vector<std::string> replayable_processes() {
  std::vector<std::string> names;
  for (const StageKind& kind : stage_kinds()) names.emplace_back(kind.process);
  return names;
}

bool ReplayResult::as_flown() const {
  const bool compared = std::all_of(asked.begin(), asked.end(), [this](const std::string& channel) {
    const auto found = channels.find(channel);
    return found != channels.end() && found->second.equal + found->second.within_tolerance > 0;
  });
  return compared && complete() && missing_inputs == 0 &&
         std::all_of(channels.begin(), channels.end(), [](const auto& entry) {
           return entry.second.different == 0 && entry.second.only_logged == 0 &&
                  entry.second.only_replayed == 0;
         });
}

bool ReplayResult::equal_to_the_bit() const {
  return std::all_of(channels.begin(), channels.end(),
                     [](const auto& entry) { return entry.second.within_tolerance == 0; });
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
