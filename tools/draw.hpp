// Ellipses and captions drawn on a frame, in the colours of the paper's Fig. 7.
#pragma once

#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "geometry/ellipse.hpp"

namespace stevedore {

/// BGR.
struct Colour {
  double blue, green, red;
};
inline constexpr Colour cyan{255, 255, 0};    ///< every ellipse
inline constexpr Colour green{0, 255, 0};     ///< the target
inline constexpr Colour yellow{0, 255, 255};  ///< CAMShift's window

/// A colour copy of a frame to draw on. Narrow frames are enlarged, so that lines are fine against what they
/// mark; everything is given in pixels of the frame itself.
class Canvas {
 public:
  /// gray8 or bgr8.
  explicit Canvas(const cv::Mat& frame);

  void ellipse(const Ellipse& ellipse, const Colour& colour, int thickness = 1);
  void dashed_ellipse(const Ellipse& ellipse, const Colour& colour, int thickness = 1);
  /// Lines of small text in a bar below the frame, where they hide nothing; what is too long is cut. Once,
  /// at the end.
  void caption(const std::vector<std::string>& lines);

  [[nodiscard]] const cv::Mat& image() const { return image_; }

 private:
  /// Corners of a polygon that can't be told from the ellipse, in 1 / 2^subpixel_bits of a pixel of the
  /// image.
  [[nodiscard]] std::vector<cv::Point> outline(const Ellipse& ellipse) const;

  int scale_;
  cv::Mat image_;
};

}  // namespace stevedore
