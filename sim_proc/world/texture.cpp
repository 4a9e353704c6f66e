#include "sim_proc/world/texture.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "sim_proc/world/dice.hpp"

namespace stevedore::world {
namespace {

constexpr int size = Texture::size;
constexpr auto pixels = static_cast<size_t>(size) * size;
using Field = std::vector<float>;

float& at(Field& field, int x, int y) {
  return field[static_cast<size_t>((y & (size - 1)) * size + (x & (size - 1)))];
}

/// Smooth noise on a lattice of `cell` texels (Perlin 1985's value noise, quintic blend).
void add_octave(Field& field, int cell, float weight, Dice& dice) {
  const int cells = size / cell;
  Field lattice(static_cast<size_t>(cells) * static_cast<size_t>(cells));
  for (float& value : lattice) value = static_cast<float>(dice.normal());
  const auto node = [&](int i, int j) {
    return lattice[static_cast<size_t>((j % cells) * cells + i % cells)];
  };
  const auto blend = [](float t) { return t * t * t * (t * (t * 6 - 15) + 10); };
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const int i = x / cell, j = y / cell;
      const float p = blend(static_cast<float>(x % cell) / static_cast<float>(cell));
      const float q = blend(static_cast<float>(y % cell) / static_cast<float>(cell));
      const float top = std::lerp(node(i, j), node(i + 1, j), p);
      at(field, x, y) += weight * std::lerp(top, std::lerp(node(i, j + 1), node(i + 1, j + 1), p), q);
    }
}

Field octaves(std::initializer_list<std::pair<int, float>> cells_and_weights, Dice& dice) {
  Field field(pixels);
  for (const auto& [cell, weight] : cells_and_weights) add_octave(field, cell, weight, dice);
  return field;
}

/// Mean 0, deviation 1/3: three deviations fit into +-1.
Field standardized(Field field) {
  const float mean = std::accumulate(field.begin(), field.end(), 0.0F) / static_cast<float>(pixels);
  float squares = 0;
  for (const float value : field) squares += (value - mean) * (value - mean);
  const float scale = 1 / (3 * std::sqrt(squares / static_cast<float>(pixels)));
  for (float& value : field) value = (value - mean) * scale;
  return field;
}

/// Replaces each value by its rank, from -1 to 1.
Field ranked(Field field) {
  std::vector<int> order(pixels);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
    return field[static_cast<size_t>(a)] < field[static_cast<size_t>(b)];
  });
  for (size_t rank = 0; rank < pixels; ++rank)
    field[static_cast<size_t>(order[rank])] = 2 * static_cast<float>(rank) / static_cast<float>(pixels) - 1;
  return field;
}

/// Near 1 where a wide smooth noise crosses zero, about 3 texels wide.
Field ridges(Dice& dice) {
  const Field wide = standardized(octaves({{64, 1.0F}, {32, 0.6F}, {16, 0.3F}, {8, 0.12F}}, dice));
  Field field(pixels);
  constexpr float width = 0.012F;
  std::transform(wide.begin(), wide.end(), field.begin(),
                 [](float value) { return 2 / (1 + (value / width) * (value / width)) - 1; });
  return field;
}

/// Slopes of a sum of waves that all fit the tile, most of them within 60 degrees of one way.
std::pair<Field, Field> wave_slopes(Dice& dice) {
  Field slope_x(pixels), slope_y(pixels);
  constexpr int waves = 28;
  for (int wave = 0; wave < waves; ++wave) {
    const double length = 4 + 24 * std::pow(dice.uniform(0, 1), 1.5);  // crests across the tile
    const double way = dice.normal(0.5);
    const int kx = static_cast<int>(std::lround(length * std::cos(way)));
    const int ky = static_cast<int>(std::lround(length * std::sin(way)));
    const double phase = dice.uniform(0, 2 * std::numbers::pi);
    const double slope = 1 / std::sqrt(std::hypot(kx, ky) + 1);
    for (int y = 0; y < size; ++y)
      for (int x = 0; x < size; ++x) {
        const double angle = 2 * std::numbers::pi * (kx * x + ky * y) / size + phase;
        const auto height = static_cast<float>(slope * std::cos(angle));
        at(slope_x, x, y) += static_cast<float>(kx) * height;
        at(slope_y, x, y) += static_cast<float>(ky) * height;
      }
  }
  return {standardized(slope_x), standardized(slope_y)};
}

std::vector<float> halved(const std::vector<float>& fine, int fine_size) {
  const int half = fine_size / 2;
  std::vector<float> coarse;
  coarse.reserve(static_cast<size_t>(half) * static_cast<size_t>(half));
  const auto texel = [&](int x, int y) { return fine[static_cast<size_t>(y * fine_size + x)]; };
  for (int y = 0; y < fine_size; y += 2)
    for (int x = 0; x < fine_size; x += 2)
      coarse.push_back((texel(x, y) + texel(x + 1, y) + texel(x, y + 1) + texel(x + 1, y + 1)) / 4);
  return coarse;
}

}  // namespace

Texture::Texture(const std::vector<float>& values) {
  std::vector<float> level = values;
  int level_size = size;
  for (auto& texels : texels_) {
    for (const float value : level)
      texels.push_back(static_cast<std::int8_t>(std::lround(127 * std::clamp(value, -1.0F, 1.0F))));
    if (level_size > 1) level = halved(level, level_size);
    level_size /= 2;
  }
}

Texture::Level Texture::level_for(float texels_per_pixel) const {
  // halved as long as a texel stays within a pixel, more than half of it; the last level is the mean
  const int wanted = texels_per_pixel >= 2 ? std::ilogb(texels_per_pixel) : 0;
  const int level = std::min(wanted, levels - 1), shift = levels - 1 - level;
  return {texels_[static_cast<size_t>(level)].data(), (1 << shift) - 1, shift,
          1 / static_cast<float>(1 << level), texels_per_pixel < 1};
}

Textures draw_textures() {
  Dice dice(1, "textures");
  const auto [slope_x, slope_y] = wave_slopes(dice);
  return {
      Texture(standardized(octaves({{1, 0.6F}, {2, 1.0F}, {4, 0.7F}, {8, 0.4F}}, dice))),
      Texture(ranked(octaves({{64, 1.0F}, {32, 0.8F}, {16, 0.6F}, {8, 0.5F}, {4, 0.4F}, {2, 0.3F}}, dice))),
      Texture(ridges(dice)), Texture(slope_x), Texture(slope_y)};
}

}  // namespace stevedore::world
