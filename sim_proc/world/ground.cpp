#include "sim_proc/world/ground.hpp"

#include <array>
#include <cmath>

#include "sim_proc/world/surface.hpp"

namespace stevedore::world {
namespace {

using Eigen::Vector3f;

float squared(float x) {
  return x * x;
}

/// With one division; Eigen's normalized has three.
Vector3f unit(const Vector3f& v) {
  return v * (1 / std::sqrt(v.squaredNorm()));
}

/// x^(2^times)
float squared_times(float x, int times) {
  for (int i = 0; i < times; ++i) x *= x;
  return x;
}

/// Calls each(u) for the row's pixels, focus(pixel_m) before each block of them.
template <typename Focus, typename Each>
void in_blocks(const PlaneView& plane, const PlaneRow& row, const Focus& focus, const Each& each) {
  for (int begin = row.first; begin < row.last; begin += focus_px) {
    const int end = std::min(begin + focus_px, row.last);
    focus(plane.pixel_m(std::abs(row.depth_m[static_cast<size_t>((begin + end) / 2)])));
    for (int u = begin; u < end; ++u) each(static_cast<size_t>(u));
  }
}

/// Old tarmac: repaired joints run through it, and a worn line every lane.
void lay_tarmac(const Surroundings& surroundings, const Textures& textures, const PlaneView& plane,
                PlaneRow& row) {
  lay_ground(surroundings.surface, textures, plane, row);
  constexpr float crack_texel_m = 0.05F, lane_m = 7.5F, line_half_m = 0.07F;
  const TexturePlace place(surroundings.surface.texture);
  Texture::Level cracks{}, worn{};
  float pixel_m = 0;
  const auto focus = [&](float size_m) {
    pixel_m = size_m;
    cracks = textures.ridges.level_for(size_m / crack_texel_m);
    worn = textures.patches.level_for(size_m / wear_texel_m);
  };
  in_blocks(plane, row, focus, [&](size_t u) {
    const float x = place.cosine * row.x_m[u] + place.sine * row.y_m[u] + place.x;
    const float y = place.cosine * row.y_m[u] - place.sine * row.x_m[u] + place.y;
    const float crack = cracks.at(x * (1 / crack_texel_m), y * (1 / crack_texel_m));
    const float dark = 1 - 0.55F * std::max(0.0F, crack);
    const float lane = y / lane_m, off = std::abs(lane - std::round(lane)) * lane_m;
    float line = coverage_at((line_half_m - off) / std::max(pixel_m, 1e-6F));
    if (line > 0) line *= 0.7F * (0.6F + 0.4F * worn.at(x * (1 / wear_texel_m), y * (1 / wear_texel_m)));
    for (auto* channel : {&row.red, &row.green, &row.blue}) {
      float& value = (*channel)[u];
      value = std::lerp(value * dark, 0.55F, line);
    }
  });
}

/// Blades in tufts, here and there dry.
void lay_grass(const Surroundings& surroundings, const Textures& textures, const PlaneView& plane,
               PlaneRow& row) {
  constexpr float blade_texel_m = 0.006F, tuft_texel_m = 0.02F;
  const Surface& surface = surroundings.surface;
  const TexturePlace place(surface.texture);
  Texture::Level blades{}, tufts{}, dry{};
  const auto focus = [&](float pixel_m) {
    blades = textures.grain.level_for(pixel_m / blade_texel_m);
    tufts = textures.grain.level_for(pixel_m / tuft_texel_m);
    dry = textures.patches.level_for(pixel_m / patch_texel_m / 1.7F);
  };
  in_blocks(plane, row, focus, [&](size_t u) {
    const float x = place.cosine * row.x_m[u] + place.sine * row.y_m[u];
    const float y = place.cosine * row.y_m[u] - place.sine * row.x_m[u];
    const float blade = blades.at(x * (1 / blade_texel_m), y * (0.5F / blade_texel_m));
    const float tuft = tufts.at(x * (1 / tuft_texel_m) + place.x, y * (1 / tuft_texel_m));
    const float straw = dry.at(y * (0.6F / patch_texel_m) + place.y, x * (0.6F / patch_texel_m));
    const float tone = std::max(0.1F, 1 + surface.grain * (3.6F * blade + 2.2F * tuft + 0.9F * straw));
    const float yellow = std::max(0.0F, straw) * 0.5F;
    row.red[u] = surface.colour[0] * tone * (1 + 1.2F * yellow);
    row.green[u] = surface.colour[1] * tone * (1 + 0.3F * yellow);
    row.blue[u] = surface.colour[2] * tone;
  });
}

/// Two trains of waves that cross each other. Body colour under a mirror of the sky (Schlick 1994), glints of
/// the sun where a slope throws it into the eye.
class Water {
 public:
  Water(const Surroundings& surroundings, const Light& light, const Textures& textures,
        const PlaneView& plane)
      : light_(light),
        textures_(textures),
        to_sun_(light.to_sun_ned.cast<float>()),
        eye_(plane.local().eye),
        body_(surroundings.surface.colour),
        roughness_(surroundings.surface.grain) {
    constexpr std::array<double, 2> speed_mps = {1.1, 0.5};
    for (size_t train = 0; train < 2; ++train) {
      const double tile_m = static_cast<double>(texel_m[train]) * Texture::size;
      moved_m_[train] = static_cast<float>(std::fmod(speed_mps[train] * surroundings.wave_phase_s, tile_m));
    }
  }

  void focus(float pixel_m) {
    for (size_t train = 0; train < 2; ++train) {
      along_[train] = textures_.slope_x.level_for(pixel_m / texel_m[train]);
      across_[train] = textures_.slope_y.level_for(pixel_m / texel_m[train]);
    }
  }

  void lay(size_t u, PlaneRow& row) const {
    const Vector3f normal = normal_at(row.x_m[u], row.y_m[u]);
    const Vector3f from_eye = unit(Vector3f(row.x_m[u], row.y_m[u], 0) - eye_);
    const float facing = std::clamp(-from_eye.dot(normal), 0.0F, 1.0F);
    const Vector3f mirrored = from_eye + 2 * facing * normal;
    const float miss = 1 - facing, fresnel = 0.02F + 0.98F * squared(squared(miss)) * miss;
    const float to_sun = mirrored.dot(to_sun_);
    constexpr float in_reach = 0.9F;  // nothing is left of its 256th power
    const float glint = to_sun > in_reach ? squared_times(to_sun, 8) : 0.0F;  // a few degrees wide
    const Vector3f glow = sky_light(light_, mirrored) * fresnel + light_.sun * (1.5F * glint * row.sun[u]);
    row.red[u] = body_[0];
    row.green[u] = body_[1];
    row.blue[u] = body_[2];
    row.glow_red[u] = glow[0];
    row.glow_green[u] = glow[1];
    row.glow_blue[u] = glow[2];
  }

 private:
  static constexpr std::array<float, 2> texel_m = {0.045F, 0.011F};  // trains repeat after 11.5 m and 2.8 m

  [[nodiscard]] Vector3f normal_at(float x_m, float y_m) const {
    constexpr float c = 0.6F, s = 0.8F;  // the second train's way, 53 degrees off the first's
    const float x0 = (x_m - moved_m_[0]) / texel_m[0], y0 = y_m / texel_m[0];
    const float x1 = (c * x_m + s * y_m - moved_m_[1]) / texel_m[1], y1 = (c * y_m - s * x_m) / texel_m[1];
    const float a0 = along_[0].at(x0, y0), c0 = across_[0].at(x0, y0);
    const float a1 = along_[1].at(x1, y1), c1 = across_[1].at(x1, y1);
    constexpr float second = 0.7F;  // its steepness
    const float slope_x = a0 + second * (c * a1 - s * c1), slope_y = c0 + second * (s * a1 + c * c1);
    return unit({roughness_ * slope_x, roughness_ * slope_y, -1});
  }

  const Light& light_;
  const Textures& textures_;
  Vector3f to_sun_, eye_, body_;
  float roughness_;
  std::array<float, 2> moved_m_{};
  std::array<Texture::Level, 2> along_{}, across_{};
};

void lay_water(const Surroundings& surroundings, const Light& light, const Textures& textures,
               const PlaneView& plane, PlaneRow& row) {
  Water water(surroundings, light, textures, plane);
  in_blocks(
      plane, row, [&](float pixel_m) { water.focus(pixel_m); }, [&](size_t u) { water.lay(u, row); });
}

}  // namespace

void lay_surroundings(const Surroundings& surroundings, const Light& light, const Textures& textures,
                      const PlaneView& plane, PlaneRow& row) {
  switch (surroundings.kind) {
    case Surroundings::Kind::tarmac:
      return lay_tarmac(surroundings, textures, plane, row);
    case Surroundings::Kind::grass:
      return lay_grass(surroundings, textures, plane, row);
    case Surroundings::Kind::water:
      return lay_water(surroundings, light, textures, plane, row);
  }
}

void add_gloss(float gloss, const Light& light, const Vector3f& to_sun_local, const PlaneView& plane,
               PlaneRow& row) {
  if (gloss <= 0) return;
  const Vector3f eye = plane.local().eye;
  for (int column = row.first; column < row.last; ++column) {
    const auto u = static_cast<size_t>(column);
    // Blinn (1977): the normal, -z, against the middle between sun and eye
    const Vector3f to_eye = unit(eye - Vector3f(row.x_m[u], row.y_m[u], 0));
    const float along_normal = std::max(0.3F, -unit(to_eye + to_sun_local).z());  // 0.3^32 is nothing
    const float sheen = 0.6F * gloss * squared_times(along_normal, 5) * row.sun[u];
    row.glow_red[u] += sheen * light.sun[0];
    row.glow_green[u] += sheen * light.sun[1];
    row.glow_blue[u] += sheen * light.sun[2];
  }
}

void light_plane(const Light& light, float sun_cosine, PlaneRow& row) {
  const Vector3f sun = light.sun * std::max(0.0F, sun_cosine), sky = light.sky;
  const float *sun_share = row.sun.data(), *sky_share = row.sky.data();
  const auto shine = [&](std::vector<float>& channel, const std::vector<float>& glow, int c) {
    float* value = channel.data();
    const float *mirrored = glow.data(), from_sun = sun[c], from_sky = sky[c];
    for (int u = row.first; u < row.last; ++u)
      value[u] = value[u] * (from_sun * sun_share[u] + from_sky * sky_share[u]) + mirrored[u];
  };
  shine(row.red, row.glow_red, 0);
  shine(row.green, row.glow_green, 1);
  shine(row.blue, row.glow_blue, 2);
}

Vector3f sky_light(const Light& light, const Vector3f& direction_ned) {
  const float up = std::clamp(-direction_ned.z(), 0.0F, 1.0F);
  // paler towards the horizon; the mean over the upper half is the light that falls on the ground
  return light.sky * (1.5F - 0.75F * up);
}

}  // namespace stevedore::world
