#include "pose_proc/common_error.hpp"

namespace stevedore {

Eigen::Matrix3d common_error(const Eigen::Vector3d& center_camera_m, const Pinhole& camera,
                             const PoseSettings& settings) {
  const double depth_m = center_camera_m.z();
  const Eigen::Vector3d by_radius = center_camera_m * (settings.radius_sigma_percent / 100);
  const Eigen::Vector3d by_focal(0, 0, depth_m * settings.focal_sigma_percent / 100);
  const Eigen::Vector3d by_principal_point(settings.principal_point_sigma_px * depth_m / camera.fx_px,
                                           settings.principal_point_sigma_px * depth_m / camera.fy_px, 0);
  Eigen::Matrix3d covariance = by_radius * by_radius.transpose() + by_focal * by_focal.transpose();
  covariance.diagonal() += by_principal_point.cwiseAbs2();
  return covariance;
}

}  // namespace stevedore
