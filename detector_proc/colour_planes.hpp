// Colour without lightness, at half the frame's size: paint as bright as its ground shows there.
#pragma once

#include <array>
#include <opencv2/core.hpp>

#include "detector_proc/light_image.hpp"

namespace stevedore {

/// The two opponent colours (Hering 1878) as grey images, 128 for grey: red against green, and blue against
/// both. Half the size: cameras, JPEG and video have no more of colour (4:2:0), and the mean of four pixels
/// makes up for the noise of a difference.
struct ColourPlanes {
  static constexpr int reduction = 2;
  /// The planes' weights of blue, green and red.
  static constexpr std::array<LightWeights, 2> weights{LightWeights{0, -0.5F, 0.5F},
                                                       LightWeights{0.5F, -0.25F, -0.25F}};
  std::array<cv::Mat, 2> planes;  ///< CV_8UC1

  /// Fills them in from a bgr8 image; memory is used again where the size is the same.
  void compute(const cv::Mat& bgr);

  /// The same without the reduction: for a neighbourhood that is looked at closely.
  void compute_full_size(const cv::Mat& bgr);
};

}  // namespace stevedore
