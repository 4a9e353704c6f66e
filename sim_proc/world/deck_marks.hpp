// What is painted on a platform: the four circles, and all that is not meant for us.
#pragma once

#include <optional>
#include <vector>

#include "sim_proc/world/dice.hpp"
#include "sim_proc/world/scenery.hpp"

namespace stevedore::world {

/// Where the circles of a layout are, and a deck that holds them.
struct Plan {
  Eigen::Vector2d half_size_m;
  std::vector<Eigen::Vector2d> slots_deck_m;
};
Plan draw_plan(Layout layout, double circle_radius_m, Dice& dice);

/// A round thing is mistaken for a circle if its radius is this near to the circle's, as a share.
constexpr double circle_like = 0.2;

/// A radius that nobody takes for a circle's.
double draw_other_radius(double circle_radius_m, double lowest_m, double highest_m, Dice& dice);

/// A place on the deck where something of that radius lies clear of the circles, if one is found.
std::optional<Eigen::Vector2d> draw_free_place(const Plan& plan, double circle_radius_m, double radius_m,
                                               Dice& dice);

/// Circles, and around, between and in them what else is painted. clutter: false for the circles alone.
std::vector<Mark> draw_marks(const Plan& plan, double circle_radius_m, const Surface& ground, bool clutter,
                             Dice& dice);

}  // namespace stevedore::world
