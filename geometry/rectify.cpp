#include "geometry/rectify.hpp"

#include <Eigen/QR>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace stevedore {
namespace {

using std::numbers::pi;

cv::Mat matrix(const Pinhole& pinhole) {
  cv::Mat out;
  cv::eigen2cv(pinhole.matrix(), out);
  return out;
}

bool same(const Pinhole& a, const Pinhole& b) {
  return a.width_px == b.width_px && a.height_px == b.height_px && a.matrix() == b.matrix();
}

/// Brown (1966) as OpenCV's calib3d page writes it; ray is (x/z, y/z).
Eigen::Vector2d plumb_bob(const std::vector<double>& k, const Eigen::Vector2d& ray) {
  const double x = ray.x(), y = ray.y(), r2 = ray.squaredNorm();
  const double radial = 1 + r2 * (k[0] + r2 * (k[1] + r2 * k[4]));
  return {x * radial + 2 * k[2] * x * y + k[3] * (r2 + 2 * x * x),
          y * radial + k[2] * (r2 + 2 * y * y) + 2 * k[3] * x * y};
}

/// Kannala and Brandt (2006): the radius is an odd polynomial of the angle from the optical axis.
Eigen::Vector2d equidistant(const std::vector<double>& k, const Eigen::Vector2d& ray) {
  const double r = ray.norm();
  if (r < 1e-12) return ray;  // on the axis nothing moves, and the quotient below is 0 / 0
  const double angle = std::atan(r), a2 = angle * angle;
  return ray * (angle * (1 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3])))) / r);
}

Eigen::Vector2d distort_ray(const CameraModel& camera, const Eigen::Vector2d& ray) {
  switch (camera.distortion) {
    case Distortion::none:
      return ray;
    case Distortion::plumb_bob:
      return plumb_bob(camera.coefficients, ray);
    case Distortion::equidistant:
      return equidistant(camera.coefficients, ray);
  }
  return ray;
}

}  // namespace

RectifyMaps make_rectify_maps(const CameraModel& camera) {
  RectifyMaps maps;
  if (camera.distortion == Distortion::none && same(camera.given, camera.rectified)) return maps;
  const cv::Mat given = matrix(camera.given), rectified = matrix(camera.rectified);
  maps.given_size = {camera.given.width_px, camera.given.height_px};
  const cv::Size size(camera.rectified.width_px, camera.rectified.height_px);
  constexpr int type =
      CV_16SC2;  // cv::remap interpolates in steps of 1/32 px with float maps too; these are faster
  if (camera.distortion == Distortion::equidistant)
    cv::fisheye::initUndistortRectifyMap(given, camera.coefficients, cv::Matx33d::eye(), rectified, size,
                                         type, maps.map_1, maps.map_2);
  else
    cv::initUndistortRectifyMap(given, camera.coefficients, cv::noArray(), rectified, size, type, maps.map_1,
                                maps.map_2);
  return maps;
}

cv::Mat rectify(const cv::Mat& given, const RectifyMaps& maps) {
  if (maps.map_1.empty()) return given;
  CV_Assert(given.size() == maps.given_size);
  cv::Mat out;
  cv::remap(given, out, maps.map_1, maps.map_2, cv::INTER_LINEAR, cv::BORDER_CONSTANT);
  return out;
}

Eigen::Vector2d distort(const CameraModel& camera, const Eigen::Vector2d& rectified_px) {
  const Eigen::Vector2d ray = distort_ray(camera, camera.rectified.unproject(rectified_px).head<2>());
  return camera.given.project(ray.homogeneous());
}

std::optional<Eigen::Vector2d> undistort(const CameraModel& camera, const Eigen::Vector2d& given_px) {
  // Newton with a numeric Jacobian. It starts on the axis' side of the answer for barrel lenses, where the
  // models are monotone; ten steps are twice what 1e-9 px takes at the corner of a 120-degree lens.
  constexpr double step = 1e-6, done_px = 1e-9;
  const Eigen::Vector2d target = camera.given.unproject(given_px).head<2>();
  Eigen::Vector2d ray = target;
  for (int i = 0; i < 10; ++i) {
    const Eigen::Vector2d miss = distort_ray(camera, ray) - target;
    if (miss.norm() * camera.given.fx_px < done_px) return camera.rectified.project(ray.homogeneous());
    Eigen::Matrix2d jacobian;
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d d = step * Eigen::Vector2d::Unit(axis);
      jacobian.col(axis) = (distort_ray(camera, ray + d) - distort_ray(camera, ray - d)) / (2 * step);
    }
    ray -= jacobian.inverse() * miss;
  }
  return std::nullopt;
}

std::optional<Ellipse> distort(const CameraModel& camera, const Ellipse& rectified) {
  if (camera.distortion == Distortion::none && same(camera.given, camera.rectified)) return rectified;
  return bent(rectified, [&camera](const Eigen::Vector2d& px) { return distort(camera, px); });
}

std::optional<Ellipse> bent(const Ellipse& ellipse, const PixelMap& map) {
  constexpr int samples = 64;  // an outline the lens bends by pixels is smooth: 64 points carry all of it
  std::vector<Eigen::Vector2d> points_px;
  Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();
  for (int i = 0; i < samples; ++i) {
    const auto p = map(point_at(ellipse, 2 * pi * i / samples));
    if (p) points_px.push_back(*p);
    if (p) mean_px += *p;
  }
  if (points_px.size() < samples / 4) return std::nullopt;
  const auto count = static_cast<Eigen::Index>(points_px.size());
  mean_px /= static_cast<double>(count);
  // least squares of A x^2 + B xy + C y^2 + D x + E y = 1 about the mean, which is inside the outline
  Eigen::Matrix<double, Eigen::Dynamic, 5> rows(count, 5);
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::Vector2d p = (points_px[static_cast<size_t>(i)] - mean_px) / ellipse.a_px;
    rows.row(i) << p.x() * p.x(), p.x() * p.y(), p.y() * p.y(), p.x(), p.y();
  }
  const Eigen::Matrix<double, 5, 1> k = rows.colPivHouseholderQr().solve(Eigen::VectorXd::Ones(count));
  Eigen::Matrix3d conic;
  conic << k[0], k[1] / 2, k[3] / 2,  //
      k[1] / 2, k[2], k[4] / 2,       //
      k[3] / 2, k[4] / 2, -1;
  auto fitted = ellipse_from_conic(conic);
  if (!fitted) return std::nullopt;
  fitted->u_px = fitted->u_px * ellipse.a_px + mean_px.x();
  fitted->v_px = fitted->v_px * ellipse.a_px + mean_px.y();
  fitted->a_px *= ellipse.a_px;
  fitted->b_px *= ellipse.a_px;
  return fitted;
}

}  // namespace stevedore
