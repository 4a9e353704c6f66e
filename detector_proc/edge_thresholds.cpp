#include "detector_proc/edge_thresholds.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace stevedore {
namespace {

/// Every so many pixels either way: 1200 samples of a 320x240 frame, the median within 5 %.
constexpr int pitch_px = 8;

int median_magnitude(const cv::Mat& magnitude) {
  std::vector<ushort> sample;
  for (int v = pitch_px / 2; v < magnitude.rows; v += pitch_px) {
    const ushort* row = magnitude.ptr<ushort>(v);
    for (int u = pitch_px / 2; u < magnitude.cols; u += pitch_px) sample.push_back(row[u]);
  }
  if (sample.empty()) return 0;
  const auto middle = sample.begin() + static_cast<std::ptrdiff_t>(sample.size() / 2);
  std::nth_element(sample.begin(), middle, sample.end());
  return *middle;
}

}  // namespace

EdgeThresholds edge_thresholds(const GradientField& field) {
  // Below a step of this many grey levels an edge drowns in the rounding of levels and JPEG's blocks.
  constexpr double faintest_step = 4, faintest_start = 7;
  // White noise has a Rayleigh distribution: 1.8 medians are passed by 10 % of the pixels, so that an edge
  // is not lost at a bad one; 3 medians by 0.2 %, and hardly by neighbours that agree in direction.
  constexpr double follow_medians = 2.0, start_medians = 3.5;
  const double median = median_magnitude(field.magnitude);
  constexpr double unit = GradientField::step_response;
  return {static_cast<int>(std::lround(std::max(unit * faintest_step, follow_medians * median))),
          static_cast<int>(std::lround(std::max(unit * faintest_start, start_medians * median)))};
}

}  // namespace stevedore
