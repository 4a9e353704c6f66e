#include "pose_proc/expected_normal.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

namespace stevedore {
namespace {

using std::numbers::pi;

/// One in a hundred lies anyhow. It decides only where neither solution is near what is expected: there the
/// nearer one is then no longer taken for certain.
constexpr double anyhow_share = 0.01;
constexpr double anyhow_density = 1 / (2 * pi);  // any direction of the hemisphere that can be seen

double with_outliers(double gaussian) {
  return (1 - anyhow_share) * gaussian + anyhow_share * anyhow_density;
}

/// From the one direction to the other, as long as the angle between them.
Eigen::Vector3d turn_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const Eigen::Vector3d chord = b - a;
  const double half = chord.norm() / 2;
  if (half < 1e-9) return chord;
  return chord * (std::asin(std::min(half, 1.0)) / half);
}

}  // namespace

double density(const ExpectedNormal& expected, const Eigen::Vector3d& normal_camera,
               const Eigen::Matrix3d& normal_covariance_rad2) {
  // across the normal the covariance has two dimensions; along it the expected variance stands in and is
  // taken out of the determinant again
  const Eigen::Matrix3d total = normal_covariance_rad2 + expected.variance_rad2 * Eigen::Matrix3d::Identity();
  const Eigen::Vector3d off = turn_between(expected.normal_camera, normal_camera);
  const double determinant = total.determinant() / expected.variance_rad2;
  return with_outliers(std::exp(-off.dot(total.inverse() * off) / 2) / (2 * pi * std::sqrt(determinant)));
}

double density(const ExpectedNormal& expected, const Eigen::Vector3d& normal_camera,
               double normal_variance_rad2) {
  const double variance = expected.variance_rad2 + normal_variance_rad2;
  const double off2 = turn_between(expected.normal_camera, normal_camera).squaredNorm();
  return with_outliers(std::exp(-off2 / (2 * variance)) / (2 * pi * variance));
}

}  // namespace stevedore
