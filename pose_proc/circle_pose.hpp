// The pose of one circle of known radius from its image, an ellipse.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "geometry/camera.hpp"
#include "geometry/detection.hpp"

namespace stevedore {

/// One circle in space. Camera frame: x right, y down, z forward.
struct CircleSolution {
  Eigen::Vector3d center_camera_m;
  Eigen::Vector3d normal_camera;  ///< unit, towards the camera
  Eigen::Matrix3d covariance_m2;  ///< of the centre, from the ellipse's alone: given that this is the circle
  double normal_variance_rad2 = 0;  ///< of the normal, mean of its two directions
};

/// The two circles of this radius that the camera sees as this ellipse, exact at any tilt and place; the one
/// whose normal is nearer the optical axis comes first. They are the same circle when it faces the camera.
/// Nothing for what is not an ellipse, a radius that is not positive, or an ellipse whose own standard
/// deviation exceeds its width. After Kanatani and Liu (1993), "3D interpretation of conics and
/// orthogonality", and Chen, Wu and Wada (2004), "Camera calibration with two arbitrary coplanar circles".
std::optional<std::array<CircleSolution, 2>> conic_pose(const EllipseFit& fit, const Pinhole& camera,
                                                        double radius_m);

/// The paper's Algorithm 3: the ellipse's four vertexes are taken for four points a quarter turn apart on the
/// circle. True only where the circle is parallel to the image plane (the paper's remark 1): at 15 degrees of
/// tilt and 1.6 m the centre of a 1 m circle is 12 to 45 mm wrong. The covariance holds the ellipse's noise
/// (variances to about a third), not this error.
std::optional<CircleSolution> four_point_pose(const EllipseFit& fit, const Pinhole& camera, double radius_m);

}  // namespace stevedore
