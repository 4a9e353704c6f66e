#include "gimbal_proc/gimbal_stage.hpp"

#include <fmt/format.h>

#include <numbers>

namespace stevedore {
namespace {

int8_t to_message(GimbalStatus status) {
  switch (status) {
    case GimbalStatus::ok:
      return gimbal_state_t::STATUS_OK;
    case GimbalStatus::at_limit:
      return gimbal_state_t::STATUS_AT_LIMIT;
    case GimbalStatus::stuck:
      return gimbal_state_t::STATUS_STUCK;
    case GimbalStatus::late:
      return gimbal_state_t::STATUS_LATE;
  }
  return gimbal_state_t::STATUS_LATE;
}

AttitudeReading attitude_of(const vehicle_state_t& vehicle) {
  const double* q = vehicle.ned_from_body;
  AttitudeReading attitude;
  attitude.time_s = static_cast<double>(vehicle.header.utime) * 1e-6;
  attitude.ned_from_body = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
  attitude.rate_body_radps = Eigen::Map<const Eigen::Vector3d>(vehicle.angular_rate_body_radps);
  return attitude;
}

PanTiltReading reading_of(const gimbal_state_t& state) {
  PanTiltReading reading;
  reading.time_s = static_cast<double>(state.header.utime) * 1e-6;
  reading.angles = {state.roll_rad, state.pitch_rad};
  reading.at_limit = state.status == gimbal_state_t::STATUS_AT_LIMIT;
  return reading;
}

Condition condition_of(const GimbalStep& step) {
  constexpr double deg = std::numbers::pi / 180;
  if (step.level.status == GimbalStatus::late)
    return {health_t::STATE_DEGRADED,
            fmt::format("no {} comes: nobody knows how the camera stands", channels::gimbal_state.name)};
  if (step.level.status != GimbalStatus::stuck) return {};
  const GimbalAngles &wanted = step.command, &is = step.level.angles;
  return {health_t::STATE_DEGRADED,
          fmt::format("the pan-tilt does not follow: roll {:.1f} of {:.1f} deg, pitch {:.1f} of {:.1f} deg",
                      is.roll_rad / deg, wanted.roll_rad / deg, is.pitch_rad / deg, wanted.pitch_rad / deg)};
}

}  // namespace

GimbalStage::GimbalStage(const GimbalSettings& settings, const CameraMount& mount, Bus& bus)
    : bus_(bus), gimbal_(settings, mount) {
  bus_.subscribe<vehicle_state_t>(channels::vehicle_state,
                                  [this](const vehicle_state_t& m) { on_vehicle(m); });
  bus_.subscribe<gimbal_state_t>(channels::gimbal_state,
                                 [this](const gimbal_state_t& m) { gimbal_.measured(reading_of(m)); });
}

void GimbalStage::on_vehicle(const vehicle_state_t& vehicle) {
  const GimbalStep step = gimbal_.follow(attitude_of(vehicle));
  publish(vehicle.header, step);
  condition_ = condition_of(step);
}

void GimbalStage::publish(const header_t& cause, const GimbalStep& step) {
  gimbal_command_t command{};
  command.header.utime = cause.utime;
  command.header.frame_seq = -1;
  command.roll_rad = step.command.roll_rad;
  command.pitch_rad = step.command.pitch_rad;
  bus_.publish(channels::gimbal_command, command);

  gimbal_state_t level{};
  level.header.utime = cause.utime;
  level.header.frame_seq = -1;
  level.roll_rad = step.level.angles.roll_rad;
  level.pitch_rad = step.level.angles.pitch_rad;
  level.off_level_rad = step.level.off_level_rad.value_or(-1);
  level.status = to_message(step.level.status);
  bus_.publish(channels::gimbal_level, level);
}

}  // namespace stevedore
