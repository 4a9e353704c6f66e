#include "sim_proc/world/paints.hpp"

#include <array>
#include <cmath>

namespace stevedore::world {
namespace {

using Eigen::Vector3f;

constexpr float visible_luminance = 0.2F, visible_colour = 0.25F;

/// Of a ring that is two pixels wide, half of whose chroma a camera's blur takes.
constexpr float clear_colour = 0.33F;

/// What the levels of an sRGB image are about proportional to.
Vector3f levels_of(const Vector3f& light) {
  return light.array().max(0.0F).pow(1 / 2.2F);
}

float luma(const Vector3f& levels) {
  return levels.dot(Vector3f(0.299F, 0.587F, 0.114F));  // ITU-R BT.601
}

template <size_t N>
Vector3f pick(const std::array<Vector3f, N>& palette, Dice& dice) {
  // no two pots of paint are alike
  const auto index = static_cast<size_t>(dice.whole(0, static_cast<int>(N) - 1));
  const auto lighter = static_cast<float>(dice.uniform(0.85, 1.15));
  Vector3f colour = palette[index] * lighter;
  for (int c = 0; c < 3; ++c) colour[c] *= static_cast<float>(dice.uniform(0.9, 1.1));
  return colour.cwiseMin(0.9F).cwiseMax(0.01F);
}

const std::array<Vector3f, 9>& deck_palette() {
  static const std::array<Vector3f, 9> palette = {
      Vector3f(0.10F, 0.10F, 0.11F),  // anti-slip, black
      Vector3f(0.20F, 0.20F, 0.21F),  // grey
      Vector3f(0.33F, 0.33F, 0.32F),  // light grey
      Vector3f(0.05F, 0.14F, 0.08F),  // green
      Vector3f(0.22F, 0.07F, 0.05F),  // oxide red
      Vector3f(0.26F, 0.17F, 0.10F),  // planks
      Vector3f(0.06F, 0.11F, 0.22F),  // blue
      Vector3f(0.45F, 0.43F, 0.38F),  // concrete
      Vector3f(0.30F, 0.22F, 0.06F),  // ochre
  };
  return palette;
}

const std::array<Vector3f, 8>& mark_palette() {
  static const std::array<Vector3f, 8> palette = {
      Vector3f(0.80F, 0.80F, 0.78F),  // white
      Vector3f(0.75F, 0.73F, 0.70F),  // old white
      Vector3f(0.75F, 0.52F, 0.04F),  // yellow
      Vector3f(0.70F, 0.22F, 0.03F),  // orange
      Vector3f(0.48F, 0.04F, 0.04F),  // red
      Vector3f(0.04F, 0.10F, 0.42F),  // blue
      Vector3f(0.04F, 0.30F, 0.10F),  // green
      Vector3f(0.03F, 0.03F, 0.03F),  // black
  };
  return palette;
}

}  // namespace

Contrast contrast_between(const Vector3f& a, const Vector3f& b) {
  const Vector3f la = levels_of(a), lb = levels_of(b);
  const float ya = luma(la), yb = luma(lb);
  const Vector3f chroma = (la.array() - ya) - (lb.array() - yb);
  return {std::abs(ya - yb), std::hypot(chroma[0], chroma[2])};
}

bool differ_visibly(const Vector3f& a, const Vector3f& b) {
  const Contrast contrast = contrast_between(a, b);
  return contrast.luminance > visible_luminance || contrast.colour > visible_colour;
}

Vector3f draw_deck_colour(Dice& dice) {
  return pick(deck_palette(), dice);
}

Vector3f draw_mark_colour(const Vector3f& deck, Dice& dice) {
  const bool by_colour = dice.chance(1.0 / 7);
  constexpr int most_draws = 200;
  for (int i = 0; i < most_draws; ++i) {
    const Vector3f colour = pick(mark_palette(), dice);
    const Contrast contrast = contrast_between(deck, colour);
    const bool fits = by_colour ? contrast.luminance < visible_luminance && contrast.colour > clear_colour
                                : contrast.luminance > visible_luminance;
    if (fits) return colour;
  }
  // no paint of the deck's own luminance suits it: white does on all but a pale deck, black there
  return luma(levels_of(deck)) < 0.6F ? mark_palette().front() : mark_palette().back();
}

Vector3f draw_cloth_colour(Dice& dice) {
  static const std::array<Vector3f, 8> palette = {
      Vector3f(0.04F, 0.05F, 0.09F), Vector3f(0.05F, 0.05F, 0.05F), Vector3f(0.20F, 0.19F, 0.17F),
      Vector3f(0.75F, 0.28F, 0.03F), Vector3f(0.60F, 0.70F, 0.05F), Vector3f(0.35F, 0.05F, 0.05F),
      Vector3f(0.10F, 0.16F, 0.32F), Vector3f(0.60F, 0.60F, 0.58F)};
  return pick(palette, dice);
}

Vector3f draw_bucket_colour(const Vector3f& deck, Dice& dice) {
  static const std::array<Vector3f, 7> palette = {
      Vector3f(0.70F, 0.70F, 0.68F), Vector3f(0.70F, 0.50F, 0.05F), Vector3f(0.05F, 0.12F, 0.40F),
      Vector3f(0.40F, 0.40F, 0.41F), Vector3f(0.50F, 0.06F, 0.04F), Vector3f(0.05F, 0.05F, 0.05F),
      Vector3f(0.05F, 0.28F, 0.12F)};
  for (;;) {
    const Vector3f colour = pick(palette, dice);
    if (differ_visibly(deck, colour)) return colour;
  }
}

Surface make_surface(const Vector3f& colour, double grain, double wear, Dice& dice) {
  Surface surface;
  surface.colour = colour;
  surface.grain = static_cast<float>(grain);
  surface.wear = static_cast<float>(wear);
  surface.texture = static_cast<std::uint32_t>(dice.next() >> 32);
  return surface;
}

}  // namespace stevedore::world
