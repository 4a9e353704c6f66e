// What a set of views does not show yet, in words that a person can act on.
#pragma once

#include <string>
#include <vector>

#include "tools/calibrate_fit.hpp"

namespace stevedore {

/// A part of the picture, in which corners are counted; the nine of them cover it.
struct Region {
  std::string name;  ///< "in the lower left corner", "at the left edge", "in the middle"
  cv::Rect2d area_px;
};
std::vector<Region> regions(const cv::Size& image_px);

/// Empty when nothing is. `fit` may be missing: tilts are known from a fit only.
std::vector<std::string> missing_views(const std::vector<View>& views, const Fit* fit,
                                       const cv::Size& image_px);

}  // namespace stevedore
