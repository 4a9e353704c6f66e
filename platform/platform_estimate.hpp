// What comes out: a platform at one moment.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "platform/slot_belief.hpp"

namespace stevedore {

/// Of (centre, velocity).
using MotionCovariance = Eigen::Matrix<double, 6, 6>;

struct SlotEstimate {
  Eigen::Vector3d center_ned_m;
  Eigen::Matrix3d covariance_m2;
  SlotState state = SlotState::unknown;
  double confidence = 0;
  std::int64_t seen_utime = -1;
};

struct DeckPrediction {
  double ahead_s = 0;
  Eigen::Vector3d center_ned_m;
  Eigen::Vector3d velocity_ned_mps;
  Eigen::Vector3d normal_ned;  ///< up
  MotionCovariance covariance;
  bool safe_to_lower = false;  ///< from the prediction before (or now) until then
};

/// Positions are in the autopilot's own NED of that moment: subtract VEHICLE_STATE's position and the error
/// that both share, metres, is gone. The covariances are of such differences.
struct PlatformEstimate {
  std::int64_t utime = 0;
  int platform = 0;
  Eigen::Vector3d center_ned_m;
  Eigen::Vector3d velocity_ned_mps;
  MotionCovariance covariance;
  double heading_rad = 0;
  double heading_variance_rad2 = 0;
  double turn_rate_radps = 0;
  double heave_m = 0;  ///< up from the mean height
  double roll_rad = 0;
  double pitch_rad = 0;
  bool identity_certain = false;
  std::int64_t measured_utime = 0;
  std::int64_t seen_utime = -1;     ///< newest frame that showed circles of it
  std::vector<SlotEstimate> slots;  ///< empty until the layout is known
  std::vector<DeckPrediction> predictions;
};

}  // namespace stevedore
