// Circles on one plane, fitted together: both edges of a ring, or all the circles of a deck.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "pose_proc/circle_image.hpp"

namespace stevedore {

/// One painted mark: its outer edge, of known radius, and the ring's inner edge, whose radius is not known.
struct PlaneMark {
  EdgeImage outer;
  std::optional<EdgeImage> inner;
  double radius_m = 0;
  Eigen::Vector3d start_center_camera_m = Eigen::Vector3d::Zero();  ///< where the fit begins
};

struct PlaneFit {
  Eigen::Vector3d normal_camera;  ///< unit, towards the camera
  Eigen::Matrix3d normal_covariance_rad2;
  std::vector<Eigen::Vector3d> center_camera_m;  ///< of each mark, in the order given
  std::vector<Eigen::Matrix3d> covariance_m2;    ///< of each; the plane's share is common to all of them
  double chi_squared = 0;                        ///< what is left of the edges, over their covariance
  int freedom = 0;                               ///< how much of it noise alone leaves
};

/// Maximum likelihood over the plane, the centres on it and the rings' widths, by Gauss and Newton from a
/// normal and centres that are roughly right. Each mark's own unknowns are eliminated, so that the cost is
/// linear in the marks. Nothing where the edges don't determine it or it doesn't settle.
std::optional<PlaneFit> fit_plane(const std::vector<PlaneMark>& marks,
                                  const Eigen::Vector3d& start_normal_camera);

}  // namespace stevedore
