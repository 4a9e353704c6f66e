// What stands and lies on a deck and is not cargo.
#pragma once

#include "sim_proc/world/deck_marks.hpp"

namespace stevedore::world {

/// Somebody of six capsules, standing at a place of the deck's axes.
std::vector<Capsule> draw_person(const Eigen::Vector2d& at_deck_m, Dice& dice);

/// A rope that somebody dropped.
Strand draw_lying_rope(const Eigen::Vector2d& half_size_m, Dice& dice);

Scenery::OnDeck draw_clutter(int deck, const Plan& plan, double circle_radius_m, Dice& dice);

}  // namespace stevedore::world
