// What `evaluate` reads of a log: messages by kind, each in the order of its time stamps.
#pragma once

#include <string>
#include <vector>

#include "lcmtypes/channels.hpp"
#include "runtime/event_log.hpp"
#include "tools/report_core.hpp"

namespace stevedore {

struct FlightLog {
  /// Stamp of the log's first message that has one: the zero of seconds, as `explain` and `report` count them
  /// but for what it took to log it.
  std::int64_t start_utime = 0;
  std::vector<truth_t> truth;
  std::vector<poses_t> poses;
  std::vector<platform_estimate_t> estimates;
  std::vector<altimeter_t> altimeter;
  std::vector<vehicle_state_t> vehicle;
  std::vector<gimbal_state_t> gimbal;
  Report report;  ///< frames, losses, latencies
  std::vector<DamagedPart> damage;
  std::int64_t unreadable = 0;        ///< messages that are not of their channel's type, of what is looked at
  std::vector<double> to_poses_ms;    ///< capture to POSES, of each frame
  std::vector<double> to_mission_ms;  ///< capture to the first MISSION of each frame
};

/// Throws std::runtime_error that says why, where the log can't be read or nothing of this system is in it.
FlightLog read_flight(const std::string& path);

/// The message whose time stamp is nearest; nullptr where none is within the tolerance.
template <class M>
const M* nearest(const std::vector<M>& messages, int64_t utime, int64_t tolerance_us) {
  const auto after = std::lower_bound(messages.begin(), messages.end(), utime,
                                      [](const M& m, int64_t t) { return m.header.utime < t; });
  const M* best = after == messages.end() ? nullptr : &*after;
  if (after != messages.begin()) {
    const M& before = *(after - 1);
    if (!best || utime - before.header.utime < best->header.utime - utime) best = &before;
  }
  return best && std::abs(best->header.utime - utime) <= tolerance_us ? best : nullptr;
}

/// The messages before and after a moment, for what is interpolated.
template <class M>
struct Between {
  const M* before;
  const M* after;
  double share;  ///< of the way from before to after
};

/// Nothing where one of them is farther away than the tolerance.
template <class M>
std::optional<Between<M>> around(const std::vector<M>& messages, int64_t utime, int64_t tolerance_us) {
  const auto after = std::lower_bound(messages.begin(), messages.end(), utime,
                                      [](const M& m, int64_t t) { return m.header.utime < t; });
  if (after == messages.end()) return std::nullopt;
  if (after->header.utime == utime) return Between<M>{&*after, &*after, 0};
  if (after == messages.begin()) return std::nullopt;
  const M &before = *(after - 1), &next = *after;
  if (utime - before.header.utime > tolerance_us || next.header.utime - utime > tolerance_us)
    return std::nullopt;
  return Between<M>{&before, &next,
                    static_cast<double>(utime - before.header.utime) /
                        static_cast<double>(next.header.utime - before.header.utime)};
}

}  // namespace stevedore
