// The ray of every pixel, computed once for a lens.
#pragma once

#include <vector>

#include "geometry/camera_model.hpp"

namespace stevedore::world {

/// How a pixel's ray (x, y, 1) changes from one pixel to the next, to the right (u) and down (v).
struct RaySlopes {
  float xu, xv, yu, yv;
};

struct LensRays {
  int width_px = 0;
  int height_px = 0;
  std::vector<float> x, y;  ///< of the ray (x, y, 1) in camera axes through each pixel's centre, by rows
  float widest = 0;         ///< largest |(x, y)| in the image
  float pixel_rad = 0;      ///< angle that a pixel spans in the middle of the image

  [[nodiscard]] const float* row_x(int v) const {
    return x.data() + static_cast<std::ptrdiff_t>(v) * width_px;
  }
  [[nodiscard]] const float* row_y(int v) const {
    return y.data() + static_cast<std::ptrdiff_t>(v) * width_px;
  }
  [[nodiscard]] RaySlopes slopes(int u, int v) const;
};

LensRays rays_of(const CameraModel& lens);

/// Whether both take every pixel's ray alike.
bool same_rays(const CameraModel& a, const CameraModel& b);

}  // namespace stevedore::world
