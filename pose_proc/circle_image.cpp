#include "pose_proc/circle_image.hpp"

#include <Eigen/Geometry>

namespace stevedore {
namespace {

/// (m, S) of a dual conic whose entry (2, 2) is not zero.
Vector5d center_and_shape(const Eigen::Matrix3d& dual) {
  const double q = dual(2, 2);
  const Eigen::Vector2d m = dual.topRightCorner<2, 1>() / q;
  Vector5d out;
  out << m, m.x() * m.x() - dual(0, 0) / q, m.x() * m.y() - dual(0, 1) / q, m.y() * m.y() - dual(1, 1) / q;
  return out;
}

/// The change of (m, S) with a change of the dual conic.
Vector5d step_of(const Eigen::Matrix3d& dual, const Vector5d& value, const Eigen::Matrix3d& change) {
  const double q = dual(2, 2), dq = change(2, 2);
  const Eigen::Vector2d m = value.head<2>(), dm = (change.topRightCorner<2, 1>() - m * dq) / q;
  const auto shape_step = [&](int i, int j) {
    return dm[i] * m[j] + m[i] * dm[j] - (change(i, j) - dual(i, j) / q * dq) / q;
  };
  Vector5d out;
  out << dm, shape_step(0, 0), shape_step(0, 1), shape_step(1, 1);
  return out;
}

Vector5d shape_vector(const Eigen::Vector2d& center, const Eigen::Matrix2d& shape) {
  Vector5d out;
  out << center, shape(0, 0), shape(0, 1), shape(1, 1);
  return out;
}

}  // namespace

EdgeImage edge_image(const EllipseFit& fit, const Pinhole& camera) {
  const Ellipse& e = fit.ellipse;
  const Eigen::Vector2d scale(1 / camera.fx_px, 1 / camera.fy_px), none = Eigen::Vector2d::Zero();
  const Eigen::Matrix2d axes = scale.asDiagonal() * Eigen::Rotation2Dd(e.alpha_rad).toRotationMatrix();
  const Eigen::Vector2d major = axes.col(0), minor = axes.col(1);
  const Eigen::Matrix2d along = major * major.transpose(), across = minor * minor.transpose();
  const Eigen::Matrix2d turned = major * minor.transpose() + minor * major.transpose();
  const double a2 = e.a_px * e.a_px, b2 = e.b_px * e.b_px;
  Matrix5d jacobian;
  jacobian << Vector5d(Vector5d::Unit(0) * scale.x()), Vector5d(Vector5d::Unit(1) * scale.y()),
      shape_vector(none, 2 * e.a_px * along), shape_vector(none, 2 * e.b_px * across),
      shape_vector(none, (a2 - b2) * turned);
  return {shape_vector(camera.unproject({e.u_px, e.v_px}).head<2>(), a2 * along + b2 * across),
          jacobian * fit.covariance * jacobian.transpose()};
}

CircleImage circle_image(const Eigen::Vector3d& center_camera_m, const Eigen::Vector3d& normal_camera,
                         double radius_m) {
  const Eigen::Vector3d &c = center_camera_m, &n = normal_camera;
  const double r2 = radius_m * radius_m;
  const Eigen::Matrix3d flat = Eigen::Matrix3d::Identity() - n * n.transpose();
  const Eigen::Matrix3d dual = c * c.transpose() - r2 * flat;
  CircleImage image;
  image.value = center_and_shape(dual);
  for (int k = 0; k < 3; ++k) {
    const Eigen::Matrix3d c_step = Eigen::Vector3d::Unit(k) * c.transpose();
    const Eigen::Matrix3d n_step = Eigen::Vector3d::Unit(k) * n.transpose();
    image.by_center.col(k) = step_of(dual, image.value, c_step + c_step.transpose());
    image.by_normal.col(k) = step_of(dual, image.value, r2 * (n_step + n_step.transpose()));
  }
  image.by_radius = step_of(dual, image.value, -2 * radius_m * flat);
  return image;
}

}  // namespace stevedore
