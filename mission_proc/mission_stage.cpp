#include "mission_proc/mission_stage.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include <Eigen/Core>

#include "lcmtypes/convert.hpp"
#include "mission_proc/carry_messages.hpp"

namespace stevedore {
namespace {

constexpr int64_t repeat_us = 500'000;           // 2 Hz
constexpr int64_t longest_silence_us = 100'000;  // of MISSION while somebody flies by it

TargetStatus status_of(int8_t status) {
  switch (status) {
    case track_t::STATUS_TRACKING:
      return TargetStatus::tracking;
    case track_t::STATUS_PREDICTED:
      return TargetStatus::predicted;
    case track_t::STATUS_LOST:
      return TargetStatus::lost;
    default:
      return TargetStatus::searching;
  }
}

View to_view(const poses_t& poses) {
  View view;
  view.time_s = static_cast<double>(poses.header.utime) * 1e-6;
  if (poses.target_id >= 0) view.target_id = poses.target_id;
  view.target_status = status_of(poses.target_status);
  for (const pose_t& pose : poses.poses) {
    Mark mark;
    mark.track_id = pose.track_id;
    mark.label = label_of(pose.label);
    mark.measured = pose.status == track_t::STATUS_TRACKING;
    mark.center_px = {pose.u_px, pose.v_px};
    mark.semi_major_px = pose.a_px;
    mark.coverage = pose.coverage;
    mark.age_frames = pose.age_frames;
    if (pose.solution_count > 0) {
      mark.range_m = Eigen::Map<const Eigen::Vector3d>(pose.solutions[0].center_camera_m).norm();
    }
    view.marks.push_back(mark);
  }
  return view;
}

/// In the order of emergency_t's kinds, which begin at one.
int16_t to_message(Emergency kind) {
  return static_cast<int16_t>(static_cast<int>(kind) + 1);
}
static_assert(static_cast<int>(Emergency::identity_uncertain) + 1 == emergency_t::KIND_IDENTITY_UNCERTAIN);
static_assert(static_cast<int>(Emergency::gimbal_not_level) + 1 == emergency_t::KIND_GIMBAL_NOT_LEVEL);

GimbalCondition condition_of(int8_t status) {
  switch (status) {
    case gimbal_state_t::STATUS_AT_LIMIT:
      return GimbalCondition::at_limit;
    case gimbal_state_t::STATUS_STUCK:
      return GimbalCondition::stuck;
    case gimbal_state_t::STATUS_LATE:
      return GimbalCondition::late;
    default:
      return GimbalCondition::ok;
  }
}

CameraHold to_level(const gimbal_state_t& message) {
  CameraHold level;
  level.time_s = static_cast<double>(message.header.utime) * 1e-6;
  if (message.off_level_rad >= 0) level.off_level_rad = message.off_level_rad;
  level.gimbal = condition_of(message.status);
  return level;
}

/// Vision that is gone is got back from higher up; a target alone is looked for where the aircraft is; and an
/// aircraft that hovers is level itself, and with it a camera whose pan-tilt is stuck.
int8_t advised_action(Emergency kind) {
  const bool hover = kind == Emergency::target_lost || kind == Emergency::gimbal_not_level;
  return hover ? mission_t::ACTION_HOVER : mission_t::ACTION_CLIMB;
}

candidate_t to_message(const Candidate& candidate) {
  candidate_t message{};
  message.track_id = candidate.mark.track_id;
  message.platform = message.slot = -1;
  message.label = to_message(candidate.mark.label);
  message.eligible = candidate.eligible;
  message.chosen = candidate.chosen;
  message.cost = candidate.cost;
  message.reason = candidate.reason;
  return message;
}

emergency_t to_message(const RaisedEmergency& emergency, double time_s) {
  emergency_t message{};
  message.kind = to_message(emergency.kind);
  message.cause = emergency.cause;
  message.age_s = std::max(0.0, time_s - emergency.since_s);
  message.confidence = 1;
  message.advised_action = advised_action(emergency.kind);
  return message;
}

void set_target(mission_t& mission, const pose_t& pose) {
  mission.has_target_level = pose.has_level;
  for (int i = 0; i < 3; ++i) mission.target_level_m[i] = pose.center_level_m[i];
  if (pose.solution_count > 0) {
    for (int i = 0; i < 9; ++i) mission.target_level_covariance_m2[i] = pose.solutions[0].covariance_m2[i];
  }
  mission.target_age_s = pose.status == track_t::STATUS_TRACKING ? 0 : -1;
}

}  // namespace

MissionStage::MissionStage(const MissionSettings& settings, Bus& bus,
                           const std::optional<mission_journal_t>& journal, Keep keep)
    : bus_(bus),
      mission_(settings),
      vehicle_silent_us_(std::llround(settings.vehicle_silent_s * 1e6)),
      keep_(std::move(keep)) {
  if (settings.job == "carry")
    carry_.emplace(settings.carry, journal ? std::optional(from_message(*journal)) : std::nullopt);
  subscribe_for_watch();
  if (carry_) subscribe_for_carry();
}

void MissionStage::subscribe_for_watch() {
  bus_.subscribe<poses_t>(channels::poses, [this](const poses_t& m) { on_poses(m); });
  bus_.subscribe<vehicle_state_t>(channels::vehicle_state,
                                  [this](const vehicle_state_t& m) { on_vehicle(m); });
  bus_.subscribe<gimbal_state_t>(channels::gimbal_level,
                                 [this](const gimbal_state_t& m) { on_gimbal_level(m); });
  bus_.subscribe<timeout_t>(channels::timeout, [this](const timeout_t& m) { on_clock(m.header); });
  bus_.subscribe<mission_command_t>(channels::mission_command,
                                    [this](const mission_command_t& m) { on_command(m); });
}

void MissionStage::subscribe_for_carry() {
  bus_.subscribe<platform_estimate_t>(
      channels::platform_estimate, [this](const platform_estimate_t& m) { carry_->hear(from_message(m)); });
  bus_.subscribe<hook_state_t>(channels::hook_state,
                               [this](const hook_state_t& m) { carry_->hear(from_message(m)); });
  bus_.subscribe<autopilot_status_t>(channels::autopilot_status,
                                     [this](const autopilot_status_t& m) { carry_->hear(from_message(m)); });
  bus_.subscribe<altimeter_t>(channels::altimeter, [this](const altimeter_t& m) {
    if (m.valid) carry_->hear_laser(m.header.utime, m.range_m);
  });
}

void MissionStage::on_poses(const poses_t& poses) {
  mission_.see(to_view(poses));
  if (carry_) {
    carry_->see(from_message(poses));
    choose_for_carry(poses);
  }
  publish_track_command(poses.header);
  publish_mission(poses.header, &poses);
}

void MissionStage::on_vehicle(const vehicle_state_t& vehicle) {
  if (carry_) {
    carry_->hear(from_message(vehicle));
    write_journal(vehicle.header);
  }
  on_clock(vehicle.header);
  if (!carry_ || vehicle.header.utime - mission_utime_ < longest_silence_us) return;
  header_t cause{};
  cause.utime = vehicle.header.utime;
  cause.frame_seq = -1;
  publish_mission(cause, nullptr);
}

void MissionStage::on_clock(const header_t& header) {
  mission_.tick(static_cast<double>(header.utime) * 1e-6);
  publish_changes(header.utime);
}

void MissionStage::on_gimbal_level(const gimbal_state_t& level) {
  mission_.hear(to_level(level));
  publish_changes(level.header.utime);
}

void MissionStage::publish_changes(int64_t utime) {
  std::vector<Emergency> raised;
  for (const auto& emergency : emergencies()) raised.push_back(emergency.kind);
  const bool repeat = !raised.empty() && utime - mission_utime_ >= repeat_us;
  if (raised == told_ && !repeat) return;
  header_t cause{};
  cause.utime = utime;
  cause.frame_seq = -1;
  publish_mission(cause, nullptr);
}

void MissionStage::on_command(const mission_command_t& command) {
  switch (command.command) {
    case mission_command_t::COMMAND_START:
      return carry_ ? carry_->start() : mission_.resume();
    case mission_command_t::COMMAND_RESUME:
      return carry_ ? carry_->resume() : mission_.resume();
    case mission_command_t::COMMAND_HOLD:
      return carry_ ? carry_->hold() : mission_.hold();
    case mission_command_t::COMMAND_ABORT:
      return carry_ ? carry_->abort() : mission_.abort();
    case mission_command_t::COMMAND_CHOOSE:
      return carry_ ? carry_->wish({command.platform, command.slot}) : mission_.choose(command.track_id);
    default:
      return;  // fault_of lets no other through
  }
}

std::optional<Wanted> MissionStage::wanted() const {
  return carry_ ? carried_target_ : mission_.decision().wanted;
}

/// The circle that lies where the target does, for as long as there is a target: under a new number when it
/// is another one than before.
void MissionStage::choose_for_carry(const poses_t& poses) {
  if (!carry_->record().target) carried_target_.reset();
  const auto track = carry_->target_track();
  if (!track) return;
  const auto pose = std::find_if(poses.poses.begin(), poses.poses.end(),
                                 [&](const pose_t& p) { return p.track_id == *track; });
  if (pose == poses.poses.end()) return;
  const bool same = carried_target_ && carried_target_->track_id == *track;
  carried_target_ =
      Wanted{same ? carried_target_->choice : poses.header.utime, *track, {pose->u_px, pose->v_px}};
}

/// What is in view, and what the carrying finds wrong: of the target, that of the one which has it.
std::vector<RaisedEmergency> MissionStage::emergencies() const {
  if (!carry_) return mission_.decision().emergencies;
  std::vector<RaisedEmergency> all = carry_->emergencies();
  for (const RaisedEmergency& each : mission_.decision().emergencies) {
    const bool expected = each.kind != Emergency::all_out_of_view || carry_->expects_marks();
    if (each.kind != Emergency::target_lost && expected) all.push_back(each);
  }
  return all;
}

void MissionStage::write_journal(const header_t& cause) {
  if (carry_->record_number() == journalled_) return;
  journalled_ = carry_->record_number();
  mission_journal_t journal = to_message(carry_->record());
  journal.header.utime = cause.utime;
  journal.header.frame_seq = -1;
  if (keep_) keep_(journal);
  bus_.publish(channels::mission_journal, journal);
}

void MissionStage::publish_track_command(const header_t& cause) {
  const std::optional<Wanted> wanted = this->wanted();
  const int64_t choice = wanted ? wanted->choice : 0;
  if (choice == commanded_choice_ && std::abs(cause.utime - command_utime_) < repeat_us) return;
  if (!wanted && commanded_choice_ < 0) return;  // nothing was ever wanted
  track_command_t command{};
  command.header.utime = cause.utime;
  command.header.frame_seq = cause.frame_seq;
  command.action = wanted ? track_command_t::ACTION_BY_ID : track_command_t::ACTION_RELEASE;
  command.choice = choice;
  command.id = wanted ? wanted->track_id : -1;
  command.u_px = wanted ? wanted->last_seen_px.x() : -1;
  command.v_px = wanted ? wanted->last_seen_px.y() : -1;
  commanded_choice_ = choice;
  command_utime_ = cause.utime;
  bus_.publish(channels::track_command, command);
}

void MissionStage::publish_mission(const header_t& cause, const poses_t* poses) {
  const Decision& decision = mission_.decision();
  const double time_s = static_cast<double>(cause.utime) * 1e-6;
  mission_t mission{};
  mission.header.utime = cause.utime;
  mission.header.frame_seq = cause.frame_seq;
  mission.phase = static_cast<int8_t>(decision.phase);
  mission.phase_utime = std::llround(decision.phase_since_s * 1e6);
  mission.action = decision.phase == Phase::approach ? mission_t::ACTION_GO_TO : mission_t::ACTION_HOVER;
  mission.target_id = decision.wanted ? decision.wanted->track_id : -1;
  mission.target_status = poses ? poses->target_status : track_t::STATUS_LOST;
  mission.target_platform = mission.target_slot = -1;
  mission.target_age_s = -1;
  mission.reason = decision.reason;
  for (const Candidate& candidate : decision.candidates) mission.candidates.push_back(to_message(candidate));
  mission.candidate_count = static_cast<int16_t>(mission.candidates.size());
  told_.clear();
  for (const RaisedEmergency& emergency : emergencies()) {
    mission.emergencies.push_back(to_message(emergency, time_s));
    told_.push_back(emergency.kind);
  }
  mission.emergency_count = static_cast<int16_t>(mission.emergencies.size());
  if (poses) {
    for (const pose_t& pose : poses->poses) {
      const bool measured = pose.status == track_t::STATUS_TRACKING;
      if (measured && pose.label == ellipse_t::LABEL_CIRCLE) ++mission.circles_in_view;
      if (measured && pose.label == ellipse_t::LABEL_CARGO) ++mission.cargoes_in_view;
      if (pose.track_id == mission.target_id) set_target(mission, pose);
    }
  }
  if (carry_) describe(*carry_, cause.utime, mission);
  const bool vehicle_silent = carry_ && cause.utime - carry_->utime() > vehicle_silent_us_;
  if (vehicle_silent && mission.has_setpoint) {  // nobody knows where the aircraft is
    mission.has_setpoint = false;
    mission.action = mission_t::ACTION_HOVER;
  }
  mission_utime_ = cause.utime;
  bus_.publish(channels::mission, mission);
}

}  // namespace stevedore
