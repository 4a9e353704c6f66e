// A deck whose circles are where a plan says: one pose from all of them.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "pose_proc/circle_image.hpp"

namespace stevedore {

/// A circle that was seen and told apart. Deck frame: x and y in the plane, z away from the camera.
struct LayoutMark {
  EdgeImage outer;
  double radius_m = 0;
  Eigen::Vector2d place_deck_m;           ///< of its centre, by the plan
  Eigen::Vector3d start_center_camera_m;  ///< about where it is
};

struct LayoutPose {
  Eigen::Matrix3d camera_from_deck;  ///< third column: against the normal
  Eigen::Vector3d origin_camera_m;
  /// Of (turn, origin): the turn is a small rotation vector about the camera's axes; rad^2, rad m, m^2.
  Eigen::Matrix<double, 6, 6> covariance;
  double chi_squared = 0;
  int freedom = 0;
};

/// Maximum likelihood over the six unknowns by Gauss and Newton. Normal, heading and range come out far
/// better than from any circle alone. Which circle is which has to be known; a square that is a quarter turn
/// wrong fits as well. Nothing for fewer than two marks or where it doesn't settle.
std::optional<LayoutPose> layout_pose(const std::vector<LayoutMark>& marks,
                                      const Eigen::Vector3d& start_normal_camera);

}  // namespace stevedore
