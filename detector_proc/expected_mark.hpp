// A mark that is about where it is expected.
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "detector_proc/detector_settings.hpp"
#include "detector_proc/optics.hpp"
#include "geometry/detection.hpp"

namespace stevedore {

/// Between what is found and what was expected, in semi-minor axes of place plus logarithms of size. Half a
/// semi-axis of unforeseen motion and a fifth of size; a ring's inner edge or a rim within is further off.
constexpr double most_mismatch = 0.6;
double mismatch(const Ellipse& found, const Ellipse& expected);

/// By how much an image may be reduced for the mark to be found with the fewest pixels.
int reduction_for(const Detection& expected);

/// The mark by profiles across its expected edges alone, in light. Nothing where these do not settle it,
/// which does not mean that there is none: more of the neighbourhood has to be looked at.
std::optional<Detection> find_expected(const cv::Mat& image, const Detection& expected,
                                       const DetectorSettings& settings, const Optics& optics);

}  // namespace stevedore
