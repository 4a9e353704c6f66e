// Which ellipse of this frame is which ellipse followed so far.
#pragma once

#include <optional>
#include <vector>

#include "geometry/ellipse.hpp"

namespace stevedore {

/// Where an ellipse followed so far may be in this frame. There can be several such places for one track.
struct Expected {
  std::size_t track = 0;  ///< 0, 1, ...
  Ellipse ellipse;
  double unseen_s = 0;  ///< since it was last measured
};

struct AssociationGates {
  double radii = 1.0;            ///< farthest centre, in radii of the expected ellipse in that direction
  double radii_per_s = 0.5;      ///< growth of that limit while unseen: after 1 s still short of a neighbour
  double size_ratio = 1.2;       ///< largest change of sqrt(a b) from one frame to the next, either way
  double size_rate_per_s = 0.3;  ///< growth of that limit, of the logarithm, while unseen
};

/// Farthest distance at which an ellipse centred at `centre_px` may be the expected one.
double gate_px(const Expected& expected, const Eigen::Vector2d& centre_px, const AssociationGates& gates);

bool may_be(const Expected& expected, const Ellipse& found, const AssociationGates& gates);

/// How far one ellipse is from another in place, size and direction together (Givens and Shortt 1984,
/// distance of two normal distributions): the distance of the centres if the shapes are equal; sqrt(2) |r1 -
/// r2| for concentric circles. A circle's meaningless alpha does not matter.
double shape_distance_px(const Ellipse& one, const Ellipse& other);

/// For each of `tracks` tracks the index of the found ellipse that continues it, if any; each is used once.
/// The closest pair first: inside the gates that is as good as the best sum, because a gate of one radius is
/// less than half the way to a neighbour of the same size that does not overlap.
std::vector<std::optional<std::size_t>> associate(std::size_t tracks, const std::vector<Expected>& expected,
                                                  const std::vector<Ellipse>& found,
                                                  const AssociationGates& gates);

}  // namespace stevedore
