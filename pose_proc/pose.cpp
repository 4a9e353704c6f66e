#include "pose_proc/pose.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "pose_proc/common_error.hpp"
#include "pose_proc/deck.hpp"
#include "pose_proc/metric_size.hpp"
#include "pose_proc/ring_pose.hpp"

namespace stevedore {
namespace {

/// A mark on the way to its pose. Odds are of the first of the pair.
struct Solving {
  CirclePair pair;
  LogOdds odds;
  double ring_log_odds = 0, beam_log_odds = 0;  ///< parts of odds.now
  std::optional<EdgeImage> inner;               ///< where it is this ring's
};

std::optional<Solving> solve_alone(const MarkImage& mark, double radius_m, const Pinhole& camera,
                                   const ExpectedNormal& expected, const PoseContext& context,
                                   const PoseSettings& settings) {
  const auto pair = conic_pose(mark.outer, camera, radius_m, expected);
  if (!pair) return std::nullopt;
  Solving solving{*pair, {}, 0, 0, {}};
  if (mark.inner)
    if (const auto ring = ring_pose(mark.outer, *mark.inner, camera, radius_m, pair->solutions)) {
      solving.pair.solutions = ring->solutions;
      solving.ring_log_odds = ring->log_odds;
      solving.inner = edge_image(*mark.inner, camera);
    }
  if (context.beam) solving.beam_log_odds = beam_log_odds(solving.pair.solutions, *context.beam);
  solving.odds.now =
      std::log(pair->likelihood[0] / pair->likelihood[1]) + solving.ring_log_odds + solving.beam_log_odds;
  if (mark.previous) {
    solving.odds.before = carried_over(solving.pair.solutions, *mark.previous, settings);
    solving.odds.elapsed_s = mark.previous->elapsed_s;
  }
  return solving;
}

/// Circles that were measured, of very many those of which most is seen: no deck has so many, and planes are
/// looked for among all of them, through each.
std::vector<std::size_t> deck_circles(const std::vector<MarkImage>& marks,
                                      const std::vector<std::optional<Solving>>& solving) {
  constexpr std::size_t most = 24;
  std::vector<std::size_t> circles;
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (solving[i] && marks[i].label == Label::circle && marks[i].measured) circles.push_back(i);
  if (circles.size() <= most) return circles;
  std::stable_sort(circles.begin(), circles.end(),
                   [&](std::size_t a, std::size_t b) { return marks[a].coverage > marks[b].coverage; });
  circles.resize(most);
  return circles;
}

/// Circles that agree on a plane get what it says. Returns each mark's deck, -1 for none.
std::vector<int> solve_decks(const std::vector<MarkImage>& marks,
                             std::vector<std::optional<Solving>>& solving, double radius_m,
                             const Pinhole& camera, const ExpectedNormal& expected) {
  std::vector<LoneCircle> circles;
  const std::vector<std::size_t> mark_of = deck_circles(marks, solving);
  for (const std::size_t i : mark_of)
    circles.push_back({solving[i]->pair.solutions,
                       {edge_image(marks[i].outer, camera), solving[i]->inner, radius_m, {}},
                       solving[i]->ring_log_odds,
                       solving[i]->beam_log_odds});
  std::vector<int> deck_of(marks.size(), -1);
  int number = 0;
  for (const Deck& deck : find_decks(circles, expected)) {
    for (const Deck::Member& member : deck.members) {
      Solving& one = *solving[mark_of[member.circle]];
      one.pair.solutions[member.solution] = member.joint;
      one.odds.now = member.solution == 0 ? deck.log_odds : -deck.log_odds;
      deck_of[mark_of[member.circle]] = number;
    }
    ++number;
  }
  return deck_of;
}

/// Where the normal of a cargo in this circle is expected: it stands on the deck, if to a few degrees only,
/// or hangs over it. Nothing where the deck itself may be the other way.
std::optional<ExpectedNormal> normal_on_deck(const Solving& circle) {
  constexpr double lean_rad = 3 * std::numbers::pi / 180;
  constexpr double sure = 0.95;
  const double p = probability_of(circle.odds);
  if (std::max(p, 1 - p) < sure) return std::nullopt;
  const CircleSolution& deck = circle.pair.solutions[p >= 0.5 ? 0 : 1];
  return ExpectedNormal{deck.normal_camera, deck.normal_covariance_rad2.trace() / 2 + lean_rad * lean_rad};
}

/// Of a cargo: within a circle of a deck, whose normal says more than gravity, along that.
ExpectedNormal expected_of_cargo(const MarkImage& cargo, const std::vector<MarkImage>& marks,
                                 const std::vector<std::optional<Solving>>& solving,
                                 const std::vector<int>& deck_of, const ExpectedNormal& by_gravity) {
  const Ellipse& rim = cargo.outer.ellipse;
  for (std::size_t k = 0; k < marks.size(); ++k) {
    if (deck_of[k] < 0 || normalized_radius_squared(marks[k].outer.ellipse, {rim.u_px, rim.v_px}) > 1)
      continue;
    if (const auto on_deck = normal_on_deck(*solving[k])) return *on_deck;
  }
  return by_gravity;
}

void choose(CirclePose& pose, const Solving& solving, bool with_gravity) {
  const double p = probability_of(solving.odds);
  pose.solutions = {{solving.pair.solutions[0], p}, {solving.pair.solutions[1], 1 - p}};
  if (p < 0.5) std::swap(pose.solutions[0], pose.solutions[1]);
  pose.chosen_by = chosen_by(solving.odds, with_gravity);
}

std::vector<CirclePose> with_radii(const std::vector<MarkImage>& marks, const PoseSettings& settings) {
  std::vector<CirclePose> poses(marks.size());
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const auto radius_m = radius_of(marks[i].label, settings);
    poses[i].radius_m = radius_m.value_or(0);
    poses[i].label = marks[i].label;
    if (!radius_m) poses[i].reason = NoPose::radius_unknown;
  }
  return poses;
}

void solve_by_conic(std::vector<CirclePose>& poses, const std::vector<MarkImage>& marks,
                    const Pinhole& camera, const PoseContext& context, const PoseSettings& settings) {
  std::vector<std::optional<Solving>> solving(marks.size());
  const ExpectedNormal by_gravity = expected_normal(context.gravity, settings);
  const auto solve = [&](std::size_t i, const ExpectedNormal& expected) {
    if (poses[i].radius_m > 0)
      solving[i] = solve_alone(marks[i], poses[i].radius_m, camera, expected, context, settings);
  };
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (marks[i].label != Label::cargo) solve(i, by_gravity);
  const auto deck_of = solve_decks(marks, solving, settings.circle_radius_m, camera, by_gravity);
  for (std::size_t i = 0; i < marks.size(); ++i)
    if (marks[i].label == Label::cargo)
      solve(i, expected_of_cargo(marks[i], marks, solving, deck_of, by_gravity));
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (!solving[i]) continue;
    choose(poses[i], *solving[i], context.gravity.has_value());
    poses[i].deck = deck_of[i];
  }
}

/// What is no circle of the known radius loses its label, and its pose with it.
void revise_labels(std::vector<CirclePose>& poses, const std::vector<MarkImage>& marks,
                   const ExpectedNormal& expected) {
  std::vector<SupposedCircle> circles;
  std::vector<std::size_t> mark_of;
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (poses[i].label != Label::circle || poses[i].solutions.empty()) continue;
    const CircleSolution& chosen = poses[i].solutions.front().circle;
    // a lone circle's normal is known less well than where decks are level
    circles.push_back({chosen.center_camera_m,
                       poses[i].deck >= 0 ? chosen.normal_camera : expected.normal_camera,
                       marks[i].measured ? marks[i].coverage : 0, marks[i].measured && marks[i].holds_cargo});
    mark_of.push_back(i);
  }
  const std::vector<bool> have = have_marks_size(circles);
  for (std::size_t k = 0; k < circles.size(); ++k) {
    if (have[k]) continue;
    poses[mark_of[k]] = CirclePose();
    poses[mark_of[k]].reason = NoPose::another_size;
  }
}

void solve_by_four_points(CirclePose& pose, const EllipseFit& outer, const Pinhole& camera) {
  if (const auto circle = four_point_pose(outer, camera, pose.radius_m))
    pose.solutions.push_back({*circle, 1});
}

}  // namespace

const char* reason_text(NoPose reason) {
  switch (reason) {
    case NoPose::none:
      return "";
    case NoPose::radius_unknown:
      return "unknown label: no radius";
    case NoPose::another_size:
      return "not of a circle's size on the deck of the others";
    case NoPose::not_solvable:
      return "no circle of this radius fits the ellipse";
  }
  return "";
}

std::optional<double> radius_of(Label label, const PoseSettings& settings) {
  switch (label) {
    case Label::circle:
      return settings.circle_radius_m;
    case Label::cargo:
      return settings.cargo_radius_m;
    case Label::unknown:
      return std::nullopt;
  }
  return std::nullopt;
}

std::vector<CirclePose> estimate_poses(const std::vector<MarkImage>& marks, const Pinhole& camera,
                                       const PoseContext& context, const PoseSettings& settings) {
  std::vector<CirclePose> poses = with_radii(marks, settings);
  if (settings.method == "four_point") {
    for (std::size_t i = 0; i < marks.size(); ++i)
      if (poses[i].radius_m > 0) solve_by_four_points(poses[i], marks[i].outer, camera);
  } else {
    solve_by_conic(poses, marks, camera, context, settings);
  }
  revise_labels(poses, marks, expected_normal(context.gravity, settings));
  for (CirclePose& pose : poses) {
    if (pose.solutions.empty() && pose.reason == NoPose::none) pose.reason = NoPose::not_solvable;
    for (PoseSolution& solution : pose.solutions)
      solution.circle.covariance_m2 += common_error(solution.circle.center_camera_m, camera, settings);
  }
  return poses;
}

CirclePose estimate_pose(const MarkImage& mark, const Pinhole& camera, const PoseContext& context,
                         const PoseSettings& settings) {
  return estimate_poses({mark}, camera, context, settings).front();
}

}  // namespace stevedore
