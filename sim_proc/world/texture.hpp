// Noise that repeats without a seam, drawn once, with smaller versions for where it is far away (mip levels,
// Williams 1983), so that it never aliases.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace stevedore::world {

class Texture {
 public:
  static constexpr int size = 256;  ///< texels on each side of the finest level: 64 KiB, stays in the cache
  static constexpr int levels = 9;  ///< down to 1 x 1

  /// values: size x size, scaled so that they fit into +-1.
  explicit Texture(const std::vector<float>& values);

  /// One level, to be read at places given in texels of level 0.
  struct Level {
    const std::int8_t* texels;
    int mask;
    int shift;
    float scale;
    bool magnified;  ///< a texel is larger than a pixel

    /// Bilinear where texels would be seen; else the texel itself.
    [[nodiscard]] float at(float x, float y) const {
      const float u = x * scale, v = y * scale;
      int i = static_cast<int>(u), j = static_cast<int>(v);
      i -= u < static_cast<float>(i);
      j -= v < static_cast<float>(j);
      if (!magnified) return static_cast<float>(texels[((j & mask) << shift) + (i & mask)]) * (1.0F / 127);
      const float p = u - static_cast<float>(i), q = v - static_cast<float>(j);
      const int left = i & mask, right = (i + 1) & mask, above = (j & mask) << shift,
                below = ((j + 1) & mask) << shift;
      const float t00 = texels[above + left], t01 = texels[above + right], t10 = texels[below + left],
                  t11 = texels[below + right];
      const float top = t00 + p * (t01 - t00), bottom = t10 + p * (t11 - t10);
      return (top + q * (bottom - top)) * (1.0F / 127);
    }
  };

  /// For pixels that span so many texels of level 0.
  [[nodiscard]] Level level_for(float texels_per_pixel) const;

 private:
  std::array<std::vector<std::int8_t>, levels> texels_;
};

/// What surfaces are made of. grain: fine, deviation 1/3. patches: coarse and fine mixed, evenly spread over
/// +-1, so that the share of it over a threshold is known. ridges: near +1 on a net of thin lines. slope_x,
/// slope_y: of waves, deviation 1/3.
struct Textures {
  Texture grain, patches, ridges, slope_x, slope_y;
};

Textures draw_textures();

}  // namespace stevedore::world
