// The competition: two moving platforms, four buckets, an aircraft with hook, pan-tilt camera and sensors.
// Deterministic from its seed and from the commands it is given, step by step; it knows no clock.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>

#include "geometry/attitude.hpp"
#include "geometry/camera_model.hpp"
#include "sim_proc/world/lever_arms.hpp"
#include "sim_proc/world/readings.hpp"
#include "sim_proc/world/scene.hpp"
#include "sim_proc/world/truth.hpp"
#include "sim_proc/world/velocity_command.hpp"

namespace stevedore::world {

struct WorldSettings {
  std::uint64_t seed = 1;
  int sea_state = 2;   ///< 0..4
  int cargoes = 4;     ///< buckets on the first platform, 1..4
  bool easy = false;   ///< clean, calm, exact: for a first look; no figure of merit may use it
  CameraModel camera;  ///< as the pipeline is told it is
};

class World {
 public:
  /// Integration step: 5 ms, a tenth of the fastest time constant (gimbal, 15 Hz: 10.6 ms) rounded to divide
  /// every sensor's period.
  static constexpr double step_s = 0.005;

  explicit World(const WorldSettings& settings);
  ~World();
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  void command(const VelocityCommand& command);
  void command_gimbal(const GimbalAngles& angles);
  void command_hook(bool close);
  void land();  ///< the autopilot's own landing, straight down; take-off is any climb command

  /// One step of step_s. Returns what the sensors said in it.
  const Readings& step();

  [[nodiscard]] double time_s() const;
  /// What the camera sees now, eye included; frame: number of the picture, which seeds its noise.
  [[nodiscard]] Scene scene(std::int64_t frame) const;
  /// The time that the camera's driver would stamp on a picture taken now: wrong by a drawn constant of some
  /// milliseconds.
  [[nodiscard]] double stamp_s() const;
  [[nodiscard]] Truth truth() const;
  /// truth() but for the circles' outlines and visible shares, which cost a thousand rays.
  [[nodiscard]] Truth whereabouts() const;
  [[nodiscard]] const LeverArms& told_lever_arms() const;
  [[nodiscard]] double told_circle_radius_m() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace stevedore::world
