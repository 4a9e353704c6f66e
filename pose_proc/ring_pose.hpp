// A ring's two edges as one measurement.
#pragma once

#include <optional>

#include "geometry/camera.hpp"
#include "geometry/detection.hpp"
#include "pose_proc/circle_pose.hpp"

namespace stevedore {

/// Both solutions fitted again with the inner edge, and the log-odds of the first that the ring gives. The
/// images of two circles with one centre have different centres, apart in the direction of the tilt: that
/// tells which way it leans. Nothing where inner and outer edge are not of one ring within their noise.
struct RingPose {
  std::array<CircleSolution, 2> solutions;
  double log_odds = 0;
};

std::optional<RingPose> ring_pose(const EllipseFit& outer, const EllipseFit& inner, const Pinhole& camera,
                                  double radius_m, const std::array<CircleSolution, 2>& start);

}  // namespace stevedore
