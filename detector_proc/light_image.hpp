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

/// What of blue, green and red counts. An edge that colour alone shows is measured on what shows it.
struct LightWeights {
  float blue = 0.114F, green = 0.587F, red = 0.299F;  ///< luminance, Rec. 601

  bool operator==(const LightWeights&) const = default;
};

/// Weighted light of single pixels of a gray8 or bgr8 image; a gray8 image's light has no colour.
class LightImage {
 public:
  LightImage(const cv::Mat& image, const LightCurve& curve, const LightWeights& weights = {})
      : image_(image), curve_(curve), weights_(weights) {}

  [[nodiscard]] LightImage weighted(const LightWeights& weights) const { return {image_, curve_, weights}; }

  /// `count` pixels of a row from (u, v) on, or of a column.
  void read(int u, int v, bool along_row, int count, float* light) const {
    const int channels = image_.channels();
    const uchar* p = image_.ptr(v) + channels * static_cast<std::ptrdiff_t>(u);
    const auto step =
        along_row ? static_cast<std::ptrdiff_t>(channels) : static_cast<std::ptrdiff_t>(image_.step[0]);
    if (channels == 1) {
      for (int k = 0; k < count; ++k, p += step) light[k] = curve_[p[0]];
    } else {
      for (int k = 0; k < count; ++k, p += step)
        light[k] = weights_.blue * curve_[p[0]] + weights_.green * curve_[p[1]] + weights_.red * curve_[p[2]];
    }
  }

  [[nodiscard]] int width() const { return image_.cols; }
  [[nodiscard]] int height() const { return image_.rows; }

 private:
  const cv::Mat& image_;
  const LightCurve& curve_;
  LightWeights weights_;
};

}  // namespace stevedore
