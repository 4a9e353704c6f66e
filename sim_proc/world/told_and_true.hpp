// What the pipeline is told is slightly wrong, as on a real aircraft: the errors of a seed.
#pragma once

#include <cstdint>

#include "geometry/camera_model.hpp"
#include "sim_proc/world/lever_arms.hpp"

namespace stevedore::world {

/// Standard deviations; draws are cut at twice that: calibration finds what is worse.
struct TellingErrors {
  double focal_share = 0.003;
  double principal_point_px = 2;
  double mount_rad = 0.5 * 0.017453292519943295;  // 0.5 deg
  double lever_arm_m = 0.02;
  double circle_share = 0.005;
  double stamp_s = 0.005;
};

/// As it really is.
struct TrueSelf {
  CameraModel camera;
  LeverArms arms;
  double circle_scale = 1;  ///< painted radius over told radius
  double stamp_late_s = 0;  ///< stamped time less true time
};

TrueSelf draw_true_self(std::uint64_t seed, const TellingErrors& errors, const CameraModel& told_camera,
                        const LeverArms& told_arms);

}  // namespace stevedore::world
