// POSES, GIMBAL_LEVEL, VEHICLE_STATE or TIMEOUT as the clock, and the operator's MISSION_COMMAND in; MISSION
// and TRACK_COMMAND out.
#pragma once

#include "mission_proc/mission.hpp"
#include "runtime/bus.hpp"

namespace stevedore {

class MissionStage {
 public:
  MissionStage(const MissionSettings& settings, Bus& bus);

 private:
  void on_poses(const poses_t& poses);
  /// Time told by a message that brings no vision.
  void on_clock(const header_t& header);
  void on_gimbal_level(const gimbal_state_t& level);
  void on_command(const mission_command_t& command);
  /// MISSION when an emergency has come or gone, and at 2 Hz while there is one.
  void publish_changes(int64_t utime);
  void publish_mission(const header_t& cause, const poses_t* poses);
  /// When the choice changed, and again at 2 Hz for a tracker that was restarted.
  void publish_track_command(const header_t& cause);

  Bus& bus_;
  Mission mission_;
  std::vector<Emergency> told_;  ///< in the newest MISSION
  int64_t mission_utime_ = 0;    ///< of the newest MISSION
  int64_t command_utime_ = 0;    ///< of the newest TRACK_COMMAND
  int64_t commanded_choice_ = -1;
};

}  // namespace stevedore
