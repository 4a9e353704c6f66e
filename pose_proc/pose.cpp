#include "pose_proc/pose.hpp"

namespace stevedore {
namespace {

void solve_by_conic(CirclePose& pose, const EllipseFit& outer, const Pinhole& camera,
                    const std::optional<Gravity>& gravity, const std::optional<PreviousChoice>& previous,
                    const PoseSettings& settings) {
  const auto both = conic_pose(outer, camera, pose.radius_m);
  if (!both) return;
  const SolutionChoice choice = choose_solution(*both, gravity, previous, settings);
  for (std::size_t i = 0; i < 2; ++i) pose.solutions.push_back({choice.solutions[i], choice.probability[i]});
  pose.chosen_by = choice.chosen_by;
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

CirclePose estimate_pose(const EllipseFit& outer, Label label, const Pinhole& camera,
                         const std::optional<Gravity>& gravity, const std::optional<PreviousChoice>& previous,
                         const PoseSettings& settings) {
  CirclePose pose;
  const std::optional<double> radius_m = radius_of(label, settings);
  if (!radius_m) {
    pose.reason = NoPose::radius_unknown;
    return pose;
  }
  pose.radius_m = *radius_m;
  if (settings.method == "four_point")
    solve_by_four_points(pose, outer, camera);
  else
    solve_by_conic(pose, outer, camera, gravity, previous, settings);
  if (pose.solutions.empty()) pose.reason = NoPose::not_solvable;
  return pose;
}

}  // namespace stevedore
