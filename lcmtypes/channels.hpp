// The one table of channels: name, type, publisher, nominal rate, maximum age, logged or not.
// Code, docs (`doctor --channels`) and the tools read it here.
#pragma once

#include <string>
#include <tuple>
#include <vector>

#include <stevedore/altimeter_t.hpp>
#include <stevedore/autopilot_status_t.hpp>
#include <stevedore/ellipses_t.hpp>
#include <stevedore/frame_t.hpp>
#include <stevedore/gimbal_command_t.hpp>
#include <stevedore/gimbal_state_t.hpp>
#include <stevedore/health_t.hpp>
#include <stevedore/hook_state_t.hpp>
#include <stevedore/mission_command_t.hpp>
#include <stevedore/mission_journal_t.hpp>
#include <stevedore/mission_t.hpp>
#include <stevedore/platform_estimate_t.hpp>
#include <stevedore/platform_state_t.hpp>
#include <stevedore/poses_t.hpp>
#include <stevedore/timeout_t.hpp>
#include <stevedore/track_command_t.hpp>
#include <stevedore/tracks_t.hpp>
#include <stevedore/truth_t.hpp>
#include <stevedore/vehicle_state_t.hpp>

namespace stevedore {

template <class M>
struct Channel {
  using Message = M;
  const char* name;
  const char* publisher;
  double rate_hz;    ///< nominal; 0: when something happens
  double max_age_s;  ///< older than this at the consumer is a fault; 0: no limit
  bool logged;
};

namespace channels {

// clang-format off
inline constexpr Channel<frame_t>             frame{"FRAME", "camera_proc or sim_proc", 30, 0.2, true};
inline constexpr Channel<ellipses_t>          ellipses{"ELLIPSES", "detector_proc", 30, 0.2, true};
inline constexpr Channel<tracks_t>            tracks{"TRACKS", "tracker_proc", 30, 0.2, true};
inline constexpr Channel<poses_t>             poses{"POSES", "pose_proc", 30, 0.2, true};
inline constexpr Channel<platform_estimate_t> platform_estimate{"PLATFORM_ESTIMATE", "pose_proc", 30, 0.5, true};
inline constexpr Channel<mission_t>           mission{"MISSION", "mission_proc", 30, 0.2, true};
inline constexpr Channel<mission_journal_t>   mission_journal{"MISSION_JOURNAL", "mission_proc", 0, 0, true};
inline constexpr Channel<track_command_t>     track_command{"TRACK_COMMAND", "mission_proc or an operator", 2, 1.0, true};
inline constexpr Channel<mission_command_t>   mission_command{"MISSION_COMMAND", "an operator", 0, 0, true};
inline constexpr Channel<vehicle_state_t>     vehicle_state{"VEHICLE_STATE", "autopilot or sim_proc", 50, 0.2, true};
inline constexpr Channel<autopilot_status_t>  autopilot_status{"AUTOPILOT_STATUS", "autopilot or sim_proc", 2, 2.0, true};
inline constexpr Channel<gimbal_command_t>    gimbal_command{"GIMBAL_COMMAND", "gimbal_proc", 50, 0.1, true};
inline constexpr Channel<gimbal_state_t>      gimbal_state{"GIMBAL_STATE", "gimbal or sim_proc", 50, 0.2, true};
inline constexpr Channel<gimbal_state_t>      gimbal_level{"GIMBAL_LEVEL", "gimbal_proc", 50, 0.2, true};
inline constexpr Channel<altimeter_t>         altimeter{"ALTIMETER", "laser or sim_proc", 20, 0.5, true};
inline constexpr Channel<hook_state_t>        hook_state{"HOOK_STATE", "hook or sim_proc", 10, 0.5, true};
inline constexpr Channel<platform_state_t>    platform_state{"PLATFORM_STATE", "platforms or sim_proc", 2, 2.0, true};
inline constexpr Channel<health_t>            health{"HEALTH", "every process", 1, 3.0, true};
inline constexpr Channel<timeout_t>           timeout{"TIMEOUT", "mission_proc", 0, 0, true};
inline constexpr Channel<truth_t>             truth{"TRUTH", "sim_proc", 30, 0, true};
// clang-format on

inline constexpr auto all = std::make_tuple(frame, ellipses, tracks, poses, platform_estimate, mission,
                                            mission_journal, track_command, mission_command, vehicle_state,
                                            autopilot_status, gimbal_command, gimbal_state, gimbal_level,
                                            altimeter, hook_state, platform_state, health, timeout, truth);

}  // namespace channels

/// A row of the table, for tools and docs.
struct ChannelInfo {
  std::string name;
  std::string type;
  std::string publisher;
  double rate_hz;
  double max_age_s;
  bool logged;
};

inline std::vector<ChannelInfo> channel_table() {
  std::vector<ChannelInfo> table;
  const auto add = [&table]<class M>(const Channel<M>& c) {
    table.push_back({c.name, M::getTypeName(), c.publisher, c.rate_hz, c.max_age_s, c.logged});
  };
  std::apply([&add](const auto&... channel) { (add(channel), ...); }, channels::all);
  return table;
}

}  // namespace stevedore
