#include "runtime/bus.hpp"

#include <algorithm>
#include <limits>

#include "runtime/event_log.hpp"

namespace stevedore {
namespace {

/// Publishers that restarted are forgotten after this many newer ones: a channel has one or two at a time.
constexpr size_t remembered_publishers = 8;

/// A step back of so few numbers is a late message, a step forward of so many is no gap but another count.
constexpr int64_t late_by_at_most = 100;
constexpr int64_t gap_at_most = 1'000'000;

/// Numbers missing before seq; -1 for one that was counted as missing and comes late after all.
int64_t gap_before(const std::vector<HeardRun>& runs, int64_t run_id, int64_t seq) {
  for (const HeardRun& run : runs) {
    if (run.run_id != run_id) continue;
    const int64_t step = seq - run.newest_seq;
    if (step > 1 && step <= gap_at_most) return step - 1;
    if (step < 0 && step >= -late_by_at_most) return -1;
  }
  return 0;
}

void remember(std::vector<HeardRun>& runs, int64_t run_id, int64_t seq) {
  HeardRun run{run_id, seq, seq};
  const auto known =
      std::find_if(runs.begin(), runs.end(), [run_id](const HeardRun& r) { return r.run_id == run_id; });
  if (known != runs.end()) {
    run.first_seq = known->first_seq;
    if (seq < known->newest_seq && seq >= known->newest_seq - late_by_at_most)
      run.newest_seq = known->newest_seq;
    runs.erase(known);
  }
  if (runs.size() >= remembered_publishers) runs.erase(runs.begin());
  runs.push_back(run);
}

/// Whether this number follows on what was heard of a run.
bool follows(const std::vector<HeardRun>& runs, int64_t run_id, int64_t seq) {
  return std::any_of(runs.begin(), runs.end(), [&](const HeardRun& run) {
    return run.run_id == run_id && seq > run.newest_seq && seq - run.newest_seq <= gap_at_most;
  });
}

/// The header of a message of this type, whatever the rest of it is worth.
std::optional<header_t> header_of(const void* data, size_t size, int64_t fingerprint) {
  const auto* bytes = static_cast<const uint8_t*>(data);
  int64_t hash = 0;
  if (size < sizeof hash || __int64_t_decode_array(bytes, 0, static_cast<int>(sizeof hash), &hash, 1) < 0 ||
      hash != fingerprint)
    return std::nullopt;
  return decode_header({bytes, bytes + size});
}

/// No message comes near it (a frame has 200 MB at most); LCM counts bytes with an int.
constexpr size_t oversized_bytes = std::numeric_limits<int>::max() / 2;

/// Ages kept between two HEALTH messages; more than a second of the fastest channel.
constexpr size_t most_ages = 4096;

}  // namespace

void Bus::add_input(const std::string& channel, std::unique_ptr<Input> input) {
  if (!inputs_.emplace(channel, std::move(input)).second) {
    throw std::logic_error("subscribed twice to " + channel);
  }
  listen(channel);
}

void Bus::receive(const std::string& channel, const void* data, size_t size) {
  const auto found = inputs_.find(channel);
  if (found == inputs_.end()) return;
  Input& input = *found->second;
  ++input.counters_.received;
  const bool superseded = input.waiting_.has_value();
  const auto header = size <= oversized_bytes ? input.decode(data, static_cast<int>(size)) : std::nullopt;
  if (!header) {
    ++input.counters_.lost_malformed;
    if (size <= oversized_bytes) count_once(input, header_of(data, size, input.fingerprint()));
    return;
  }
  input.counters_.lost_gap += gap_before(input.arrived_, header->trace.run_id, header->seq);
  remember(input.arrived_, header->trace.run_id, header->seq);
  if (superseded) ++input.counters_.skipped;
  input.waiting_ = header;
  input.waiting_since_utime_ = now_utime();
  if (input.ages_us_.size() < most_ages) input.ages_us_.push_back(input.waiting_since_utime_ - header->utime);
  if (input.delivery_ == Delivery::every) hand_out(channel, input);
}

void Bus::count_once(Input& input, const std::optional<header_t>& refused) {
  if (!refused || !follows(input.arrived_, refused->trace.run_id, refused->seq)) return;
  input.counters_.lost_gap += gap_before(input.arrived_, refused->trace.run_id, refused->seq);
  remember(input.arrived_, refused->trace.run_id, refused->seq);
}

void Bus::deliver_newest() {
  for (auto& [channel, input] : inputs_) {
    if (input->waiting_) hand_out(channel, *input);
  }
}

void Bus::hand_out(const std::string& channel, Input& input) {
  remember(input.handled_, input.waiting_->trace.run_id, input.waiting_->seq);
  if (input.waiting_->trace.run_id != run_id_)
    stream_lag_us_ = input.waiting_since_utime_ - input.waiting_->utime;
  input.waiting_.reset();
  ++input.counters_.handled;
  cause_ = channel;
  cause_receive_utime_ = input.waiting_since_utime_;
  input.handle();
  cause_.clear();
  cause_receive_utime_ = 0;
}

void Bus::stamp(const std::string& channel, header_t& header) {
  header.seq = next_seq_[channel]++;
  trace_t& trace = header.trace;
  trace.run_id = run_id_;
  trace.receive_utime = cause_receive_utime_;
  trace.publish_utime = now_utime();
  trace.cause = cause_;
  trace.inputs.clear();
  for (const auto& [input_channel, input] : inputs_) {
    for (const HeardRun& run : input->handled_) {
      input_mark_t mark{};
      mark.channel = input_channel;
      mark.run_id = run.run_id;
      mark.first_seq = run.first_seq;
      mark.seq = run.newest_seq;
      trace.inputs.push_back(mark);
    }
  }
  trace.input_count = static_cast<int16_t>(trace.inputs.size());
}

int64_t Bus::stream_utime() const {
  return now_utime() - stream_lag_us_.value_or(0);
}

void Bus::count_loss(const std::string& channel, Loss loss) {
  InputCounters& counters = inputs_.at(channel)->counters_;
  switch (loss) {
    case Loss::malformed:
      ++counters.lost_malformed;
      break;
    case Loss::stale:
      ++counters.lost_stale;
      break;
    case Loss::overwritten:
      ++counters.lost_overwritten;
      break;
  }
}

const InputCounters& Bus::counters(const std::string& channel) const {
  return inputs_.at(channel)->counters_;
}

std::vector<std::string> Bus::inputs() const {
  std::vector<std::string> names;
  for (const auto& [channel, input] : inputs_) names.push_back(channel);
  return names;
}

std::vector<int64_t> Bus::take_ages_us(const std::string& channel) {
  return std::exchange(inputs_.at(channel)->ages_us_, {});
}

}  // namespace stevedore
