#include "tools/evaluate_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <stdexcept>

namespace stevedore {
namespace {

/// false: it is on this channel and can't be read.
template <class M>
bool keep(const LogEvent& event, const Channel<M>& channel, std::vector<M>& messages) {
  if (event.channel != channel.name) return true;
  auto message = decode(event, channel);
  if (!message) return false;
  messages.push_back(*std::move(message));
  return true;
}

template <class M>
void sort_by_time(std::vector<M>& messages) {
  std::stable_sort(messages.begin(), messages.end(),
                   [](const M& a, const M& b) { return a.header.utime < b.header.utime; });
}

/// Of a message on one of this system's channels; 0: none that could be.
std::int64_t stamp_of(const LogEvent& event) {
  static const std::vector<ChannelInfo> channels = channel_table();
  const bool is_ours = std::any_of(channels.begin(), channels.end(),
                                   [&](const ChannelInfo& each) { return each.name == event.channel; });
  const auto header = is_ours ? decode_header(event.bytes) : std::nullopt;
  return header ? std::max<std::int64_t>(0, header->utime) : 0;
}

/// From capture to the first answer to each frame. Files played as fast as possible carry stamps of their own
/// schedule, ahead of the clock: those count as zero.
class Latencies {
 public:
  void add(const LogEvent& event, const char* channel) {
    if (event.channel != channel) return;
    const auto header = decode_header(event.bytes);
    if (!header || header->frame_seq < 0) return;
    const double late_ms = static_cast<double>(header->trace.publish_utime - header->utime) * 1e-3;
    by_utime_ms_.try_emplace(header->utime, std::max(0.0, late_ms));
  }
  [[nodiscard]] std::vector<double> values_ms() const {
    std::vector<double> values;
    for (const auto& [utime, late_ms] : by_utime_ms_) values.push_back(late_ms);
    return values;
  }

 private:
  std::map<int64_t, double> by_utime_ms_;
};

}  // namespace

FlightLog read_flight(const std::string& path) {
  LogReader reader(path);
  FlightLog flight;
  LogSummary summary;
  Latencies to_poses, to_mission;
  while (const auto event = reader.next()) {
    summary.add(*event);
    if (flight.start_utime == 0) flight.start_utime = stamp_of(*event);
    keep(*event, channels::truth, flight.truth);
    keep(*event, channels::poses, flight.poses);
    keep(*event, channels::platform_estimate, flight.estimates);
    flight.unreadable += !keep(*event, channels::altimeter, flight.altimeter);
    keep(*event, channels::vehicle_state, flight.vehicle);
    flight.unreadable += !keep(*event, channels::gimbal_state, flight.gimbal);
    to_poses.add(*event, channels::poses.name);
    to_mission.add(*event, channels::mission.name);
  }
  flight.report = summary.report();
  flight.unreadable += flight.report.unreadable;  // of the other channels
  flight.damage = reader.damage();
  if (flight.poses.empty() && flight.estimates.empty()) {
    throw std::runtime_error(fmt::format(
        "{}: no POSES and no PLATFORM_ESTIMATE can be read in it, so there is nothing to evaluate. {}", path,
        describe(flight.damage)));
  }
  flight.to_poses_ms = to_poses.values_ms();
  flight.to_mission_ms = to_mission.values_ms();
  sort_by_time(flight.truth);
  sort_by_time(flight.poses);
  sort_by_time(flight.estimates);
  sort_by_time(flight.altimeter);
  sort_by_time(flight.vehicle);
  sort_by_time(flight.gimbal);
  return flight;
}

}  // namespace stevedore
