#include "pose_proc/circle_image.hpp"

#include <Eigen/Geometry>

namespace stevedore {
namespace {

/// A symmetric matrix as (00, 01, 11, 02, 12, 22).
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// (m, S) of a dual conic whose entry (2, 2) is not zero.
Vector5d center_and_shape(const Vector6d& dual) {
  const double q = dual[5], x = dual[3] / q, y = dual[4] / q;
  Vector5d out;
  out << x, y, x * x - dual[0] / q, x * y - dual[1] / q, y * y - dual[2] / q;
  return out;
}

/// d (m, S) / d dual conic.
Eigen::Matrix<double, 5, 6> by_dual(const Vector5d& value, double q) {
  const double x = value[0], y = value[1];
  Eigen::Matrix<double, 5, 6> out;
  out << 0, 0, 0, 1, 0, -x,                   //
      0, 0, 0, 0, 1, -y,                      //
      -1, 0, 0, 2 * x, 0, -x * x - value[2],  //
      0, -1, 0, y, x, -x * y - value[3],      //
      0, 0, -1, 0, 2 * y, -y * y - value[4];
  return out / q;
}

/// d (v v^T) / d v.
Eigen::Matrix<double, 6, 3> square_by(const Eigen::Vector3d& v) {
  Eigen::Matrix<double, 6, 3> out;
  out << 2 * v.x(), 0, 0,  //
      v.y(), v.x(), 0,     //
      0, 2 * v.y(), 0,     //
      v.z(), 0, v.x(),     //
      0, v.z(), v.y(),     //
      0, 0, 2 * v.z();
  return out;
}

Vector6d square(const Eigen::Vector3d& v) {
  Vector6d out;
  out << v.x() * v.x(), v.x() * v.y(), v.y() * v.y(), v.x() * v.z(), v.y() * v.z(), v.z() * v.z();
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
  const double r2 = radius_m * radius_m;
  const Vector6d identity = (Vector6d() << 1, 0, 1, 0, 0, 1).finished();
  const Vector6d flat = identity - square(normal_camera);
  const Vector6d dual = square(center_camera_m) - r2 * flat;
  CircleImage image;
  image.value = center_and_shape(dual);
  const Eigen::Matrix<double, 5, 6> outer = by_dual(image.value, dual[5]);
  image.by_center.noalias() = outer * square_by(center_camera_m);
  image.by_normal.noalias() = outer * (r2 * square_by(normal_camera));
  image.by_radius.noalias() = outer * (-2 * radius_m * flat);
  return image;
}

}  // namespace stevedore
