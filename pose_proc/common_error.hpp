// Errors that all poses of a flight share: they do not average out over circles or frames.
#pragma once

#include <Eigen/Core>

#include "geometry/camera.hpp"
#include "pose_proc/pose_settings.hpp"

namespace stevedore {

/// Covariance, m^2, of a centre by what is believed of the radius (all distances scale with it), of the focal
/// length (the depth does, its image being what it is) and of the principal point (the ray turns). Zero while
/// the settings are.
Eigen::Matrix3d common_error(const Eigen::Vector3d& center_camera_m, const Pinhole& camera,
                             const PoseSettings& settings);

}  // namespace stevedore
