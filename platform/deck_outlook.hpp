// Where a deck will be over the next seconds, and when a cargo can be let down on it.
#pragma once

#include <vector>

#include "platform/deck_motion.hpp"
#include "platform/platform_estimate.hpp"

namespace stevedore {

/// Centre and velocity with covariance; position in odometry.
struct DeckCourse {
  Eigen::Vector3d center_odometry_m;
  Eigen::Vector3d velocity_ned_mps;
  MotionCovariance covariance;
};
DeckCourse course_of(const DeckState& state);

/// Vertical speed and tilt are both below their limits with the probability asked for.
bool is_safe(const DeckState& state, const PlatformSettings& settings);

/// At 0.5, 1, 1.5 and 2 s, positions in odometry. A prediction is safe when the deck is, then and at
/// the one before (the first: now).
std::vector<DeckPrediction> outlook(const DeckState& now, const DeckMotion& motion,
                                    const Disturbance& disturbance, const PlatformSettings& settings);

}  // namespace stevedore
