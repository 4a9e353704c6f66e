// Where a circle's normal is expected before its image is looked at.
#pragma once

#include <Eigen/Core>

namespace stevedore {

/// A Gaussian about a direction, and a few circles that lie anyhow: on a slope, on something tipped over, or
/// under an attitude that is wrong.
struct ExpectedNormal {
  Eigen::Vector3d normal_camera;  ///< unit
  double variance_rad2 = 0;       ///< about each of the two directions across it
};

/// Density, 1/sr, of a normal measured with this covariance under what is expected.
double density(const ExpectedNormal& expected, const Eigen::Vector3d& normal_camera,
               const Eigen::Matrix3d& normal_covariance_rad2);

/// The same for a normal with equal noise in all directions.
double density(const ExpectedNormal& expected, const Eigen::Vector3d& normal_camera,
               double normal_variance_rad2);

}  // namespace stevedore
