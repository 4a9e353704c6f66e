// Words for the numbers in messages, for people.
#pragma once

#include <array>
#include <cstddef>

#include "lcmtypes/channels.hpp"

namespace stevedore {

template <size_t N>
const char* name_of(const std::array<const char*, N>& names, int number) {
  return number >= 0 && static_cast<size_t>(number) < N ? names[static_cast<size_t>(number)] : "?";
}

/// track_t::STATUS_*
inline const char* status_name(int8_t status) {
  return name_of(std::array{"?", "searching", "tracking", "predicted", "lost"}, status);
}

/// mission_t::PHASE_*
inline const char* phase_name(int8_t phase) {
  return name_of(
      std::array{"idle", "take-off", "search", "approach", "descend", "load", "verify load", "transit",
                 "drop", "verify drop", "return", "land", "retry", "hold", "suspended", "abort", "complete"},
      phase);
}

/// mission_t::ACTION_*
inline const char* action_name(int8_t action) {
  return name_of(std::array{"none", "hover", "go to", "descend", "grab", "release", "climb", "land"}, action);
}

/// emergency_t::KIND_*
inline const char* emergency_name(int16_t kind) {
  return name_of(
      std::array{"?", "all out of view", "target lost", "vision stale", "platform not found", "camera frozen",
                 "altitude disagrees", "cargo lost", "gimbal not level", "identity uncertain"},
      kind);
}

/// health_t::STATE_*
inline const char* state_name(int8_t state) {
  return name_of(std::array{"starting", "ok", "degraded", "failed", "finished"}, state);
}

}  // namespace stevedore
