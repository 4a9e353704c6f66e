// Is a received message fit for use? The bus is not authenticated: everything is checked before anything uses
// it.
#pragma once

#include <exception>
#include <optional>
#include <string>

#include "lcmtypes/channels.hpp"

namespace stevedore {

/// What is wrong with a message (the field and why), or nothing. Checked: finite numbers, sizes against
/// lengths, ranges, enum values.
std::optional<std::string> fault_of(const frame_t& message);
std::optional<std::string> fault_of(const ellipses_t& message);
std::optional<std::string> fault_of(const tracks_t& message);
std::optional<std::string> fault_of(const poses_t& message);
std::optional<std::string> fault_of(const platform_estimate_t& message);
std::optional<std::string> fault_of(const mission_t& message);
std::optional<std::string> fault_of(const mission_journal_t& message);
std::optional<std::string> fault_of(const track_command_t& message);
std::optional<std::string> fault_of(const mission_command_t& message);
std::optional<std::string> fault_of(const vehicle_state_t& message);
std::optional<std::string> fault_of(const autopilot_status_t& message);
std::optional<std::string> fault_of(const gimbal_command_t& message);
std::optional<std::string> fault_of(const gimbal_state_t& message);
std::optional<std::string> fault_of(const altimeter_t& message);
std::optional<std::string> fault_of(const hook_state_t& message);
std::optional<std::string> fault_of(const platform_state_t& message);
std::optional<std::string> fault_of(const health_t& message);
std::optional<std::string> fault_of(const timeout_t& message);
std::optional<std::string> fault_of(const truth_t& message);

/// Whether a frame's size is no more than what came with it: lcm-gen's decode reserves the size before it
/// looks.
bool size_is_there(const void* data, int size, const frame_t* type);
/// The other messages count with 16 bits: what they make decode reserve is bounded.
inline bool size_is_there(const void*, int, const void*) {
  return true;
}

/// The message in these bytes; nothing if they are another type, too few, too many, or no message to use.
template <class M>
std::optional<M> decode_checked(const void* data, int size) {
  if (!size_is_there(data, size, static_cast<const M*>(nullptr))) return std::nullopt;
  M message{};
  try {  // decode resizes by lengths from the wire, negative ones too
    if (message.decode(data, 0, size) != size || fault_of(message)) return std::nullopt;
  } catch (const std::exception&) {
    return std::nullopt;
  }
  return message;
}

}  // namespace stevedore
