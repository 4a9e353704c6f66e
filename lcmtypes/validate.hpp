// Is a received message fit for use? The bus is not authenticated: everything is checked before anything uses
// it.
#pragma once

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

}  // namespace stevedore
