#include "runtime/bus.hpp"

#include <limits>

namespace stevedore {
namespace {

/// Publishers that restarted are forgotten after this many newer ones: a channel has one or two at a time.
constexpr size_t remembered_publishers = 8;

/// The publisher heard last stands last.
void remember(SeqByRun& seq_by_run, int64_t run_id, int64_t seq) {
  std::erase_if(seq_by_run, [run_id](const auto& entry) { return entry.first == run_id; });
  if (seq_by_run.size() >= remembered_publishers) seq_by_run.erase(seq_by_run.begin());
  seq_by_run.emplace_back(run_id, seq);
}

/// Larger than any message but an uncompressed frame.
constexpr int oversized_bytes = std::numeric_limits<int>::max() / 2;

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
  const auto header = size < oversized_bytes ? input.decode(data, static_cast<int>(size)) : std::nullopt;
  if (!header) {
    ++input.counters_.lost_malformed;
    return;
  }
  for (const auto& [run_id, newest_seq] : input.newest_seq_) {
    if (run_id == header->trace.run_id && header->seq > newest_seq + 1) {
      input.counters_.lost_gap += header->seq - newest_seq - 1;
    }
  }
  remember(input.newest_seq_, header->trace.run_id, header->seq);
  if (superseded) ++input.counters_.skipped;
  input.waiting_ = header;
  input.waiting_since_utime_ = now_utime();
  if (input.ages_us_.size() < most_ages) input.ages_us_.push_back(input.waiting_since_utime_ - header->utime);
  if (input.delivery_ == Delivery::every) hand_out(channel, input);
}

void Bus::deliver_newest() {
  for (auto& [channel, input] : inputs_) {
    if (input->waiting_) hand_out(channel, *input);
  }
}

void Bus::hand_out(const std::string& channel, Input& input) {
  remember(input.handled_seq_, input.waiting_->trace.run_id, input.waiting_->seq);
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
    for (const auto& [run_id, seq] : input->handled_seq_) {
      input_mark_t mark{};
      mark.channel = input_channel;
      mark.run_id = run_id;
      mark.seq = seq;
      trace.inputs.push_back(mark);
    }
  }
  trace.input_count = static_cast<int16_t>(trace.inputs.size());
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
