#include "pose_proc/circle_pose.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <utility>

#include "pose_proc/circle_image.hpp"
#include "pose_proc/tilt_posterior.hpp"

namespace stevedore {
namespace {

/// The eigenvalues below go with the squares of a and b: flatter than this, double precision mixes them up.
constexpr double flattest = 1e-6;

/// The cone of rays through the ellipse: x^T Q x = 0 on it, < 0 inside, for directions x in the camera frame.
Eigen::Matrix3d cone_through(const Ellipse& e, const Pinhole& camera) {
  const Eigen::Matrix2d axes = Eigen::Rotation2Dd(e.alpha_rad).toRotationMatrix();
  const Eigen::Matrix2d inverse = Eigen::Vector2d(1 / e.a_px, 1 / e.b_px).asDiagonal() * axes.transpose();
  Eigen::Matrix<double, 2, 3> to_unit_circle;
  to_unit_circle.col(0) = inverse.col(0) * camera.fx_px;
  to_unit_circle.col(1) = inverse.col(1) * camera.fy_px;
  to_unit_circle.col(2) = inverse * Eigen::Vector2d(camera.cx_px - e.u_px, camera.cy_px - e.v_px);
  Eigen::Matrix3d cone = to_unit_circle.transpose() * to_unit_circle;
  cone(2, 2) -= 1;
  return cone;
}

/// The cone's own frame (tilt_posterior.hpp) and what it is there.
struct Cone {
  Eigen::Matrix3d camera_from_cone;
  double p_1, p_2;
};

Cone cone_of(const Ellipse& ellipse, const Pinhole& camera) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(cone_through(ellipse, camera));
  const Eigen::Vector3d& l = eigen.eigenvalues();  // ascending: one negative, then the wider side's
  Cone cone;
  cone.camera_from_cone << eigen.eigenvectors().col(2), eigen.eigenvectors().col(1),
      eigen.eigenvectors().col(0);
  if (cone.camera_from_cone(2, 2) < 0)
    cone.camera_from_cone.col(2) *= -1;  // the half of the cone in front of the camera
  if (cone.camera_from_cone(2, 0) > 0)
    cone.camera_from_cone.col(0) *= -1;  // leaning to +x is then nearer the optical axis
  cone.p_1 = -l[2] / l[0];
  cone.p_2 = -l[1] / l[0];
  return cone;
}

/// d (turn, mean, split) / d (m, S): the dual conic diag(-S, 1) about m, seen in the cone's frame.
Matrix5d cone_jacobian(const Cone& cone, const EdgeImage& edge) {
  const Eigen::Matrix<double, 3, 2> across = cone.camera_from_cone.topRows<2>().transpose();
  const Eigen::Vector3d ahead =
      cone.camera_from_cone.transpose() * Eigen::Vector3d(edge.value[0], edge.value[1], 1);
  Eigen::Matrix2d shape;
  shape << edge.value[2], edge.value[3], edge.value[3], edge.value[4];
  const Eigen::Vector2d p(cone.p_1, cone.p_2);
  const double scale = ahead.z() * ahead.z() - across.row(2) * shape * across.row(2).transpose();
  Matrix5d jacobian;
  for (int k = 0; k < 5; ++k) {
    Eigen::Matrix3d step;
    if (k < 2) {
      const Eigen::Matrix3d half = across.col(k) * ahead.transpose();
      step = half + half.transpose();
    } else {
      const Eigen::Matrix3d half = across.col(k == 4) * across.col(k > 2).transpose();
      step = k == 3 ? Eigen::Matrix3d(-half - half.transpose()) : Eigen::Matrix3d(-half);
    }
    step /= scale;
    const double ds_11 = -step(0, 0) - step(2, 2) / p[0], ds_22 = -step(1, 1) - step(2, 2) / p[1];
    const double dp_11 = -p[0] * p[0] * ds_11, dp_22 = -p[1] * p[1] * ds_22, dp_12 = p[0] * p[1] * step(0, 1);
    jacobian.col(k) << step(0, 2) / (1 + 1 / p[0]), step(1, 2) / (1 + 1 / p[1]), (dp_11 + dp_22) / 2,
        dp_11 - dp_22, 2 * dp_12;
  }
  return jacobian;
}

std::optional<ExpectedNormal> in_cone(const std::optional<ExpectedNormal>& expected, const Cone& cone) {
  if (!expected) return std::nullopt;
  return ExpectedNormal{cone.camera_from_cone.transpose() * expected->normal_camera, expected->variance_rad2};
}

CircleSolution in_camera(const ConeCircle& circle, const Eigen::Matrix3d& camera_from_cone) {
  return {camera_from_cone * circle.center_m, camera_from_cone * circle.normal,
          camera_from_cone * circle.center_covariance_m2 * camera_from_cone.transpose(),
          camera_from_cone * circle.normal_covariance_rad2 * camera_from_cone.transpose()};
}

}  // namespace

bool can_be_posed(const EllipseFit& fit, const Pinhole& camera, double radius_m) {
  const Ellipse& e = fit.ellipse;
  return is_valid(e) && e.b_px > flattest * e.a_px && fit.covariance.allFinite() && camera.fx_px > 0 &&
         camera.fy_px > 0 && std::isfinite(radius_m) && radius_m > 0 &&
         fit.covariance(2, 2) < e.a_px * e.a_px && fit.covariance(3, 3) < e.b_px * e.b_px;
}

std::optional<CirclePair> conic_pose(const EllipseFit& fit, const Pinhole& camera, double radius_m,
                                     const std::optional<ExpectedNormal>& expected) {
  if (!can_be_posed(fit, camera, radius_m)) return std::nullopt;
  const Cone cone = cone_of(fit.ellipse, camera);
  const EdgeImage edge = edge_image(fit, camera);
  const Matrix5d jacobian = cone_jacobian(cone, edge);
  const NoisyCone noisy{(cone.p_1 + cone.p_2) / 2, cone.p_1 - cone.p_2,
                        jacobian * edge.covariance * jacobian.transpose()};
  const auto circles = circles_on(noisy, radius_m, in_cone(expected, cone));
  CirclePair pair;
  for (std::size_t i = 0; i < 2; ++i) {
    pair.solutions[i] = in_camera(circles[i], cone.camera_from_cone);
    pair.likelihood[i] = circles[i].likelihood;
    if (!pair.solutions[i].center_camera_m.allFinite() || !pair.solutions[i].covariance_m2.allFinite())
      return std::nullopt;
  }
  if (pair.solutions[0].normal_camera.z() > pair.solutions[1].normal_camera.z()) {
    std::swap(pair.solutions[0], pair.solutions[1]);
    std::swap(pair.likelihood[0], pair.likelihood[1]);
  }
  return pair;
}

}  // namespace stevedore
