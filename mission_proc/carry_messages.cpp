#include "mission_proc/carry_messages.hpp"

#include <cmath>

#include "lcmtypes/convert.hpp"

namespace stevedore {
namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

static_assert(static_cast<int>(Phase::complete) == mission_t::PHASE_COMPLETE);
static_assert(static_cast<int>(Phase::verify_drop) == mission_t::PHASE_VERIFY_DROP);
static_assert(static_cast<int>(Action::land) == mission_t::ACTION_LAND);
static_assert(static_cast<int>(Action::grab) == mission_t::ACTION_GRAB);

Eigen::Vector3d vector_of(const double (&values)[3]) {
  return Eigen::Map<const Eigen::Vector3d>(values);
}

void put(const Eigen::Vector3d& from, double (&to)[3]) {
  Eigen::Map<Eigen::Vector3d>{to} = from;
}

double across_variance_m2(const circle_solution_t& solution) {
  const Eigen::Vector3d sight = vector_of(solution.center_camera_m).normalized();
  const Eigen::Map<const RowMajor3> covariance(solution.covariance_m2);
  return (covariance.trace() - sight.dot(covariance * sight)) / 2;
}

SlotCondition condition_of(std::int8_t state) {
  switch (state) {
    case slot_t::STATE_EMPTY:
      return SlotCondition::empty;
    case slot_t::STATE_OCCUPIED:
      return SlotCondition::occupied;
    case slot_t::STATE_MISPLACED:
      return SlotCondition::misplaced;
    default:
      return SlotCondition::unknown;
  }
}

/// Of a deck that turns and tilts as it moves.
Eigen::Vector3d up_of(double heading_rad, double roll_rad, double pitch_rad) {
  const Eigen::Quaterniond ned_from_deck = Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitZ()) *
                                           Eigen::AngleAxisd(pitch_rad, Eigen::Vector3d::UnitY()) *
                                           Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitX());
  return ned_from_deck * -Eigen::Vector3d::UnitZ();
}

candidate_t to_message(const SlotCandidate& candidate, bool loaded) {
  candidate_t message{};
  message.track_id = -1;
  message.platform = static_cast<std::int16_t>(candidate.slot.platform);
  message.slot = static_cast<std::int16_t>(candidate.slot.slot);
  message.label = loaded ? ellipse_t::LABEL_CIRCLE : ellipse_t::LABEL_CARGO;
  message.eligible = candidate.eligible;
  message.chosen = candidate.chosen;
  message.cost = candidate.cost;
  message.reason = candidate.reason;
  return message;
}

void set_target(const CarryTarget& target, mission_t& mission) {
  mission.target_platform = static_cast<std::int16_t>(target.slot.platform);
  mission.target_slot = static_cast<std::int16_t>(target.slot.slot);
  mission.has_target_level = mission.has_target_ned = true;
  put(target.from_camera_level_m, mission.target_level_m);
  put(target.ned_m, mission.target_ned_m);
  put(target.velocity_ned_mps, mission.target_velocity_ned_mps);
  Eigen::Map<RowMajor3>(mission.target_ned_covariance_m2) = target.covariance_ned_m2;
  Eigen::Map<RowMajor3>(mission.target_level_covariance_m2) = target.covariance_level_m2;
  mission.target_age_s = target.age_s < 1e8 ? std::max(0.0, target.age_s) : -1;
}

}  // namespace

HookReport from_message(const hook_state_t& m) {
  return {m.load_n, m.closed != 0};
}

AutopilotReport from_message(const autopilot_status_t& m) {
  return {m.mode == autopilot_status_t::MODE_GUIDED && m.armed, m.mode == autopilot_status_t::MODE_LAND,
          m.landed != 0, m.battery_share};
}

DeckNews from_message(const platform_estimate_t& m) {
  DeckNews report;
  report.platform = m.platform;
  report.utime = m.header.utime;
  report.seen_utime = m.seen_utime;
  report.heading_rad = m.heading_rad;
  report.turn_rate_radps = m.turn_rate_radps;
  report.identity_certain = m.identity_certain != 0;
  report.knots.push_back({0, vector_of(m.center_ned_m), vector_of(m.velocity_ned_mps),
                          up_of(m.heading_rad, m.roll_rad, m.pitch_rad), false});
  for (const deck_prediction_t& p : m.predictions) {
    if (p.ahead_s <= report.knots.back().ahead_s) continue;
    report.knots.push_back({p.ahead_s, vector_of(p.center_ned_m), vector_of(p.velocity_ned_mps),
                            vector_of(p.normal_ned), p.safe_to_lower != 0});
  }
  for (const slot_t& s : m.slots) {
    SlotReport slot;
    slot.center_ned_m = vector_of(s.center_ned_m);
    slot.covariance_m2 = Eigen::Map<const RowMajor3>(s.covariance_m2);
    slot.condition = condition_of(s.state);
    slot.confidence = s.confidence;
    slot.seen_utime = s.seen_utime;
    report.slots.push_back(slot);
  }
  return report;
}

LevelFrame from_message(const poses_t& m) {
  LevelFrame frame;
  frame.utime = m.header.utime;
  for (const pose_t& pose : m.poses) {
    if (!pose.has_level || pose.ellipse_index < 0) continue;
    frame.marks.push_back({pose.track_id,
                           label_of(pose.label),
                           vector_of(pose.center_level_m),
                           {pose.u_px, pose.v_px},
                           pose.solutions.empty() ? 0 : across_variance_m2(pose.solutions.front())});
  }
  return frame;
}

mission_journal_t to_message(const CarryRecord& record) {
  mission_journal_t m{};
  m.phase = static_cast<std::int8_t>(record.phase);
  m.target_platform = static_cast<std::int16_t>(record.target ? record.target->platform : -1);
  m.target_slot = static_cast<std::int16_t>(record.target ? record.target->slot : -1);
  m.carrying = record.loaded;
  m.homeward = record.homeward;
  m.attempts = static_cast<std::int16_t>(record.attempts);
  m.written_off = static_cast<std::int16_t>(record.written_off);
  put(record.home_ned_m, m.home_ned_m);
  put(record.hook_off_m, m.hook_off_m);
  m.hook_lessons = static_cast<std::int16_t>(record.hook_lessons);
  for (const DeliveredCargo& d : record.delivered) {
    mission_delivery_t delivery{};
    delivery.platform = static_cast<std::int16_t>(d.slot.platform);
    delivery.slot = static_cast<std::int16_t>(d.slot.slot);
    delivery.off_m = d.off_m;
    m.deliveries.push_back(delivery);
  }
  for (const auto& [slot, times] : record.failures) {
    mission_failure_t failure{};
    failure.platform = static_cast<std::int16_t>(slot.platform);
    failure.slot = static_cast<std::int16_t>(slot.slot);
    failure.times = static_cast<std::int16_t>(times);
    m.failures.push_back(failure);
  }
  for (const SlotId& slot : record.taken) {
    mission_slot_t taken{};
    taken.platform = static_cast<std::int16_t>(slot.platform);
    taken.slot = static_cast<std::int16_t>(slot.slot);
    m.taken.push_back(taken);
  }
  m.taken_count = static_cast<std::int16_t>(m.taken.size());
  m.delivery_count = static_cast<std::int16_t>(m.deliveries.size());
  m.failure_count = static_cast<std::int16_t>(m.failures.size());
  return m;
}

CarryRecord from_message(const mission_journal_t& m) {
  CarryRecord record;
  record.phase = static_cast<Phase>(m.phase);
  if (m.target_platform >= 0) record.target = SlotId{m.target_platform, m.target_slot};
  record.loaded = m.carrying != 0;
  record.homeward = m.homeward != 0;
  record.attempts = m.attempts;
  record.written_off = m.written_off;
  record.home_ned_m = vector_of(m.home_ned_m);
  record.hook_off_m = vector_of(m.hook_off_m);
  record.hook_lessons = m.hook_lessons;
  for (const mission_delivery_t& d : m.deliveries)
    record.delivered.push_back({{d.platform, d.slot}, d.off_m});
  for (const mission_slot_t& slot : m.taken) record.taken.push_back({slot.platform, slot.slot});
  for (const mission_failure_t& f : m.failures) record.failures[{f.platform, f.slot}] = f.times;
  return record;
}

void describe(const Carry& carry, std::int64_t utime, mission_t& mission) {
  mission.phase = static_cast<std::int8_t>(carry.phase());
  mission.phase_utime = carry.phase_utime();
  mission.action = static_cast<std::int8_t>(carry.action());
  mission.reason = carry.reason();
  mission.carrying = carry.record().loaded;
  mission.delivered = static_cast<std::int16_t>(carry.record().delivered.size());
  mission.attempts = static_cast<std::int16_t>(carry.record().attempts);
  mission.target_id = carry.target_track().value_or(-1);
  mission.candidates.clear();
  for (const SlotCandidate& c : carry.candidates())
    mission.candidates.push_back(to_message(c, mission.carrying != 0));
  mission.candidate_count = static_cast<std::int16_t>(mission.candidates.size());
  if (const auto target = carry.target(utime)) set_target(*target, mission);
  if (const auto setpoint = carry.setpoint()) {
    // what is wanted at the newest VEHICLE_STATE's time, taken back to this message's: an autopilot takes it
    // on from there
    const double passed_s = static_cast<double>(carry.utime() - utime) * 1e-6;
    mission.has_setpoint = true;
    put(setpoint->position_ned_m - passed_s * setpoint->velocity_ned_mps, mission.setpoint_ned_m);
    put(setpoint->velocity_ned_mps, mission.setpoint_velocity_ned_mps);
    mission.setpoint_heading_rad = setpoint->heading_rad;
  }
}

}  // namespace stevedore
