// Circles in space, their exact images, and ellipses fitted to noisy points of those: what a detector
// measures, made by hand, without the code under test.
#pragma once

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "geometry/camera.hpp"
#include "geometry/detection.hpp"

namespace stevedore {

struct Circle {
  Eigen::Vector3d center_m;
  Eigen::Vector3d normal;  ///< unit, towards the camera
  double radius_m;
};

/// At a pixel and a depth; the normal leans by tilt from the optical axis, towards an azimuth in the image.
inline Circle circle_at(const Pinhole& camera, double u_px, double v_px, double depth_m, double tilt_rad,
                        double azimuth_rad, double radius_m = 0.5) {
  Circle circle{depth_m * camera.unproject({u_px, v_px}),
                {std::sin(tilt_rad) * std::cos(azimuth_rad), std::sin(tilt_rad) * std::sin(azimuth_rad),
                 -std::cos(tilt_rad)},
                radius_m};
  if (circle.normal.dot(circle.center_m) > 0) circle.normal = -circle.normal;  // seen from behind
  return circle;
}

/// The homography from the circle's plane to the image turns its unit circle into the image's conic. Taken
/// about the pixel of the circle's centre: about the image's corner, flat ellipses would lose ten digits.
inline std::optional<Ellipse> image_of(const Pinhole& camera, const Circle& circle) {
  const Eigen::Vector3d x = circle.normal.unitOrthogonal(), y = circle.normal.cross(x);
  const Eigen::Vector2d origin_px = camera.project(circle.center_m);
  Eigen::Matrix3d to_origin = Eigen::Matrix3d::Identity(), circle_plane;
  to_origin.topRightCorner<2, 1>() = -origin_px;
  circle_plane << circle.radius_m * x, circle.radius_m * y, circle.center_m;
  const Eigen::Matrix3d inverse = (to_origin * camera.matrix() * circle_plane).inverse();
  auto ellipse = ellipse_from_conic(inverse.transpose() * Eigen::Vector3d(1, 1, -1).asDiagonal() * inverse);
  if (!ellipse) return std::nullopt;
  ellipse->u_px += origin_px.x();
  ellipse->v_px += origin_px.y();
  return ellipse;
}

/// Points along the part of the outline that is not hidden, two pixels apart, each off by sigma across it.
inline std::vector<Eigen::Vector2d> edge_points(const Ellipse& e, double sigma_px, double hidden_share,
                                                std::mt19937& random) {
  std::normal_distribution<double> normal;
  const double start_rad = std::uniform_real_distribution<double>(0, 2 * std::numbers::pi)(random);
  const int count = std::max(24, static_cast<int>(perimeter_px(e) / 2));
  const Eigen::Rotation2Dd turn(e.alpha_rad);
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i < static_cast<int>(count * (1 - hidden_share)); ++i) {
    const double t_rad = start_rad + 2 * std::numbers::pi * i / count;
    const Eigen::Vector2d outward =
        turn * Eigen::Vector2d(std::cos(t_rad) / e.a_px, std::sin(t_rad) / e.b_px).normalized();
    points.emplace_back(point_at(e, t_rad) + sigma_px * normal(random) * outward);
  }
  return points;
}

/// Least squares of the points' distances (Sampson 1982) from a start that is near, with its covariance.
inline std::optional<EllipseFit> fitted(const std::vector<Eigen::Vector2d>& points, const Ellipse& start,
                                        double sigma_px) {
  Eigen::Vector2d center(start.u_px, start.v_px);
  Eigen::Matrix2d axes = Eigen::Rotation2Dd(start.alpha_rad).toRotationMatrix();
  Eigen::Matrix2d shape =
      axes * Eigen::Vector2d(start.a_px, start.b_px).cwiseAbs2().asDiagonal() * axes.transpose();
  Eigen::Matrix<double, 5, 5> matrix;  // of (centre, S_11, S_12, S_22)
  for (int step = 0; step < 8; ++step) {
    matrix.setZero();
    Eigen::Matrix<double, 5, 1> right = Eigen::Matrix<double, 5, 1>::Zero();
    const Eigen::Matrix2d inverse = shape.inverse();
    for (const Eigen::Vector2d& p : points) {
      const Eigen::Vector2d q = p - center, g = inverse * q;
      Eigen::Matrix<double, 5, 1> row;
      row << 2 * g, g.x() * g.x(), 2 * g.x() * g.y(), g.y() * g.y();
      row /= 2 * g.norm();
      matrix += row * row.transpose();
      right += row * ((q.dot(g) - 1) / (2 * g.norm()));
    }
    const Eigen::Matrix<double, 5, 1> change = matrix.ldlt().solve(right);
    center += change.head<2>();
    shape(0, 0) += change[2];
    shape(1, 1) += change[4];
    shape(0, 1) = shape(1, 0) = shape(0, 1) + change[3];
    if (!(shape.determinant() > 0 && shape(0, 0) > 0)) return std::nullopt;
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(shape);
  const double a = std::sqrt(eigen.eigenvalues()[1]), b = std::sqrt(eigen.eigenvalues()[0]);
  axes.col(0) = eigen.eigenvectors().col(1);
  axes.col(1) << -axes(1, 0), axes(0, 0);
  EllipseFit fit{normalized({center.x(), center.y(), a, b, std::atan2(axes(1, 0), axes(0, 0))}), {}};
  Eigen::Matrix<double, 5, 5> jacobian = Eigen::Matrix<double, 5, 5>::Identity();  // d (m, S) / d ellipse
  const std::vector<Eigen::Matrix2d> steps{
      2 * a * axes.col(0) * axes.col(0).transpose(), 2 * b * axes.col(1) * axes.col(1).transpose(),
      (a * a - b * b) * (axes.col(0) * axes.col(1).transpose() + axes.col(1) * axes.col(0).transpose())};
  for (int k = 0; k < 3; ++k) {
    const Eigen::Matrix2d& s = steps[static_cast<std::size_t>(k)];
    jacobian.col(2 + k) << 0, 0, s(0, 0), s(0, 1), s(1, 1);
  }
  const Eigen::Matrix<double, 5, 5> back = jacobian.inverse();
  fit.covariance = sigma_px * sigma_px * back * matrix.inverse() * back.transpose();
  return fit.covariance.allFinite() ? std::optional(fit) : std::nullopt;
}

}  // namespace stevedore
