#include "pose_proc/deck.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

namespace stevedore {
namespace {

/// Decks are boards: flat to this angle, and paint lies on them to this share of the range (radii that are
/// wrong by half a percent move neighbours apart by as much).
constexpr double flat_rad = 0.01;
constexpr double radius_share = 0.005;

/// 99.9 % of chi squared with the three degrees of freedom that a plane leaves a circle: what a circle costs
/// that is not on it.
constexpr double stranger_cost = 16.3;

/// Covariances of edges say half of the standard deviation at worst; what fits worse than that is no plane.
constexpr double most_chi_squared_share = 4;

double squared(double x) {
  return x * x;
}

/// How badly a solution of another circle agrees with the plane of this one: chi squared of three: two of the
/// normal, one of the distance of its centre.
double disagreement(const CircleSolution& plane, const CircleSolution& other) {
  const Eigen::Vector3d turn = other.normal_camera - plane.normal_camera;
  const Eigen::Matrix3d turn_noise = plane.normal_covariance_rad2 + other.normal_covariance_rad2 +
                                     squared(flat_rad) * Eigen::Matrix3d::Identity();
  const Eigen::Vector3d& n = plane.normal_camera;
  const Eigen::Vector3d apart_m = other.center_camera_m - plane.center_camera_m;
  const double off_noise = n.dot((plane.covariance_m2 + other.covariance_m2) * n) +
                           apart_m.dot(plane.normal_covariance_rad2 * apart_m) +
                           squared(radius_share * other.center_camera_m.norm());
  return turn.dot(turn_noise.inverse() * turn) + squared(n.dot(apart_m)) / off_noise;
}

/// One solution of one circle taken for the plane, and which of the others' go with it.
struct Hypothesis {
  std::size_t circle = 0, solution = 0;
  std::vector<std::size_t> members, sides;  ///< circles, and which solution of each
  double cost = 0;                          ///< twice the negative log-likelihood
};

double side_cost(double log_odds, std::size_t side) {
  return side == 0 ? 0 : 2 * log_odds;
}

Hypothesis hypothesis_of(const std::vector<LoneCircle>& circles, const std::vector<std::size_t>& left,
                         std::size_t circle, std::size_t solution, const ExpectedNormal& expected) {
  Hypothesis h{circle, solution, {}, {}, 0};
  const CircleSolution& plane = circles[circle].solutions[solution];
  h.cost = -2 * std::log(density(expected, plane.normal_camera, plane.normal_covariance_rad2));
  for (const std::size_t i : left) {
    std::size_t side = solution;
    double cost = 0;
    if (i != circle) {
      const std::array<double, 2> off{disagreement(plane, circles[i].solutions[0]),
                                      disagreement(plane, circles[i].solutions[1])};
      side = off[0] <= off[1] ? 0 : 1;
      cost = off[side];
    }
    h.cost += std::min(cost, stranger_cost) +
              side_cost(circles[i].ring_log_odds + circles[i].outside_log_odds, side);
    if (cost >= stranger_cost) continue;
    h.members.push_back(i);
    h.sides.push_back(side);
  }
  return h;
}

std::optional<PlaneFit> fit_of(const std::vector<LoneCircle>& circles, const Hypothesis& h) {
  std::vector<PlaneMark> marks;
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  // of the members, the better known ones weighing more
  for (std::size_t k = 0; k < h.members.size(); ++k) {
    const CircleSolution& s = circles[h.members[k]].solutions[h.sides[k]];
    marks.push_back(circles[h.members[k]].mark);
    marks.back().start_center_camera_m = s.center_camera_m;
    normal += s.normal_camera / (s.normal_covariance_rad2.trace() + squared(flat_rad));
  }
  return fit_plane(marks, normal.normalized());
}

/// A hypothesis once its circles were fitted together.
struct Solved {
  Hypothesis hypothesis;
  PlaneFit fit;
  double cost = 0;
};

std::optional<Solved> solve(const std::vector<LoneCircle>& circles, std::size_t count, const Hypothesis& h,
                            const ExpectedNormal& expected) {
  if (h.members.size() < 2) return std::nullopt;
  auto fit = fit_of(circles, h);
  if (!fit || fit->chi_squared > stranger_cost + most_chi_squared_share * fit->freedom) return std::nullopt;
  double cost = fit->chi_squared + stranger_cost * static_cast<double>(count - h.members.size()) -
                2 * std::log(density(expected, fit->normal_camera, fit->normal_covariance_rad2));
  for (std::size_t k = 0; k < h.members.size(); ++k)
    cost += side_cost(circles[h.members[k]].outside_log_odds, h.sides[k]);
  return Solved{h, std::move(*fit), cost};
}

/// Whether two hypotheses take a circle of both on different sides.
bool contrary(const Hypothesis& a, const Hypothesis& b) {
  for (std::size_t i = 0; i < a.members.size(); ++i)
    for (std::size_t j = 0; j < b.members.size(); ++j)
      if (a.members[i] == b.members[j] && a.sides[i] != b.sides[j]) return true;
  return false;
}

/// Where both fits ended in one plane, the other side of a circle is right only if the true normal is nearer
/// to it: more than half of the way off.
double against_mirrored(const std::vector<LoneCircle>& circles, const Solved& best) {
  const Eigen::Matrix3d noise =
      best.fit.normal_covariance_rad2 + squared(flat_rad) * Eigen::Matrix3d::Identity();
  double least = stranger_cost;
  for (std::size_t k = 0; k < best.hypothesis.members.size(); ++k) {
    const CircleSolution& other = circles[best.hypothesis.members[k]].solutions[1 - best.hypothesis.sides[k]];
    const Eigen::Vector3d halfway = (other.normal_camera - best.fit.normal_camera) / 2;
    least = std::min(least, halfway.dot(noise.inverse() * halfway));
  }
  return least;
}

Deck deck_of(const Solved& solved) {
  Deck deck;
  for (std::size_t k = 0; k < solved.hypothesis.members.size(); ++k)
    deck.members.push_back({solved.hypothesis.members[k],
                            solved.hypothesis.sides[k],
                            {solved.fit.center_camera_m[k], solved.fit.normal_camera,
                             solved.fit.covariance_m2[k], solved.fit.normal_covariance_rad2}});
  return deck;
}

/// The best plane among these circles, if two or more share one.
std::optional<Deck> best_deck(const std::vector<LoneCircle>& circles, const std::vector<std::size_t>& left,
                              const ExpectedNormal& expected) {
  std::vector<Hypothesis> all;
  for (const std::size_t i : left)
    for (std::size_t side = 0; side < 2; ++side)
      all.push_back(hypothesis_of(circles, left, i, side, expected));
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.cost < b.cost; });
  // circles that don't fit together after all must not keep others from it
  constexpr std::size_t most_tried = 8;
  std::optional<Solved> best;
  auto tried = all.begin();
  for (const auto end = all.begin() + static_cast<std::ptrdiff_t>(std::min(most_tried, all.size()));
       tried != end; ++tried)
    if ((best = solve(circles, left.size(), *tried, expected))) break;
  if (!best) return std::nullopt;
  Deck deck = deck_of(*best);
  const auto rival = std::find_if(tried, all.end(), [&](const Hypothesis& h) { return contrary(h, *tried); });
  if (rival == all.end()) {
    deck.log_odds = against_mirrored(circles, *best) / 2;
    return deck;
  }
  const auto other = solve(circles, left.size(), *rival, expected);
  if (!other) {
    // no plane of its own: what the circles said before they were fitted together is compared with the same
    deck.log_odds = (rival->cost - tried->cost) / 2;
    return deck;
  }
  if (other->cost < best->cost) {
    deck = deck_of(*other);
    deck.log_odds = (best->cost - other->cost) / 2;
    return deck;
  }
  const bool one_plane = (other->fit.normal_camera - best->fit.normal_camera).squaredNorm() <
                         best->fit.normal_covariance_rad2.trace() / 4;
  deck.log_odds = one_plane ? against_mirrored(circles, *best) / 2 : (other->cost - best->cost) / 2;
  return deck;
}

}  // namespace

std::vector<Deck> find_decks(const std::vector<LoneCircle>& circles, const ExpectedNormal& expected) {
  std::vector<Deck> decks;
  std::vector<std::size_t> left(circles.size());
  for (std::size_t i = 0; i < left.size(); ++i) left[i] = i;
  while (left.size() >= 2) {
    auto deck = best_deck(circles, left, expected);
    if (!deck) break;
    for (const Deck::Member& member : deck->members) std::erase(left, member.circle);
    decks.push_back(std::move(*deck));
  }
  return decks;
}

}  // namespace stevedore
