// From fitted ellipses to marks: each physical mark once, rings as one, and what they are.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detector_proc/detector_settings.hpp"
#include "geometry/detection.hpp"

namespace stevedore {

/// Leaves one of several detections of the same edge: a whole one before a partial one, then the better
/// covered.
std::vector<Detection> merge_duplicates(std::vector<Detection> found, const DetectorSettings& settings);

/// Makes a painted ring's two edges one detection.
std::vector<Detection> merge_rings(std::vector<Detection> found, const cv::Mat& grey,
                                   const DetectorSettings& settings);

/// Fills in `label` and `occupied` from what lies in what.
void label_marks(std::vector<Detection>& found, const cv::Mat& edges, const DetectorSettings& settings);

}  // namespace stevedore
