// What the target looks like, and where CAMShift finds it: steps 1 to 4 of the paper's Algorithm 2.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "geometry/ellipse.hpp"

namespace stevedore {

/// One number a pixel, 0..251, from a grey or BGR frame: the hue where the colour is strong enough for the
/// hue to mean something, elsewhere the grey level. Grey frames, colour frames of grey scenes and white paint
/// on a coloured deck need no case of their own.
cv::Mat feature_image(const cv::Mat& image);

/// Step 1: the rectangle that touches the ellipse on four sides, as far as it lies in a frame of this size.
cv::Rect tangent_rectangle(const Ellipse& ellipse, const cv::Size& frame);

/// Step 2, eq. (6): h_{k+1} = w h_k + (1 - w) h~_k.
cv::Mat updated_histogram(const cv::Mat& histogram, const cv::Mat& of_this_frame, double weight);

/// Result of step 4. The window is what CAMShift returned, also when it is of no use.
struct WindowSearch {
  std::optional<Ellipse> window;
  std::string fault;  ///< why the window can't be used; empty: it can
};

class Appearance {
 public:
  explicit Appearance(double weight) : weight_(weight) {}

  /// Learns the area of the target's ellipse in this frame, step 2. Without an image or an ellipse in it:
  /// nothing.
  void learn(const cv::Mat& image, const Ellipse& target);

  /// Steps 1, 3 and 4 in the next frame, starting from where the target is expected. What is projected back
  /// is how much more of a bin the target has than its surroundings: all of h_k for white on black, but only
  /// the paint of a thin ring, most of whose area is the ground that lies around it as well.
  [[nodiscard]] WindowSearch find(const cv::Mat& image, const Ellipse& expected) const;

  void forget() { histogram_.release(); }

  /// The paper's h_k: shares of the bins, sum 1; empty before the first learn().
  [[nodiscard]] const cv::Mat& histogram() const { return histogram_; }

 private:
  double weight_;
  cv::Mat histogram_;
  cv::Mat surroundings_;  ///< the same of what is around the target
  int channels_ = 0;      ///< of the frames it was learned from
};

}  // namespace stevedore
