// Finds a platform's layout among circles of which nothing is known yet.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "platform/slot_layout.hpp"

namespace stevedore {

struct LayoutMatch {
  SlotLayout layout;  ///< to scale
  Eigen::Vector3d center_m;
  double heading_rad = 0;  ///< up to the layout's periods
  std::vector<std::pair<std::size_t, std::size_t>> slots_and_circles;
  double rms_m = 0;  ///< of the distances in the plane
};

/// All ways in which a layout lies on at least three of the circles (a layout to be scaled: on all its
/// slots), of those that use the most circles. Circles: centres along NED's axes. Ways that differ by the
/// layout's own symmetry count once. Best fit first. scalable: the layout has unit spacing and any size from
/// circles that nearly touch to a deck of ten metres.
std::vector<LayoutMatch> match_layout(const SlotLayout& layout, bool scalable,
                                      const std::vector<Eigen::Vector3d>& circles_m);

}  // namespace stevedore
