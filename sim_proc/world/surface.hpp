// How a surface looks close up: its grain, its stains, the paint that is gone.
#pragma once

#include <cmath>

#include "sim_proc/world/plane_row.hpp"
#include "sim_proc/world/texture.hpp"

namespace stevedore::world {

/// Where in the textures a surface begins: from its seed, so that no two look alike.
struct TexturePlace {
  float x, y, cosine, sine;

  explicit TexturePlace(std::uint32_t seed) {
    const std::uint32_t hash = (seed ^ 0x5bd1e995U) * 2654435761U;  // Knuth's multiplicative hash
    x = static_cast<float>(hash & 255);
    y = static_cast<float>((hash >> 8) & 255);
    const float turn = static_cast<float>((hash >> 16) & 255) * (6.2831853F / 256);
    cosine = std::cos(turn);
    sine = std::sin(turn);
  }
};

/// Texel sizes, metres: grain repeats after 1 m, patches after 6 m, wear after 1.5 m.
constexpr float grain_texel_m = 0.004F, patch_texel_m = 0.023F, wear_texel_m = 0.006F;

/// A surface at points of a plane, at the detail that a pixel of that size can show.
class SurfaceSampler {
 public:
  SurfaceSampler(const Surface& surface, const Textures& textures)
      : place_(surface.texture), grain_share_(surface.grain), wear_(surface.wear), textures_(textures) {
    focus(0.001F);
  }

  /// Chooses the levels of detail.
  void focus(float pixel_m) {
    grain_ = textures_.grain.level_for(pixel_m / grain_texel_m);
    patches_ = textures_.patches.level_for(pixel_m / patch_texel_m);
    worn_ = textures_.patches.level_for(pixel_m / wear_texel_m);
    // a pixel that spans many patches shows their mean: the threshold widens with it
    wear_softness_ = 0.12F + 6 * pixel_m;
  }
  /// Factor of the colour.
  [[nodiscard]] float tone(float x_m, float y_m) const {
    const float x = place_.cosine * x_m + place_.sine * y_m, y = place_.cosine * y_m - place_.sine * x_m;
    const float fine = grain_.at(x * (1 / grain_texel_m) + place_.x, y * (1 / grain_texel_m) + place_.y);
    const float coarse = patches_.at(y * (1 / patch_texel_m) + place_.y, x * (1 / patch_texel_m));
    return std::max(0.05F, 1 + grain_share_ * (2.0F * fine + 0.8F * coarse));
  }
  /// Share of the paint that is still there.
  [[nodiscard]] float remaining(float x_m, float y_m) const {
    if (wear_ <= 0) return 1;
    const float patch = worn_.at(x_m * (1 / wear_texel_m) + place_.y, y_m * (1 / wear_texel_m) + place_.x);
    const float threshold = 1 - 2 * wear_;  // patches are evenly spread over +-1
    return std::clamp(0.5F + (threshold - patch) / wear_softness_, 0.0F, 1.0F);
  }

 private:
  TexturePlace place_;
  float grain_share_, wear_;
  const Textures& textures_;
  Texture::Level grain_{}, patches_{}, worn_{};
  float wear_softness_ = 0;
};

/// Pixels that share one choice of detail.
constexpr int focus_px = 16;

/// Paint laid over a plane's reflectance.
class Paint {
 public:
  Paint(const Surface& surface, const Textures& textures) : surface_(surface), sampler_(surface, textures) {}

  void lay(const PlaneView& plane, PlaneRow& row, int column, float share) {
    const auto u = static_cast<size_t>(column);
    const int block = column / focus_px;
    if (block != focused_) {
      sampler_.focus(plane.pixel_m(row.depth_m[u]));
      focused_ = block;
    }
    const float x = row.x_m[u], y = row.y_m[u], tone = sampler_.tone(x, y);
    share *= sampler_.remaining(x, y);
    row.red[u] += share * (surface_.colour[0] * tone - row.red[u]);
    row.green[u] += share * (surface_.colour[1] * tone - row.green[u]);
    row.blue[u] += share * (surface_.colour[2] * tone - row.blue[u]);
  }

 private:
  const Surface& surface_;
  SurfaceSampler sampler_;
  int focused_ = -1;
};

/// Reflectance of bare ground over the whole row.
inline void lay_ground(const Surface& surface, const Textures& textures, const PlaneView& plane,
                       PlaneRow& row) {
  SurfaceSampler sampler(surface, textures);
  for (int begin = row.first; begin < row.last; begin += focus_px) {
    const int end = std::min(begin + focus_px, row.last);
    sampler.focus(plane.pixel_m(std::abs(row.depth_m[static_cast<size_t>((begin + end) / 2)])));
    for (int column = begin; column < end; ++column) {
      const auto u = static_cast<size_t>(column);
      const float tone = sampler.tone(row.x_m[u], row.y_m[u]);
      row.red[u] = surface.colour[0] * tone;
      row.green[u] = surface.colour[1] * tone;
      row.blue[u] = surface.colour[2] * tone;
    }
  }
}

}  // namespace stevedore::world
