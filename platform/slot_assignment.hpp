// Which circle of a frame is which slot of a deck that is known well enough.
#pragma once

#include <vector>

#include "platform/deck_motion.hpp"
#include "platform/deck_sight.hpp"
#include "platform/slot_layout.hpp"

namespace stevedore {

/// A circle of a frame along NED's axes: the poses that its image allows, each with its probability.
struct CircleCandidates {
  std::vector<CircleView> views;
  std::vector<double> probability;
};

struct SlotMatch {
  std::size_t slot = 0;
  std::size_t circle = 0;
  std::size_t view = 0;
};

/// What a deck can be told by; the most that assignment can handle, whose table has a row for each set of
/// slots.
constexpr std::size_t fewest_slots = 3, most_slots = 8;

/// Global assignment: each slot at most one circle and each circle at most one slot, so that the sum of
/// squared normalised distances (centre, normal, and -2 log of the pose's probability) is least; a circle
/// beyond the gate of every slot is none. By slot.
std::vector<SlotMatch> assign_slots(const DeckState& state, const SlotLayout& layout,
                                    const Eigen::Vector3d& aircraft_odometry_m, double attitude_variance_rad2,
                                    const std::vector<CircleCandidates>& circles);

/// The slot known worst: standard deviation along its worst direction in the plane, m.
double worst_slot_sigma_m(const DeckState& state, const SlotLayout& layout);

}  // namespace stevedore
