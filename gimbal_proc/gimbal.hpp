// Keeps the camera level: from the aircraft's attitude the angles that the pan-tilt must have when the
// command has taken effect, and from the pan-tilt's measured angles how level the camera is.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

#include "geometry/attitude.hpp"

namespace stevedore {

struct GimbalSettings {
  // A pan-tilt of second order with 15 Hz bandwidth and damping 0.7 follows a ramp 2 * 0.7 / (2 pi 15 Hz) =
  // 15 ms late; a command stands for 20 ms, on average 10 ms too long.
  double lag_s = 0.025;
  // Ten readings: white attitude noise of 0.5 deg shakes the camera by 0.1 deg, less than half a pixel.
  double smoothing_s = 0.2;
  double limit_deg = 30;
  double rate_degps = 120;
  // While the aircraft rolls at 60 deg/s, a healthy pan-tilt is 60 deg/s * (25 ms lag + 20 ms between
  // readings) = 2.7 deg behind.
  double stuck_deg = 3;
  // From one limit to the other takes 60 deg / (120 deg/s) = 0.5 s: what follows at all has arrived by then.
  double stuck_after_s = 0.5;
  double late_after_s = 0.2;  // ten readings missing
};

template <class Visitor>
void describe(GimbalSettings& s, Visitor& visit) {
  visit("lag_s", s.lag_s, 0.0, 0.5, "s",
        "time until a command has taken effect, led by the body's rates; raise: more lead, too much "
        "overshoots");
  visit("smoothing_s", s.smoothing_s, 0.0, 5.0, "s",
        "time over which attitude is averaged while the rates carry it; raise: a quieter camera, more of the "
        "rates' bias in it");
  visit("limit_deg", s.limit_deg, 0.0, 90.0, "deg", "largest angle of either joint that is asked for");
  visit("rate_degps", s.rate_degps, 1.0, 2000.0, "deg/s", "fastest change of either joint that is asked for");
  visit("stuck_deg", s.stuck_deg, 0.1, 90.0, "deg",
        "angle between command and measurement above which a joint counts as not following");
  visit("stuck_after_s", s.stuck_after_s, 0.02, 60.0, "s", "how long that must last to count as stuck");
  visit("late_after_s", s.late_after_s, 0.02, 60.0, "s",
        "silence of GIMBAL_STATE, on the clock of VEHICLE_STATE, that counts as late");
}

/// The aircraft's attitude at an instant.
struct AttitudeReading {
  double time_s = 0;
  Eigen::Quaterniond ned_from_body = Eigen::Quaterniond::Identity();
  Eigen::Vector3d rate_body_radps = Eigen::Vector3d::Zero();
};

/// What the pan-tilt says of itself.
struct PanTiltReading {
  double time_s = 0;
  GimbalAngles angles;
  bool at_limit = false;
};

enum class GimbalStatus { ok, at_limit, stuck, late };

struct CameraLevel {
  GimbalAngles angles;                  ///< measured, the newest
  std::optional<double> off_level_rad;  ///< optical axis against gravity; nothing: not known
  GimbalStatus status = GimbalStatus::late;
};

struct GimbalStep {
  GimbalAngles command;
  CameraLevel level;
};

/// The angles at which the mounted camera's optical axis lies along gravity, exact for any attitude within 90
/// degrees: body_from_camera's columns in geometry/attitude.cpp solved for the two angles.
GimbalAngles leveling_angles(const Eigen::Vector3d& gravity_body, const CameraMount& mount);

class Gimbal {
 public:
  Gimbal(const GimbalSettings& settings, const CameraMount& mount) : settings_(settings), mount_(mount) {}

  void measured(const PanTiltReading& reading);
  /// Called for every attitude, in order of time. A step back in time, or a gap, starts anew.
  GimbalStep follow(const AttitudeReading& attitude);

 private:
  void start_clock(double time_s);
  void smooth_gravity(const AttitudeReading& attitude, std::optional<double> since_s);
  GimbalAngles commanded(const GimbalAngles& wanted, double elapsed_s) const;
  CameraLevel judge(const AttitudeReading& attitude, const GimbalAngles& wanted);

  const GimbalSettings settings_;
  const CameraMount mount_;
  std::optional<double> time_s_;  ///< of the newest attitude
  double start_s_ = 0;            ///< of the first one
  Eigen::Vector3d gravity_body_ = Eigen::Vector3d::UnitZ();
  std::optional<PanTiltReading> reading_;
  std::optional<GimbalAngles> command_;
  std::optional<double> apart_since_s_;  ///< command and measurement
};

}  // namespace stevedore
