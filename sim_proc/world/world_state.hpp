// All that a world consists of. Private to world*.cpp.
#pragma once

#include <array>
#include <vector>

#include "sim_proc/world/aircraft.hpp"
#include "sim_proc/world/cargo.hpp"
#include "sim_proc/world/gimbal.hpp"
#include "sim_proc/world/oscillation.hpp"
#include "sim_proc/world/platform_motion.hpp"
#include "sim_proc/world/scenery.hpp"
#include "sim_proc/world/sensors.hpp"
#include "sim_proc/world/sling.hpp"
#include "sim_proc/world/told_and_true.hpp"
#include "sim_proc/world/wind.hpp"
#include "sim_proc/world/world.hpp"

namespace stevedore::world {

/// A cargo circle, on its deck.
struct Slot {
  int deck = 0;
  int number = 0;
  Eigen::Vector2d center_deck_m;
  double radius_m = 0;
};

struct World::State {
  explicit State(const WorldSettings& settings);

  // drawn once
  double share_of_errors;  ///< 1; 0: exact
  TrueSelf self;
  Scenery scenery;
  std::vector<Slot> slots;
  std::array<PlatformMotion, 2> platforms;
  Oscillation exposure;  ///< of the logarithm of the camera's gain
  std::uint64_t seed;

  // moving
  std::int64_t steps = 0;
  Floor floor;
  Wind wind;
  Aircraft aircraft;
  Gimbal gimbal;
  std::vector<Cargo> cargoes;
  Sling sling;

  // measuring
  VehicleSensor vehicle_sensor;
  GimbalEncoders encoders;
  Altimeter altimeter;
  LoadCell load_cell;
  std::array<PlatformSensor, 2> platform_sensors;
  AutopilotSensor autopilot_sensor;
  Readings readings;

  [[nodiscard]] double time_s() const { return static_cast<double>(steps) * step_s; }
  [[nodiscard]] bool due(double period_s, double phase_s = 0) const;
  [[nodiscard]] Eigen::Vector3d anchor_ned_m() const { return aircraft.body().to_ned(self.arms.hook_body_m); }
  [[nodiscard]] Rigid camera() const;
  [[nodiscard]] Scene surroundings() const;  ///< without eye, sling and aircraft

  void move();
  void move_cargoes();
  void measure();
  [[nodiscard]] AltimeterReading measure_height();
};

/// Decks at a time: the two platforms, and the pad.
Floor floor_at(double time_s, const std::array<PlatformMotion, 2>& platforms, const Scenery& scenery);

}  // namespace stevedore::world
