// POSES, PLATFORM_ESTIMATE, GIMBAL_LEVEL, HOOK_STATE, AUTOPILOT_STATUS, ALTIMETER, VEHICLE_STATE or TIMEOUT
// as the clock, and the operator's MISSION_COMMAND in; MISSION, TRACK_COMMAND and MISSION_JOURNAL out.
#pragma once

#include <functional>
#include <optional>

#include "mission_proc/carry.hpp"
#include "mission_proc/mission.hpp"
#include "runtime/bus.hpp"

namespace stevedore {

class MissionStage {
 public:
  /// Called with each new line of the journal, before anything is done upon it.
  using Keep = std::function<void(const mission_journal_t&)>;

  /// journal: the last line of a mission that was killed.
  MissionStage(const MissionSettings& settings, Bus& bus,
               const std::optional<mission_journal_t>& journal = std::nullopt, Keep keep = {});

 private:
  void subscribe_for_watch();
  void subscribe_for_carry();
  void on_poses(const poses_t& poses);
  void on_vehicle(const vehicle_state_t& vehicle);
  /// Time told by a message that brings no vision.
  void on_clock(const header_t& header);
  void on_gimbal_level(const gimbal_state_t& level);
  void on_command(const mission_command_t& command);
  /// MISSION when an emergency has come or gone, and at 2 Hz while there is one.
  void publish_changes(int64_t utime);
  void publish_mission(const header_t& cause, const poses_t* poses);
  /// When the choice changed, and again at 2 Hz for a tracker that was restarted.
  void publish_track_command(const header_t& cause);
  /// What the tracker is to follow.
  [[nodiscard]] std::optional<Wanted> wanted() const;
  void choose_for_carry(const poses_t& poses);
  [[nodiscard]] std::vector<RaisedEmergency> emergencies() const;
  void write_journal(const header_t& cause);

  Bus& bus_;
  Mission mission_;
  const int64_t vehicle_silent_us_;
  std::optional<Carry> carry_;
  std::optional<Wanted> carried_target_;
  Keep keep_;
  int64_t journalled_ = 0;       ///< number of the record in the newest MISSION_JOURNAL
  std::vector<Emergency> told_;  ///< in the newest MISSION
  int64_t mission_utime_ = 0;    ///< of the newest MISSION
  int64_t command_utime_ = 0;    ///< of the newest TRACK_COMMAND
  int64_t commanded_choice_ = -1;
};

}  // namespace stevedore
