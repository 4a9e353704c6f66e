// A mark that is about where it is expected: its edges on profiles across the expected ellipse, straight from
// the pixels.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detector_proc/detector_settings.hpp"
#include "detector_proc/ellipse_search.hpp"

namespace stevedore {

// Ellipses are in pixels of the image (gray8 or bgr8) reduced by `factor`; of each profile the steepest step
// of a contrast counts, and the ellipse through the steps is fitted robustly. What has evidence enough is
// found, as in EllipseSearch.

/// The edges of either contrast, one each at most, within `reach_px` of an expected ellipse.
std::vector<EllipseEdge> look_across(const cv::Mat& image, const Ellipse& expected, int factor,
                                     double reach_px, const DetectorSettings& settings);

/// The edge of this contrast within two pixels.
std::optional<EllipseEdge> look_closely(const cv::Mat& image, const Ellipse& near, Bright bright, int factor,
                                        const DetectorSettings& settings);

/// No step of light well within an ellipse of the reduced image, most of which is in view.
bool is_plain_within(const cv::Mat& image, const Ellipse& ellipse, int factor);

}  // namespace stevedore
