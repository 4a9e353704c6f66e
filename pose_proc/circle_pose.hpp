// The pose of one circle of known radius from its image, an ellipse.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "geometry/camera.hpp"
#include "geometry/detection.hpp"
#include "pose_proc/expected_normal.hpp"

namespace stevedore {

/// One circle in space. Camera frame: x right, y down, z forward. The covariances are the edge's alone, given
/// that this is the circle: no error of radius, calibration or choice is in them.
struct CircleSolution {
  Eigen::Vector3d center_camera_m;
  Eigen::Vector3d normal_camera;                                     ///< unit, towards the camera
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();           ///< of the centre
  Eigen::Matrix3d normal_covariance_rad2 = Eigen::Matrix3d::Zero();  ///< singular along the normal
};

/// The two circles that one ellipse allows, and how well each agrees with where the normal is expected:
/// likelihoods, of which only the quotient matters; equal when nothing is expected.
struct CirclePair {
  std::array<CircleSolution, 2> solutions;
  std::array<double, 2> likelihood{1, 1};
};

/// The two circles of this radius that the camera sees as this ellipse, exact at any tilt and place for an
/// exact ellipse; the one whose normal is nearer the optical axis comes first. For one with noise they are
/// means over the circles that the noise allows (tilt_posterior.hpp), which differ from the closed form where
/// the two solutions merge. Nothing for what is not an ellipse, a radius that is not positive, or an ellipse
/// whose own standard deviation exceeds its width. After Kanatani and Liu (1993), "3D interpretation of
/// conics and orthogonality", and Chen, Wu and Wada (2004), "Camera calibration with two arbitrary coplanar
/// circles".
std::optional<CirclePair> conic_pose(const EllipseFit& fit, const Pinhole& camera, double radius_m,
                                     const std::optional<ExpectedNormal>& expected = std::nullopt);

/// The paper's Algorithm 3: the ellipse's four vertexes are taken for four points a quarter turn apart on the
/// circle. True only where the circle is parallel to the image plane (the paper's remark 1): at 15 degrees of
/// tilt and 1.6 m the centre of a 1 m circle is 12 to 45 mm wrong. The covariance holds the ellipse's noise
/// (variances to about a third), not this error.
std::optional<CircleSolution> four_point_pose(const EllipseFit& fit, const Pinhole& camera, double radius_m);

/// An ellipse, a positive radius, a camera, finite noise that is smaller than the ellipse.
bool can_be_posed(const EllipseFit& fit, const Pinhole& camera, double radius_m);

}  // namespace stevedore
