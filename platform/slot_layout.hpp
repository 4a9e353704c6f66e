// How the circles lie on a deck.
#pragma once

#include <Eigen/Core>
#include <numbers>
#include <vector>

#include "platform/platform_settings.hpp"

namespace stevedore {

/// Centres on the deck: forward, right of its middle. The layout repeats when it is turned by period_rad.
struct SlotLayout {
  std::vector<Eigen::Vector2d> slots_m;
  double period_rad = 2 * std::numbers::pi;

  [[nodiscard]] std::size_t size() const { return slots_m.size(); }
  [[nodiscard]] int periods() const;
  /// The smallest distance between two circles.
  [[nodiscard]] double spacing_m() const;
  /// Which slot lies where slot i comes to when the layout is turned by that many periods, clockwise.
  [[nodiscard]] std::size_t turned(std::size_t i, int periods) const;
  [[nodiscard]] SlotLayout scaled(double factor) const;
};

/// Clockwise as seen from above, from forward left.
SlotLayout square_layout(double spacing_m);
/// From the front to the back, along the heading.
SlotLayout row_layout(double spacing_m);
/// Any, about its own centroid's origin as given; its symmetry is found out.
SlotLayout layout_of(std::vector<Eigen::Vector2d> slots_m);

/// Those that the settings allow: one, or with `learn` a square and a row of unit spacing, to be scaled.
std::vector<SlotLayout> allowed_layouts(const PlatformSettings& settings);

}  // namespace stevedore
