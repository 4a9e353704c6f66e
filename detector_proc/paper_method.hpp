// Algorithm 1 of the paper: contours, AMI gate, ellipse fit, convex hull for the rest, algebraic error.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detector_proc/detector_settings.hpp"
#include "geometry/detection.hpp"

namespace stevedore {

std::vector<Detection> detect_by_paper(const cv::Mat& image, const DetectorSettings& settings);

}  // namespace stevedore
