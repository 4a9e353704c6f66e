#include "sim_proc/sim_stage.hpp"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace stevedore {
namespace {

/// The pilot flies at 50 Hz, as any that hears VEHICLE_STATE.
constexpr std::int64_t steps_a_look = 4;

world::WorldSettings settings_of(const SimSettings& settings, const CameraModel& told) {
  world::WorldSettings world;
  world.seed = static_cast<std::uint64_t>(settings.seed);
  world.sea_state = settings.sea_state;
  world.cargoes = settings.cargoes;
  world.easy = settings.easy;
  world.camera = told;
  return world;
}

void put(const Eigen::Vector3d& from, double (&to)[3]) {
  Eigen::Map<Eigen::Vector3d>{to} = from;
}

void put(const Eigen::Quaterniond& from, double (&to)[4]) {
  to[0] = from.w(), to[1] = from.x(), to[2] = from.y(), to[3] = from.z();
}

template <std::size_t N>
void fill(double (&to)[N], double value) {
  for (double& element : to) element = value;
}

vehicle_state_t to_message(const world::VehicleReading& reading) {
  vehicle_state_t message{};
  put(reading.position_ned_m, message.position_ned_m);
  put(reading.velocity_ned_mps, message.velocity_ned_mps);
  put(reading.ned_from_body, message.ned_from_body);
  put(reading.angular_rate_body_radps, message.angular_rate_body_radps);
  fill(message.position_variance_m2, reading.position_sigma_m * reading.position_sigma_m);
  fill(message.velocity_variance_m2ps2, reading.velocity_sigma_mps * reading.velocity_sigma_mps);
  fill(message.attitude_variance_rad2, reading.attitude_sigma_rad * reading.attitude_sigma_rad);
  return message;
}

gimbal_state_t to_message(const world::GimbalReading& reading) {
  gimbal_state_t message{};
  message.roll_rad = reading.angles.roll_rad;
  message.pitch_rad = reading.angles.pitch_rad;
  message.off_level_rad = -1;  // a pan-tilt knows its own angles only
  message.status = reading.at_limit ? gimbal_state_t::STATUS_AT_LIMIT : gimbal_state_t::STATUS_OK;
  return message;
}

altimeter_t to_message(const world::AltimeterReading& reading) {
  altimeter_t message{};
  message.valid = reading.range_m.has_value();
  message.range_m = reading.range_m.value_or(0);
  message.variance_m2 = reading.sigma_m * reading.sigma_m;
  return message;
}

hook_state_t to_message(const world::HookReading& reading) {
  hook_state_t message{};
  message.load_n = reading.load_n;
  message.closed = reading.closed;
  return message;
}

platform_state_t to_message(const world::PlatformReading& reading) {
  platform_state_t message{};
  message.platform = static_cast<std::int16_t>(reading.platform);
  put(reading.position_ned_m, message.position_ned_m);
  put(reading.velocity_ned_mps, message.velocity_ned_mps);
  message.heading_rad = reading.heading_rad;
  fill(message.position_variance_m2, reading.position_sigma_m * reading.position_sigma_m);
  return message;
}

std::optional<SetPoint> set_point_of(const mission_t& message) {
  if (!message.has_setpoint) return std::nullopt;
  return SetPoint{message.header.utime, Eigen::Vector3d(message.setpoint_ned_m),
                  Eigen::Vector3d(message.setpoint_velocity_ned_mps), message.setpoint_heading_rad};
}

autopilot_status_t to_message(const world::AutopilotReading& reading) {
  autopilot_status_t message{};
  message.mode = autopilot_status_t::MODE_GUIDED;
  message.armed = true;
  message.landed = reading.landed;
  message.battery_share = reading.battery_share;
  message.battery_v = reading.battery_v;
  return message;
}

truth_circle_t to_message(const world::CircleTruth& circle) {
  truth_circle_t message{};
  message.platform = static_cast<std::int16_t>(circle.platform);
  message.slot = static_cast<std::int16_t>(circle.slot);
  message.occupied = circle.occupied;
  put(circle.center_ned_m, message.center_ned_m);
  put(circle.normal_ned, message.normal_ned);
  message.radius_m = circle.radius_m;
  message.in_view = circle.outline.has_value();
  if (circle.outline) {
    message.outline.u_px = circle.outline->u_px;
    message.outline.v_px = circle.outline->v_px;
    message.outline.a_px = circle.outline->a_px;
    message.outline.b_px = circle.outline->b_px;
    message.outline.alpha_rad = circle.outline->alpha_rad;
  }
  message.visible_share = circle.visible_share;
  return message;
}

truth_cargo_t to_message(const world::CargoTruth& cargo) {
  truth_cargo_t message{};
  message.index = static_cast<std::int16_t>(cargo.index);
  message.platform = static_cast<std::int16_t>(cargo.platform);
  message.slot = static_cast<std::int16_t>(cargo.slot);
  put(cargo.center_ned_m, message.center_ned_m);
  put(cargo.axis_ned, message.axis_ned);
  message.radius_m = cargo.radius_m;
  message.on_hook = cargo.on_hook;
  message.tipped = cargo.tipped;
  return message;
}

truth_t to_message(const world::Truth& truth) {
  truth_t message{};
  for (const auto& circle : truth.circles) message.circles.push_back(to_message(circle));
  for (const auto& cargo : truth.cargoes) message.cargoes.push_back(to_message(cargo));
  message.circle_count = static_cast<std::int16_t>(message.circles.size());
  message.cargo_count = static_cast<std::int16_t>(message.cargoes.size());
  put(truth.aircraft.position_ned_m, message.position_ned_m);
  put(truth.aircraft.velocity_ned_mps, message.velocity_ned_mps);
  put(truth.aircraft.ned_from_local, message.ned_from_body);
  put(truth.camera.position_ned_m, message.camera_ned_m);
  put(truth.camera.ned_from_local, message.ned_from_camera);
  put(truth.hook_ned_m, message.hook_ned_m);
  return message;
}

}  // namespace

SimStage::SimStage(const SimSettings& settings, const CameraModel& told, std::string ring_name, Bus& bus)
    : settings_(settings),
      bus_(bus),
      world_(settings_of(settings, told)),
      renderer_(settings.render_threads, told),
      output_(settings.frames, std::move(ring_name)) {
  renderer_.warm_up(world_.scene(0));
  bus_.subscribe<gimbal_command_t>(channels::gimbal_command, [this](const gimbal_command_t& m) {
    world_.command_gimbal({m.roll_rad, m.pitch_rad});
  });
  if (settings_.pilot != "mission") return;
  bus_.subscribe<mission_t>(channels::mission, [this](const mission_t& m) {
    guided_.hear(set_point_of(m));
    if (m.action == mission_t::ACTION_GRAB) world_.command_hook(true);
    if (m.action == mission_t::ACTION_RELEASE) world_.command_hook(false);
    const bool lands = m.action == mission_t::ACTION_LAND;
    if (lands && !lands_) world_.land();
    lands_ = lands;
  });
}

Condition SimStage::work(std::int64_t now_utime) {
  if (!start_utime_) start_utime_ = now_utime;
  while (!has_ended() && utime_of(world_.time_s() + world::World::step_s) <= now_utime) step();
  if (const auto picture = renderer_.take()) send(*picture);
  return condition();
}

Condition SimStage::finish_drawing() {
  if (renderer_.is_busy()) renderer_.wait();
  if (const auto picture = renderer_.take()) send(*picture);
  return condition();
}

bool SimStage::has_ended() const {
  return settings_.seconds > 0 && world_.time_s() >= settings_.seconds;
}

void SimStage::step() {
  const world::Readings& readings = world_.step();
  publish(readings);
  if (readings.vehicle) guided_.hear(*readings.vehicle);
  if (steps_++ % steps_a_look == 0) fly();
  // a tick falls on the step that reaches it
  while (static_cast<double>(ticks_) <= world_.time_s() * settings_.rate_hz) expose();
}

void SimStage::fly() {
  if (settings_.pilot == "scripted") world_.command(scripted_.fly(world_.whereabouts()));
  if (settings_.pilot == "mission" && !lands_) world_.command(guided_.fly(utime_of(world_.time_s())));
}

void SimStage::expose() {
  const std::int64_t frame_seq = ticks_++;
  if (const auto picture = renderer_.take()) send(*picture);  // drawn while the world caught up
  if (renderer_.is_busy()) {
    ++drops_;
    return;
  }
  renderer_.start({frame_seq, utime_of(world_.stamp_s()), world_.scene(frame_seq), world_.truth()});
}

void SimStage::send(const Picture& picture) {
  frame_t frame{};
  frame.header.utime = picture.utime;
  frame.header.frame_seq = picture.frame_seq;
  refusal_ = output_.put(picture.pixels, frame, bus_.receive_buffer_bytes());
  if (refusal_) return;
  if (settings_.truth) {
    truth_t truth = to_message(picture.truth);
    truth.header.utime = picture.utime;
    truth.header.frame_seq = picture.frame_seq;
    bus_.publish(channels::truth, truth);
  }
  bus_.publish(channels::frame, frame);
}

void SimStage::publish(const world::Readings& readings) {
  const auto tell = [this](const auto& channel, const auto& reading) {
    auto message = to_message(reading);
    message.header.utime = utime_of(reading.time_s);
    message.header.frame_seq = -1;
    bus_.publish(channel, std::move(message));
  };
  if (readings.gimbal) tell(channels::gimbal_state, *readings.gimbal);  // the attitude's reader has it then
  if (readings.vehicle) tell(channels::vehicle_state, *readings.vehicle);
  if (readings.altimeter) tell(channels::altimeter, *readings.altimeter);
  if (readings.hook) tell(channels::hook_state, *readings.hook);
  for (const auto& platform : readings.platforms) tell(channels::platform_state, platform);
  if (readings.autopilot) tell(channels::autopilot_status, *readings.autopilot);
}

Condition SimStage::condition() const {
  const bool finished = has_ended() && !renderer_.is_busy();
  if (refusal_ && !finished) return {health_t::STATE_FAILED, *refusal_};
  std::string drops;
  if (drops_ > 0)
    drops = fmt::format("{} of {} frames dropped: the one before was not drawn in time", drops_, ticks_);
  return {finished ? health_t::STATE_FINISHED : health_t::STATE_OK, drops};
}

std::int64_t SimStage::utime_of(double time_s) const {
  return *start_utime_ + std::llround(time_s * 1e6);
}

}  // namespace stevedore
