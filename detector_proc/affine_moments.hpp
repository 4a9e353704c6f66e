// Affine moment invariants of a contour: the paper's section 3.1.1.
#pragma once

#include <numbers>
#include <opencv2/core/types.hpp>
#include <optional>

namespace stevedore {

/// Eq. (1).
struct AffineMoments {
  double i1, i2, i3;
};

/// Eq. (3): 1 / (16 pi^2) for every ellipse, the smallest I1 there is; I2 = I3 = 0.
///
/// The paper integrates along the unit circle (mu00 = 2 pi, mu20 = pi). cv::moments integrates over the area
/// within (mu00 = pi, mu20 = pi / 4), and I1 is the same by luck of the radius: only the area's moments are
/// affine invariants, those of the curve grow with its radius squared.
inline constexpr double ellipse_i1 = 1 / (16 * std::numbers::pi * std::numbers::pi);

/// Nothing for a contour without area.
std::optional<AffineMoments> affine_moments(const cv::Moments& moments);

}  // namespace stevedore
