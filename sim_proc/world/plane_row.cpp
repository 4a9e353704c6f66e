#include "sim_proc/world/plane_row.hpp"

#include <cmath>

namespace stevedore::world {

void PlaneView::meet(PlaneRow& row) const {
  const Eigen::Matrix3f& m = local_.local_from_camera;
  const float ox = local_.eye.x(), oy = local_.eye.y(), oz = local_.eye.z();
  const float m00 = m(0, 0), m01 = m(0, 1), m02 = m(0, 2), m10 = m(1, 0), m11 = m(1, 1), m12 = m(1, 2),
              m20 = m(2, 0), m21 = m(2, 1), m22 = m(2, 2);
  const float *ray_x = rays_.row_x(row.v), *ray_y = rays_.row_y(row.v);
  float *depth = row.depth_m.data(), *x = row.x_m.data(), *y = row.y_m.data();
  for (int u = row.first; u < row.last; ++u) {
    const float rx = ray_x[u], ry = ray_y[u];
    const float t = -oz / (m20 * rx + m21 * ry + m22);
    depth[u] = t;
    x[u] = ox + t * (m00 * rx + m01 * ry + m02);
    y[u] = oy + t * (m10 * rx + m11 * ry + m12);
  }
}

float PlaneView::coverage(const PlaneRow& row, int u, float distance_m, float gx, float gy) const {
  const float t = row.depth_m[static_cast<size_t>(u)];
  // a pixel's corner is 0.7 px away; on a plane turned by 30 degrees, at the edge of a wide image, up to 3
  constexpr float far_px = 3.5F;
  if (std::abs(distance_m) > far_px * pixel_m(t)) return distance_m > 0 ? 1.0F : 0.0F;
  const Eigen::Matrix3f& m = local_.local_from_camera;
  const float rx = rays_.row_x(row.v)[u], ry = rays_.row_y(row.v)[u];
  const RaySlopes slope = rays_.slopes(u, row.v);
  const Eigen::Vector3f ray = m * Eigen::Vector3f(rx, ry, 1);
  const auto change = [&](float sx, float sy) {
    const Eigen::Vector3f turned = m.leftCols<2>() * Eigen::Vector2f(sx, sy);
    const float lengthened = turned.z() / ray.z();  // along the ray, to stay on the plane
    return t * (gx * (turned.x() - ray.x() * lengthened) + gy * (turned.y() - ray.y() * lengthened));
  };
  return coverage_of(distance_m, change(slope.xu, slope.yu), change(slope.xv, slope.yv));
}

}  // namespace stevedore::world
