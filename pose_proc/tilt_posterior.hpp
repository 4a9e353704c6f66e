// The two circles on a cone of rays that is known with noise.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "pose_proc/circle_image.hpp"
#include "pose_proc/expected_normal.hpp"

namespace stevedore {

/// A cone x^T diag(p_1, p_2, -1) x = 0, p_1 >= p_2 > 0, in its own frame: z along its axis, x across the
/// narrower side. How it may differ from that: (d_x, d_y), turn of the axis towards x and y, rad; mean
/// (P_xx + P_yy) / 2; and the split (P_xx - P_yy, 2 P_xy), P being the upper left of the cone's matrix.
struct NoisyCone {
  double mean = 0;
  double split = 0;  ///< p_1 - p_2; the other component is 0 in this frame
  Matrix5d covariance = Matrix5d::Zero();
};

/// One of the two circles in the cone's frame, and its likelihood under what is expected.
struct ConeCircle {
  Eigen::Vector3d center_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  Eigen::Matrix3d center_covariance_m2 = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d normal_covariance_rad2 = Eigen::Matrix3d::Zero();
  double likelihood = 0;
};

/// The one leaning towards +x first. With t the normal's component across the axis, as a complex number, the
/// split is (1 + p_1) t^2 (from the planes of Kanatani and Liu 1993 that cut a cone in circles): t is the
/// root of something Gaussian, and where that may be zero the two solutions run into each other and no
/// derivative says how far. So means and covariances are integrals over the plane of the split, on nodes,
/// with all angles of tilt equally probable beforehand (which is dt^2 / |t|); the rest is linear.
std::array<ConeCircle, 2> circles_on(const NoisyCone& cone, double radius_m,
                                     const std::optional<ExpectedNormal>& expected);

}  // namespace stevedore
