#include "sim_proc/world/view.hpp"

#include <cmath>

#include "geometry/rectify.hpp"

namespace stevedore::world {

Eigen::Vector2d View::pixel_of(const Eigen::Vector3d& point_camera_m) const {
  Eigen::Vector2d ray = point_camera_m.head<2>() / point_camera_m.z();
  constexpr double beyond = 1.1;  // clearly outside of the image, where lens polynomials still rise
  const double widest = beyond * static_cast<double>(rays.widest), length = ray.norm();
  if (lens.distortion != Distortion::none && length > widest) ray *= widest / length;
  return distort(lens, lens.rectified.project(ray.homogeneous()));
}

namespace {

using Points = std::vector<Eigen::Vector3d>;

/// Of the hull of points in camera axes what lies before the camera, as points again: the hull of those that
/// do and of where the lines from them to the others pass the least depth.
Points before_camera(const Points& points_camera_m) {
  constexpr double least_depth_m = 0.02;
  Points before, behind;
  for (const Eigen::Vector3d& point : points_camera_m)
    (point.z() < least_depth_m ? behind : before).push_back(point);
  const size_t seen = before.size();
  for (const Eigen::Vector3d& hidden : behind)
    for (size_t i = 0; i < seen; ++i) {
      const Eigen::Vector3d way = hidden - before[i];
      before.emplace_back(before[i] + (least_depth_m - before[i].z()) / way.z() * way);
    }
  return before;
}

}  // namespace

PixelRect View::bounds_of(const std::vector<Eigen::Vector3d>& points_ned_m, double margin_px) const {
  Points points;
  points.reserve(points_ned_m.size());
  for (const Eigen::Vector3d& point : points_ned_m) points.push_back(to_camera(point));
  points = before_camera(points);
  if (points.empty()) return {};
  const PixelRect all{0, 0, rays.width_px, rays.height_px};
  Eigen::Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  for (const Eigen::Vector3d& point : points) {
    const Eigen::Vector2d px = pixel_of(point);
    low = low.cwiseMin(px);
    high = high.cwiseMax(px);
  }
  const auto clamped = [](double px, int size) {
    return static_cast<int>(std::clamp(px, -1.0, static_cast<double>(size) + 1));
  };
  return {std::max(0, clamped(std::floor(low.x() - margin_px), all.right)),
          std::max(0, clamped(std::floor(low.y() - margin_px), all.bottom)),
          std::min(all.right, clamped(std::ceil(high.x() + margin_px) + 1, all.right)),
          std::min(all.bottom, clamped(std::ceil(high.y() + margin_px) + 1, all.bottom))};
}

}  // namespace stevedore::world
