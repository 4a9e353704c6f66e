// The competition: two moving platforms, four buckets, an aircraft with hook, pan-tilt camera and sensors.
// Deterministic from its seed and from the commands it is given, step by step; it knows no clock.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "geometry/attitude.hpp"
#include "geometry/camera_model.hpp"
#include "geometry/ellipse.hpp"
#include "sim_proc/world/scene.hpp"

namespace stevedore::world {

struct WorldSettings {
  std::uint64_t seed = 1;
  int sea_state = 2;   ///< 0..4
  int cargoes = 4;     ///< buckets on the first platform, 1..4
  bool easy = false;   ///< clean, calm, exact: for a first look; no figure of merit may use it
  CameraModel camera;  ///< as the pipeline is told it is
};

/// Where things sit on the aircraft, body frame (forward, right, down), as the pipeline is told; the world's
/// own differ by draws of 2 cm.
struct LeverArms {
  Eigen::Vector3d camera_body_m{0.80, 0, 0.25};
  Eigen::Vector3d hook_body_m{0, 0, 0.35};  ///< where the rope begins
  Eigen::Vector3d altimeter_body_m{-0.5, 0, 0.25};
  double rope_m = 0.8;
};

/// What the autopilot's velocity loop is told.
struct VelocityCommand {
  Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();
  double yaw_rate_radps = 0;
};

// Readings: what the sensors say. time_s is when they were taken, by the aircraft's own clock.

struct VehicleReading {
  double time_s = 0;
  Eigen::Vector3d position_ned_m;
  Eigen::Vector3d velocity_ned_mps;
  Eigen::Quaterniond ned_from_body;
  Eigen::Vector3d angular_rate_body_radps;
  double position_sigma_m = 0;  ///< as the sensor claims
  double velocity_sigma_mps = 0;
  double attitude_sigma_rad = 0;
};

struct GimbalReading {
  double time_s = 0;
  GimbalAngles angles;
  bool at_limit = false;
};

struct AltimeterReading {
  double time_s = 0;
  std::optional<double> range_m;  ///< along the beam; nothing: a drop-out
  double sigma_m = 0;
};

struct HookReading {
  double time_s = 0;
  double load_n = 0;
  bool closed = false;
};

struct PlatformReading {
  double time_s = 0;
  int platform = 0;
  Eigen::Vector3d position_ned_m;
  Eigen::Vector3d velocity_ned_mps;
  double heading_rad = 0;
  double position_sigma_m = 0;
};

struct AutopilotReading {
  double time_s = 0;
  bool landed = false;
  double battery_share = 1;
  double battery_v = 0;
};

/// Those that fell due in the last step.
struct Readings {
  std::optional<VehicleReading> vehicle;      // 50 Hz
  std::optional<GimbalReading> gimbal;        // 50 Hz
  std::optional<AltimeterReading> altimeter;  // 20 Hz
  std::optional<HookReading> hook;            // 10 Hz
  std::vector<PlatformReading> platforms;     // 2 Hz
  std::optional<AutopilotReading> autopilot;  // 2 Hz
};

struct CircleTruth {
  int platform = 0;  ///< 0, 1; 2: the take-off pad
  int slot = 0;
  bool occupied = false;  ///< a bucket stands in it
  Eigen::Vector3d center_ned_m;
  Eigen::Vector3d normal_ned;  ///< up from the deck
  double radius_m = 0;
  std::optional<Ellipse> outline;  ///< in the image as given; nothing: not in view
  double visible_share = 0;
};

struct CargoTruth {
  int index = 0;
  int platform = -1;             ///< that it is on; -1: on none
  int slot = -1;                 ///< whose circle its base's centre is in; -1: none
  Eigen::Vector3d center_ned_m;  ///< of the rim
  Eigen::Vector3d axis_ned;      ///< unit, from base to rim
  double radius_m = 0;           ///< of the rim
  bool on_hook = false;
  bool tipped = false;
};

struct Truth {
  double time_s = 0;
  std::vector<CircleTruth> circles;
  std::vector<CargoTruth> cargoes;
  Rigid aircraft;
  Rigid camera;
  Eigen::Vector3d hook_ned_m;
  double off_level_rad = 0;  ///< angle between optical axis and gravity
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
  [[nodiscard]] const LeverArms& told_lever_arms() const;
  [[nodiscard]] double told_circle_radius_m() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace stevedore::world
