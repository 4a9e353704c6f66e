// Between the carrying of cargoes and its messages.
#pragma once

#include "lcmtypes/channels.hpp"
#include "mission_proc/carry.hpp"

namespace stevedore {

HookReport from_message(const hook_state_t& message);
AutopilotReport from_message(const autopilot_status_t& message);
DeckNews from_message(const platform_estimate_t& message);
LevelFrame from_message(const poses_t& message);

mission_journal_t to_message(const CarryRecord& record);
CarryRecord from_message(const mission_journal_t& message);

/// What MISSION says of it; nothing else of the message is touched.
void describe(const Carry& carry, std::int64_t utime, mission_t& mission);

}  // namespace stevedore
