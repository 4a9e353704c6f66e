#include "geometry/rectify.hpp"

#include <Eigen/QR>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <opencv2/imgproc.hpp>

#include "geometry/lens.hpp"

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
  const MappedPoint bent = distort_ray(camera, camera.rectified.unproject(rectified_px).head<2>());
  return camera.given.project(bent.point.homogeneous());
}

std::optional<Eigen::Vector2d> undistort(const CameraModel& camera, const Eigen::Vector2d& given_px) {
  const auto ray = undistort_ray(camera, camera.given.unproject(given_px).head<2>());
  if (!ray) return std::nullopt;
  return camera.rectified.project(ray->point.homogeneous());
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
