#include "detector_proc/edge_thresholds.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace stevedore {
namespace {

/// Every so many pixels either way: 1200 samples of a 320x240 frame, the median within 5 %.
constexpr int pitch_px = 8;

int median_magnitude(const cv::Mat& magnitude) {
  // to 16 units, a third of a grey level
  constexpr int shift = 4;
  std::array<int, (65536 >> shift)> histogram{};
  int count = 0;
  for (int v = pitch_px / 2; v < magnitude.rows; v += pitch_px) {
    const ushort* row = magnitude.ptr<ushort>(v);
    for (int u = pitch_px / 2; u < magnitude.cols; u += pitch_px, ++count) ++histogram[row[u] >> shift];
  }
  int below = 0;
  for (std::size_t bin = 0; bin < histogram.size(); ++bin) {
    below += histogram[bin];
    if (2 * below > count) return static_cast<int>((bin << shift) + (1U << shift) / 2);
  }
  return 0;
}

}  // namespace

EdgeThresholds edge_thresholds(const GradientField& field) {
  // Below a step of this many grey levels an edge drowns in the rounding of levels and JPEG's blocks.
  constexpr double faintest_step = 4, faintest_start = 7;
  // White noise has a Rayleigh distribution: 2 medians are passed by 6 % of the pixels, so that an edge
  // is not lost at a bad one; 3.5 medians by 0.02 %, and hardly by neighbours that agree in direction.
  constexpr double follow_medians = 2.0, start_medians = 3.5;
  const double median = median_magnitude(field.magnitude);
  constexpr double unit = GradientField::step_response;
  return {static_cast<int>(std::lround(std::max(unit * faintest_step, follow_medians * median))),
          static_cast<int>(std::lround(std::max(unit * faintest_start, start_medians * median)))};
}

}  // namespace stevedore
