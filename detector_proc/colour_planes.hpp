// Colour without lightness: paint as bright as its ground shows there.
#pragma once

#include <array>
#include <opencv2/core.hpp>

#include "detector_proc/light_image.hpp"

namespace stevedore {

/// The two opponent colours (Hering 1878), red against green, and blue against both, as grey images, 128 for
/// grey.
struct Opponents {
  static constexpr std::size_t count = 2;
  /// What of blue, green and red counts in each.
  static constexpr std::array<LightWeights, count> weights{LightWeights{0, -0.5F, 0.5F},
                                                           LightWeights{0.5F, -0.25F, -0.25F}};
};

/// One of them of a bgr8 image; memory is used again where the size is the same.
void compute_opponent(const cv::Mat& bgr, std::size_t which, cv::Mat& plane);

/// Both at half the size, each pixel the mean of four: where there is colour at all shows there at a quarter
/// of the cost.
void compute_halved_opponents(const cv::Mat& bgr, std::array<cv::Mat, Opponents::count>& planes);

}  // namespace stevedore
