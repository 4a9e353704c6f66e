#include "sim_proc/world/world.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>

#include "sim_proc/world/ray.hpp"
#include "sim_proc/world/world_state.hpp"

namespace stevedore::world {
namespace {

using std::numbers::pi;

constexpr double pad_down_m = -0.02;      ///< its upper side: clear of the ground's own plane
constexpr double furthest_off_m = 0.15;   ///< of a bucket from its circle's middle, at the start
constexpr double exposure_rms = 0.12;     ///< of the logarithm of gain: a step of a sixth of a stop
constexpr double handle_sway_rad = 0.15;  ///< a handle that was set up leans by up to so much: 2 cm

Scenery scenery_of(const WorldSettings& settings, double circle_scale) {
  Scenery scenery = draw_scenery({settings.seed, settings.easy});
  for (Deck& deck : scenery.decks) {
    for (Mark& mark : deck.marks) {
      if (mark.slot < 0) continue;
      mark.radius_m *= circle_scale;
      mark.width_m *= circle_scale;
    }
  }
  return scenery;
}

std::vector<Slot> slots_of(const Scenery& scenery) {
  std::vector<Slot> slots;
  for (std::size_t deck = 0; deck < scenery.decks.size(); ++deck) {
    for (const Mark& mark : scenery.decks[deck].marks) {
      if (mark.slot >= 0)
        slots.push_back({static_cast<int>(deck), mark.slot, mark.center_deck_m, mark.radius_m});
    }
  }
  return slots;
}

/// In circles of the first platform, a little off their middles, handles up so that a hook can take them.
std::vector<Cargo> cargoes_of(const WorldSettings& settings, const Scenery& scenery,
                              const std::vector<Slot>& slots, const Floor& floor) {
  Dice dice(settings.seed, "cargoes");
  std::vector<Slot> free;
  for (const Slot& slot : slots) {
    if (slot.deck == 0) free.push_back(slot);
  }
  std::vector<Cargo> cargoes;
  for (int i = 0; i < settings.cargoes; ++i) {
    const auto pick = static_cast<std::size_t>(dice.whole(0, static_cast<int>(free.size()) - 1));
    const double off_m = furthest_off_m * std::sqrt(dice.uniform(0, 1)),
                 bearing_rad = dice.uniform(0, 2 * pi);
    const Eigen::Vector2d off = off_m * Eigen::Vector2d(std::cos(bearing_rad), std::sin(bearing_rad));
    Bucket look = scenery.buckets.at(static_cast<std::size_t>(i));
    look.handle_rad = dice.uniform(-handle_sway_rad, handle_sway_rad);
    cargoes.emplace_back(look, 0, free[pick].center_deck_m + off, dice.uniform(0, 2 * pi), floor);
    free.erase(free.begin() + static_cast<std::ptrdiff_t>(pick));
  }
  return cargoes;
}

Aircraft aircraft_of(std::uint64_t seed, const Floor& floor) {
  Dice dice(seed, "aircraft");
  return Aircraft({0, 0}, dice.uniform(0, 2 * pi), footing_below(floor, {0, 0, pad_down_m}), World::step_s);
}

TellingErrors times(double share) {
  const TellingErrors full;
  return {share * full.focal_share, share * full.principal_point_px, share * full.mount_rad,
          share * full.lever_arm_m, share * full.circle_share,       share * full.stamp_s};
}

const WorldSettings& checked(const WorldSettings& settings) {
  if (settings.cargoes < 1 || settings.cargoes > 4)
    throw std::invalid_argument("cargoes: " + std::to_string(settings.cargoes) + " is not one of 1 to 4");
  return settings;
}

int sea_state_of(const WorldSettings& settings) {
  return settings.easy ? 0 : settings.sea_state;
}

WindSettings wind_of(const WorldSettings& settings) {
  return settings.easy ? WindSettings{0, 0} : WindSettings{};
}

Oscillation exposure_of(const WorldSettings& settings) {
  Dice dice(settings.seed, "exposure");
  return {settings.easy ? 0 : exposure_rms, 10, 60, dice};
}

}  // namespace

Floor floor_at(double time_s, const std::array<PlatformMotion, 2>& platforms, const Scenery& scenery) {
  Floor floor;
  floor.water = scenery.surroundings.kind == Surroundings::Kind::water;
  floor.decks.reserve(3);
  for (std::size_t i = 0; i < 2; ++i) {
    floor.decks.push_back({platforms[i].at(time_s), scenery.decks[i].half_size_m});
  }
  Rigid pad;
  pad.position_ned_m.z() = pad_down_m;
  floor.decks.push_back({pad, scenery.decks[2].half_size_m});
  return floor;
}

World::State::State(const WorldSettings& settings)
    : share_of_errors(checked(settings).easy ? 0 : 1),
      self(draw_true_self(settings.seed, times(share_of_errors), settings.camera, LeverArms{})),
      scenery(scenery_of(settings, self.circle_scale)),
      slots(slots_of(scenery)),
      platforms{PlatformMotion(settings.seed, 0, sea_state_of(settings)),
                PlatformMotion(settings.seed, 1, sea_state_of(settings))},
      exposure(exposure_of(settings)),
      seed(settings.seed),
      floor(floor_at(0, platforms, scenery)),
      wind(settings.seed, wind_of(settings), step_s),
      aircraft(aircraft_of(settings.seed, floor)),
      gimbal(step_s),
      cargoes(cargoes_of(settings, scenery, slots, floor)),
      sling(settings.seed, anchor_ned_m(), self.arms.rope_m),
      vehicle_sensor(settings.seed, share_of_errors),
      encoders(settings.seed, share_of_errors),
      altimeter(settings.seed, share_of_errors),
      load_cell(settings.seed, share_of_errors),
      platform_sensors{PlatformSensor(settings.seed, 0, share_of_errors),
                       PlatformSensor(settings.seed, 1, share_of_errors)},
      autopilot_sensor(settings.seed, share_of_errors) {}

bool World::State::due(double period_s, double phase_s) const {
  const auto period = std::llround(period_s / step_s), phase = std::llround(phase_s / step_s);
  return steps % period == phase;
}

/// The pan-tilt turns about the camera's centre.
Rigid World::State::camera() const {
  const Rigid& body = aircraft.body();
  const GimbalAngles& angles = gimbal.angles();
  const Eigen::Quaterniond roll(Eigen::AngleAxisd(angles.roll_rad, Eigen::Vector3d::UnitX()));
  Rigid camera;
  camera.position_ned_m = body.to_ned(self.arms.camera_body_m);
  camera.velocity_ned_mps = body.velocity_at(camera.position_ned_m);
  camera.ned_from_local =
      body.ned_from_local * Eigen::Quaterniond(body_from_camera(angles, self.camera.mount));
  const Eigen::Vector3d turn_body_radps = gimbal.rates_radps().roll_rad * Eigen::Vector3d::UnitX() +
                                          roll * (gimbal.rates_radps().pitch_rad * Eigen::Vector3d::UnitY());
  camera.angular_velocity_ned_radps = body.angular_velocity_ned_radps + body.ned_from_local * turn_body_radps;
  return camera;
}

void World::State::move() {
  ++steps;
  floor = floor_at(time_s(), platforms, scenery);
  wind.step();
  aircraft.step({wind.mean_ned_mps(), wind.gust_ned_mps()}, floor);
  gimbal.step();
  move_cargoes();
}

void World::State::move_cargoes() {
  std::array<Cargo::State, 4> before{};
  for (std::size_t i = 0; i < cargoes.size(); ++i) before[i] = cargoes[i].state();
  sling.step(anchor_ned_m(), wind.mean_ned_mps() + wind.gust_ned_mps(), floor, cargoes, step_s);
  for (std::size_t i = 0; i < cargoes.size(); ++i) {
    cargoes[i].step(floor, step_s);
    const bool has_come_to_stand =
        cargoes[i].state() == Cargo::State::standing && before[i] != Cargo::State::standing;
    if (has_come_to_stand) keep_apart(cargoes, i, floor);
  }
}

AltimeterReading World::State::measure_height() {
  const Rigid& body = aircraft.body();
  const auto hit = first_hit(surroundings(), body.to_ned(self.arms.altimeter_body_m),
                             body.ned_from_local * Eigen::Vector3d::UnitZ());
  if (!hit) return altimeter.read(time_s(), std::nullopt, false);
  return altimeter.read(time_s(), hit->range_m, floor.water && hit->what == Hit::What::surroundings);
}

void World::State::measure() {
  using Due = SensorPeriods;
  const double now_s = time_s();
  readings = {};
  if (due(Due::vehicle_s)) readings.vehicle = vehicle_sensor.read(now_s, aircraft.body());
  if (due(Due::gimbal_s)) readings.gimbal = encoders.read(now_s, gimbal.angles(), gimbal.at_limit());
  if (due(Due::altimeter_s)) readings.altimeter = measure_height();
  if (due(Due::hook_s)) readings.hook = load_cell.read(now_s, sling.load_n(), sling.closed());
  for (std::size_t i = 0; i < 2; ++i) {
    if (!due(Due::platform_s, static_cast<double>(i) * Due::platform_s / 2)) continue;  // in turn
    if (auto reading = platform_sensors[i].read(now_s, floor.decks[i].rigid))
      readings.platforms.push_back(*reading);
  }
  if (due(Due::autopilot_s))
    readings.autopilot = autopilot_sensor.read(now_s, aircraft.landed(), aircraft.battery_share());
}

World::World(const WorldSettings& settings) : state_(std::make_unique<State>(settings)) {}
World::~World() = default;

void World::command(const VelocityCommand& command) {
  state_->aircraft.command(command);
}

void World::command_gimbal(const GimbalAngles& angles) {
  state_->gimbal.command(angles);
}

void World::command_hook(bool close) {
  state_->sling.command(close);
}

void World::land() {
  state_->aircraft.land();
}

const Readings& World::step() {
  state_->move();
  state_->measure();
  return state_->readings;
}

double World::time_s() const {
  return state_->time_s();
}

double World::stamp_s() const {
  return state_->time_s() + state_->self.stamp_late_s;
}

const LeverArms& World::told_lever_arms() const {
  static const LeverArms told;
  return told;
}

double World::told_circle_radius_m() const {
  return state_->scenery.circle_radius_m;
}

}  // namespace stevedore::world
