// What all marks do together: the camera moves, and they stay where they are to each other.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "tracker_proc/association.hpp"

namespace stevedore {

/// How all marks are shifted in this frame, beyond where each was expected.
struct CommonShift {
  Eigen::Vector2d shift_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d faster_by_pxps = Eigen::Vector2d::Zero();
  std::size_t marks = 0;        ///< that agree
  std::vector<bool> ambiguous;  ///< found ellipses that could be one mark as well as another
};

/// Its mean is always folded into the marks at once; what stays here is how well it is known: variance of the
/// shift and of its velocity, the same in both image directions.
class CommonMotion {
 public:
  /// The camera's velocity in the image is not known at first: standard deviation in px/s.
  explicit CommonMotion(double velocity_sigma_pxps);

  /// velocity_walk_pxps: standard deviation of the velocity after one second, grown from zero.
  void predict(double dt_s, double velocity_walk_pxps);

  /// The shift that lets the constellation of the expected marks explain the found ellipses best: each pair
  /// that could be one mark proposes one, and the likeliest as a whole is refined with all its pairs. Besides
  /// what the motion so far leads to and a jerk, a jump to anywhere in the frame is thought possible, so
  /// unlikely that it takes two marks which agree. Without any pair: no shift, and doubt remains; so too
  /// where two shifts explain the frame about as well and give an ellipse to different marks.
  CommonShift find(const std::vector<Expected>& expected, const std::vector<Found>& found,
                   const cv::Size& frame, double dt_s);

  /// The same from something else that moves with the marks.
  CommonShift observe(const Eigen::Vector2d& shift_px, double variance_px2);

  [[nodiscard]] double variance_px2() const { return covariance_(0, 0); }

 private:
  Eigen::Matrix2d covariance_;  ///< of (shift, velocity)
};

}  // namespace stevedore
