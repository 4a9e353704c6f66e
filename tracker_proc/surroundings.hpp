// What the picture around the target looks like: tells the target from a mark that looks the same elsewhere.
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "geometry/ellipse.hpp"

namespace stevedore {

/// The grey levels within some radii of an ellipse, on a grid that grows with it.
class Surroundings {
 public:
  /// Without an image, or with too little of the surroundings in it: what is known stays.
  void learn(const cv::Mat& image, const Ellipse& target);
  void forget() { cells_.release(); }

  /// Normalised cross-correlation, -1..1, of what was learned with what lies around this ellipse. The mark
  /// itself is left out: siblings look alike. Nothing where either is even or hardly in the image.
  [[nodiscard]] std::optional<double> correlation(const cv::Mat& image, const Ellipse& around) const;

 private:
  cv::Mat cells_;  ///< float grey levels; NaN: outside the image, or of the mark
};

}  // namespace stevedore
