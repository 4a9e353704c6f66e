// A frame as light: what sub-pixel edges are measured on.
#pragma once

#include <array>
#include <opencv2/core.hpp>

namespace stevedore {

/// Light by level of a camera's response, 0..1; geometry/camera_model.hpp makes it of a camera file.
using LightCurve = std::array<float, 256>;

/// Levels taken as light: no camera is known.
inline const LightCurve& linear_curve() {
  static const LightCurve curve = [] {
    LightCurve c{};
    for (std::size_t level = 0; level < c.size(); ++level) c[level] = static_cast<float>(level) / 255;
    return c;
  }();
  return curve;
}

/// Luminance of single pixels of a gray8 or bgr8 image (weights of Rec. 601, on light).
class LightImage {
 public:
  LightImage(const cv::Mat& image, const LightCurve& curve) : image_(image), curve_(curve) {}

  [[nodiscard]] float operator()(int u, int v) const {
    const uchar* row = image_.ptr(v);
    if (image_.channels() == 1) return curve_[row[u]];
    const uchar* p = row + 3 * static_cast<std::ptrdiff_t>(u);
    return 0.114F * curve_[p[0]] + 0.587F * curve_[p[1]] + 0.299F * curve_[p[2]];
  }

  [[nodiscard]] int width() const { return image_.cols; }
  [[nodiscard]] int height() const { return image_.rows; }

 private:
  const cv::Mat& image_;
  const LightCurve& curve_;
};

}  // namespace stevedore
