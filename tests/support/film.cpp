#include "tests/support/film.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>

namespace stevedore {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;

constexpr double half_side_m = 0.8;
constexpr double ring_width_m = 0.1;
constexpr double platform_half_m = 1.6;
constexpr int samples =
    3;  // a side: edges of 9 levels, enough for an edge to be placed to a tenth of a pixel

const std::array<Vector2d, 4> ring_centers = {
    Vector2d{-half_side_m, -half_side_m}, Vector2d{half_side_m, -half_side_m},
    Vector2d{half_side_m, half_side_m}, Vector2d{-half_side_m, half_side_m}};

/// Camera over the platform's plane z = 0 (x, y on it, z down): where it is and how it is turned.
struct View {
  Eigen::Matrix3d platform_from_camera;
  Vector3d camera_m;
};

View view_of(int k) {
  const double t = k / 30.0;
  const Vector3d camera_m(0.4 * std::sin(0.9 * t), 0.3 * std::cos(0.7 * t), -3.5 + 0.5 * std::cos(0.6 * t));
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(0.2 * std::sin(0.5 * t), Vector3d::UnitZ()) *
                                Eigen::AngleAxisd(0.10 * std::sin(0.8 * t), Vector3d::UnitX()) *
                                Eigen::AngleAxisd(0.08 * std::cos(1.1 * t), Vector3d::UnitY()))
                                   .toRotationMatrix();
  return {turn, camera_m};
}

/// Grass, deck or paint at a point of the plane: blue, green, red.
Vector3d colour_at(const Vector2d& p) {
  for (const Vector2d& center : ring_centers) {
    const double r = (p - center).norm();
    if (r < film_circle_radius_m && r > film_circle_radius_m - ring_width_m) return {225, 230, 235};
  }
  if (p.cwiseAbs().maxCoeff() < platform_half_m) return {70, 62, 58};
  const double patches =
      std::sin(3.1 * p.x() + std::sin(2.3 * p.y())) * std::sin(2.7 * p.y() + std::sin(1.9 * p.x()));
  return Vector3d{40, 95, 70} + 14 * patches * Vector3d{1, 1, 1};
}

Ellipse outline(const Vector2d& center, const View& view) {
  // the circle's conic on its plane, carried into the image by the plane's homography: C' = H^-T C H^-1
  Eigen::Matrix3d circle = Eigen::Matrix3d::Identity();
  circle.topRightCorner<2, 1>() = circle.bottomLeftCorner<1, 2>().transpose() = -center;
  circle(2, 2) = center.squaredNorm() - film_circle_radius_m * film_circle_radius_m;
  const Eigen::Matrix3d camera_from_platform = view.platform_from_camera.transpose();
  Eigen::Matrix3d homography;
  homography << camera_from_platform.leftCols<2>(), -camera_from_platform * view.camera_m;
  const Eigen::Matrix3d plane_from_image = (film_camera().matrix() * homography).inverse();
  return ellipse_from_conic(plane_from_image.transpose() * circle * plane_from_image).value();
}

}  // namespace

Pinhole film_camera() {
  return {640, 480, 337, 337, 319.5, 239.5};
}

FilmFrame film_frame(int k) {
  const View view = view_of(k);
  const Pinhole camera = film_camera();
  FilmFrame frame{cv::Mat(camera.height_px, camera.width_px, CV_8UC3), {}};
  for (int v = 0; v < camera.height_px; ++v) {
    for (int u = 0; u < camera.width_px; ++u) {
      Vector3d sum = Vector3d::Zero();
      for (int s = 0; s < samples * samples; ++s) {
        const Vector2d offset((s % samples + 0.5) / samples - 0.5, (s / samples + 0.5) / samples - 0.5);
        const Vector3d ray = view.platform_from_camera * camera.unproject(Vector2d(u, v) + offset);
        sum += colour_at((view.camera_m - ray * (view.camera_m.z() / ray.z())).head<2>());
      }
      const Vector3d mean = sum / (samples * samples);
      frame.image.at<cv::Vec3b>(v, u) = {cv::saturate_cast<uchar>(mean[0]), cv::saturate_cast<uchar>(mean[1]),
                                         cv::saturate_cast<uchar>(mean[2])};
    }
  }
  cv::Mat noise(frame.image.size(), CV_16SC3), noisy;
  cv::RNG rng(static_cast<uint64_t>(k) + 1);
  rng.fill(noise, cv::RNG::NORMAL, 0, 2);  // grey levels
  frame.image.convertTo(noisy, CV_16SC3);
  cv::Mat(noisy + noise).convertTo(frame.image, CV_8UC3);
  for (const Vector2d& center : ring_centers) frame.outer_edges.push_back(outline(center, view));
  return frame;
}

}  // namespace stevedore
