// Which circles of a frame lie on one plane, and that plane.
#pragma once

#include <vector>

#include "pose_proc/circle_pose.hpp"
#include "pose_proc/plane_fit.hpp"

namespace stevedore {

/// A painted circle as it was solved alone. The edges in `mark` are those of the joint fit. Odds are of the
/// first solution.
struct LoneCircle {
  std::array<CircleSolution, 2> solutions;
  PlaneMark mark;
  double ring_log_odds = 0;     ///< by its inner edge, which the joint fit uses again
  double outside_log_odds = 0;  ///< by what is not in the image
};

/// Circles on one plane. Against it stands the best other plane that the same circles could share.
struct Deck {
  struct Member {
    std::size_t circle = 0;    ///< index of the LoneCircle
    std::size_t solution = 0;  ///< which of its two solutions this is
    CircleSolution joint;      ///< the circle as the joint fit has it
  };
  std::vector<Member> members;
  double log_odds = 0;  ///< of this plane over the other: image and expectation together
};

/// Decks of at least two circles each, the one with most agreement first; no circle is on two.
std::vector<Deck> find_decks(const std::vector<LoneCircle>& circles, const ExpectedNormal& expected);

}  // namespace stevedore
