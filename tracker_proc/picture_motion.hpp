// How the whole picture moved since the frame before: what is left to go by when no mark is in view.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

namespace stevedore {

struct PictureShift {
  Eigen::Vector2d shift_px;
  double variance_px2;  ///< in each direction
};

class PictureMotion {
 public:
  /// Phase correlation (Kuglin and Hines 1975) of this frame, made small, with the one before. Nothing
  /// without an image, or where the two do not fit onto each other.
  std::optional<PictureShift> shift_to(const cv::Mat& image);

 private:
  cv::Mat before_;  ///< small, float grey levels
  cv::Mat window_;  ///< Hanning, of its size
};

}  // namespace stevedore
