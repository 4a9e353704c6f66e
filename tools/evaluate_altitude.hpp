// The camera's height over the deck by vision, by the laser, and in truth: the paper's Fig. 9.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/attitude.hpp"
#include "tools/evaluate_log.hpp"
#include "tools/evaluate_spread.hpp"

namespace stevedore {

/// One frame that shows circles. Heights are vertical, from the camera to the deck's plane below it.
struct AltitudeSample {
  std::int64_t utime = 0;
  double vision_m = 0;
  std::optional<double> laser_m;  ///< nothing: no reading, or the beam does not fall near a seen circle
  std::optional<double> truth_m;
  /// The laser reads short of TRUTH by the height of something that stands on the deck; without TRUTH short
  /// of vision, which may as well be vision reading high.
  bool on_thing = false;
};

struct AltitudeComparison {
  std::vector<AltitudeSample> samples;
  std::int64_t on_thing = 0;      ///< laser readings of something on the deck; in no spread of the laser
  std::int64_t on_thing_low = 0;  ///< of them, those below 2 m
  Spread vision_less_laser_m;
  Spread vision_less_laser_low_m;  ///< below 2 m, where the paper has less than 0.2 m
  Spread vision_less_truth_m;
  Spread laser_less_truth_m;
};

/// Where the laser sits.
struct LaserMount {
  Eigen::Vector3d from_camera_body_m = Eigen::Vector3d::Zero();  ///< along the body's axes
  CameraMount camera;
};

AltitudeComparison compare_altitudes(const FlightLog& flight, const LaserMount& mount);

}  // namespace stevedore
