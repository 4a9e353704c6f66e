// Step 1 of Algorithm 1: contours from edges and from colours.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detector_proc/detector_settings.hpp"

namespace stevedore {

/// What a contour runs through. findContours runs through pixel centres: of an edge of Canny's, on its outer
/// or its inner side; of a region of paint, through its outermost pixels, or those that surround a hole in
/// it.
enum class Trace { edge_outside, edge_inside, region, hole };

struct Contour {
  std::vector<cv::Point> points;
  Trace trace = Trace::edge_outside;
};

/// Grey levels of a gray8 or bgr8 image, blurred 5x5.
cv::Mat blurred_grey(const cv::Mat& image);

cv::Mat edge_map(const cv::Mat& blurred, const DetectorSettings& settings);

/// Contours of at least min_contour_points points.
std::vector<Contour> edge_contours(const cv::Mat& edges, const DetectorSettings& settings);
std::vector<Contour> color_contours(const cv::Mat& image, const DetectorSettings& settings);

}  // namespace stevedore
