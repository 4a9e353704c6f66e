// What there is to stand on.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim_proc/world/rigid.hpp"

namespace stevedore::world {

/// A deck as what things stand on: its upper side is z = 0 of its axes (x forward, y right, z down).
struct DeckFloor {
  Rigid rigid;
  Eigen::Vector2d half_size_m;
};

/// All that there is at one instant.
struct Floor {
  std::vector<DeckFloor> decks;
  bool water = false;  ///< the surroundings, at world z = 0: water, or firm ground
};

struct Footing {
  int deck = -1;  ///< index; -1: the surroundings
  Rigid rigid;    ///< its upper side is z = 0

  [[nodiscard]] Eigen::Vector3d up_ned() const { return rigid.ned_from_local * -Eigen::Vector3d::UnitZ(); }
  /// Along its normal; negative below its upper side.
  [[nodiscard]] double height_of(const Eigen::Vector3d& point_ned_m) const {
    return -rigid.to_local(point_ned_m).z();
  }
};

/// The deck over whose area the point is, else the surroundings. A point further than `deepest_m` below a
/// deck's upper side is beside or under it.
Footing footing_below(const Floor& floor, const Eigen::Vector3d& point_ned_m);

/// Half of a deck's thickness: what has sunk in less than that came from above.
constexpr double deepest_m = 0.25;

}  // namespace stevedore::world
