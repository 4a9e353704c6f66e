// Front end: grey levels and their gradient, in one pass over the frame.
#pragma once

#include <opencv2/core.hpp>

namespace stevedore {

/// Gradient of a frame under a separable 5x5 derivative, (1 4 6 4 1) across and (-1 -2 0 2 1) along
/// (Scharr, Jaehne, Koerkel 1999, section on separable derivatives): the derivative of a binomial blur of
/// about one pixel. A sharp step of n grey levels reads step_response * n. Rows and columns beyond the border
/// repeat the outermost ones.
struct GradientField {
  cv::Mat grey;       ///< CV_8UC1, of the last frame in colour
  cv::Mat gradient;   ///< CV_16SC2: (d/du, d/dv), towards the bright side
  cv::Mat magnitude;  ///< CV_16UC1: octagonal, 3 % below to 7 % above Euclid's; 0 on the outermost pixels

  static constexpr int step_response = 48;
};

/// Fills in the field of a gray8 or bgr8 image; memory is used again where the size is the same.
void compute_gradient(const cv::Mat& image, GradientField& field);

}  // namespace stevedore
