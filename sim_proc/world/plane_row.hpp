// A run of pixels of one row that look at one plane: where they meet it, what it is painted with, and how
// much light falls on it.
#pragma once

#include <vector>

#include "sim_proc/world/view.hpp"

namespace stevedore::world {

/// Arrays are indexed by the pixel's column; first..last-1 are in use.
struct PlaneRow {
  int v = 0, first = 0, last = 0;
  std::vector<float> depth_m, x_m, y_m;  ///< where the ray meets the plane z = 0 of the local axes
  std::vector<float> red, green, blue;   ///< reflectance
  std::vector<float> sun, sky;           ///< share of each that reaches the surface
  std::vector<float> glow_red, glow_green, glow_blue;  ///< mirrored light, beside what the paint scatters
  std::vector<float> cover;                            ///< share of the pixel

  void resize(int width) {
    for (auto* array :
         {&depth_m, &x_m, &y_m, &red, &green, &blue, &sun, &sky, &glow_red, &glow_green, &glow_blue, &cover})
      array->resize(static_cast<size_t>(width));
  }
};

/// The plane z = 0 of a rigid thing.
class PlaneView {
 public:
  PlaneView(const View& view, const Rigid& rigid) : local_(view, rigid), rays_(view.rays) {}

  [[nodiscard]] bool from_above() const { return local_.eye.z() < 0; }
  [[nodiscard]] const LocalView& local() const { return local_; }
  [[nodiscard]] const LensRays& rays() const { return rays_; }

  /// Fills depth, x and y; where a ray does not meet the plane the depth is negative or infinite.
  void meet(PlaneRow& row) const;
  /// Metres of the plane that a pixel spans at that depth when looking straight at it.
  [[nodiscard]] float pixel_m(float depth_m) const { return depth_m * rays_.pixel_rad; }
  /// Share of the pixel at column u on the positive side of an edge on the plane: signed distance of its
  /// centre, whose gradient on the plane is (gx, gy), unit. To first order, exact on the edge.
  [[nodiscard]] float coverage(const PlaneRow& row, int u, float distance_m, float gx, float gy) const;

 private:
  LocalView local_;
  const LensRays& rays_;
};

}  // namespace stevedore::world
