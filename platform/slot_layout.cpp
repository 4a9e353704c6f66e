#include "platform/slot_layout.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace stevedore {
namespace {

constexpr double same_place = 0.05;  // of the spacing; paint is laid out better than that

std::size_t nearest(const std::vector<Eigen::Vector2d>& places_m, const Eigen::Vector2d& place_m) {
  const auto nearer = [&](const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
    return (a - place_m).squaredNorm() < (b - place_m).squaredNorm();
  };
  return static_cast<std::size_t>(std::min_element(places_m.begin(), places_m.end(), nearer) -
                                  places_m.begin());
}

bool repeats_when_turned(const SlotLayout& layout, double turn_rad) {
  const Eigen::Rotation2Dd turn(turn_rad);
  return std::all_of(layout.slots_m.begin(), layout.slots_m.end(), [&](const Eigen::Vector2d& slot_m) {
    const Eigen::Vector2d moved_m = turn * slot_m;
    return (layout.slots_m[nearest(layout.slots_m, moved_m)] - moved_m).norm() <
           same_place * layout.spacing_m();
  });
}

}  // namespace

int SlotLayout::periods() const {
  return static_cast<int>(std::lround(2 * std::numbers::pi / period_rad));
}

double SlotLayout::spacing_m() const {
  double least_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < size(); ++i)
    for (std::size_t j = 0; j < i; ++j) least_m = std::min(least_m, (slots_m[i] - slots_m[j]).norm());
  return least_m;
}

std::size_t SlotLayout::turned(std::size_t i, int periods) const {
  return nearest(slots_m, Eigen::Rotation2Dd(periods * period_rad) * slots_m[i]);
}

SlotLayout SlotLayout::scaled(double factor) const {
  SlotLayout out = *this;
  for (Eigen::Vector2d& slot_m : out.slots_m) slot_m *= factor;
  return out;
}

SlotLayout square_layout(double spacing_m) {
  const double half_m = spacing_m / 2;
  return layout_of({{half_m, -half_m}, {half_m, half_m}, {-half_m, half_m}, {-half_m, -half_m}});
}

SlotLayout row_layout(double spacing_m) {
  std::vector<Eigen::Vector2d> slots_m;
  for (const double place : {1.5, 0.5, -0.5, -1.5}) slots_m.emplace_back(place * spacing_m, 0);
  return layout_of(std::move(slots_m));
}

SlotLayout layout_of(std::vector<Eigen::Vector2d> slots_m) {
  SlotLayout layout{std::move(slots_m)};
  for (int parts = static_cast<int>(layout.size()); parts > 1; --parts) {
    const double turn_rad = 2 * std::numbers::pi / parts;
    if (!repeats_when_turned(layout, turn_rad)) continue;
    layout.period_rad = turn_rad;
    break;
  }
  return layout;
}

std::vector<SlotLayout> allowed_layouts(const PlatformSettings& settings) {
  if (!settings.slots.empty()) {
    std::vector<Eigen::Vector2d> slots_m;
    for (const SlotPlace& place : settings.slots) slots_m.emplace_back(place.forward_m, place.right_m);
    return {layout_of(std::move(slots_m))};
  }
  if (settings.layout == "square") return {square_layout(settings.spacing_m)};
  if (settings.layout == "row") return {row_layout(settings.spacing_m)};
  return {square_layout(1), row_layout(1)};
}

}  // namespace stevedore
