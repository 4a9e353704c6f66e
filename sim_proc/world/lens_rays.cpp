#include "sim_proc/world/lens_rays.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/rectify.hpp"

namespace stevedore::world {
namespace {

bool same(const Pinhole& a, const Pinhole& b) {
  return a.width_px == b.width_px && a.height_px == b.height_px && a.matrix() == b.matrix();
}

Eigen::Vector2d ray_of(const CameraModel& lens, const Eigen::Vector2d& given_px) {
  if (lens.distortion == Distortion::none) return lens.given.unproject(given_px).head<2>();
  // a pixel that the lens model has no ray for (none of a calibrated lens) gets the pinhole's
  const auto rectified_px = undistort(lens, given_px);
  return rectified_px ? lens.rectified.unproject(*rectified_px).head<2>()
                      : lens.given.unproject(given_px).head<2>();
}

}  // namespace

RaySlopes LensRays::slopes(int u, int v) const {
  const int left = std::max(u - 1, 0), right = std::min(u + 1, width_px - 1);
  const int above = std::max(v - 1, 0), below = std::min(v + 1, height_px - 1);
  const float across = 1 / static_cast<float>(right - left), down = 1 / static_cast<float>(below - above);
  return {(row_x(v)[right] - row_x(v)[left]) * across, (row_x(below)[u] - row_x(above)[u]) * down,
          (row_y(v)[right] - row_y(v)[left]) * across, (row_y(below)[u] - row_y(above)[u]) * down};
}

LensRays rays_of(const CameraModel& lens) {
  LensRays rays;
  rays.width_px = lens.given.width_px;
  rays.height_px = lens.given.height_px;
  const auto pixels = static_cast<size_t>(rays.width_px) * static_cast<size_t>(rays.height_px);
  rays.x.reserve(pixels);
  rays.y.reserve(pixels);
  for (int v = 0; v < rays.height_px; ++v)
    for (int u = 0; u < rays.width_px; ++u) {
      const Eigen::Vector2f ray = ray_of(lens, Eigen::Vector2d(u, v)).cast<float>();
      rays.x.push_back(ray.x());
      rays.y.push_back(ray.y());
      rays.widest = std::max(rays.widest, ray.norm());
    }
  const RaySlopes middle = rays.slopes(rays.width_px / 2, rays.height_px / 2);
  rays.pixel_rad = std::sqrt(std::abs(middle.xu * middle.yv - middle.xv * middle.yu));
  return rays;
}

bool same_rays(const CameraModel& a, const CameraModel& b) {
  return same(a.given, b.given) && same(a.rectified, b.rectified) && a.distortion == b.distortion &&
         a.coefficients == b.coefficients;
}

}  // namespace stevedore::world
