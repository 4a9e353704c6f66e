#include "pose_proc/solution_choice.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <utility>

namespace stevedore {
namespace {

constexpr double rad_per_deg = std::numbers::pi / 180;

struct Expectation {
  Eigen::Vector3d normal_camera;
  double variance_rad2;
  double probability;  ///< that the normal is there at all; else the other solution's is
  ChosenBy evidence;
};

double squared(double x) {
  return x * x;
}

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

Expectation expectation(const std::optional<Gravity>& gravity, const std::optional<PreviousChoice>& previous,
                        const PoseSettings& settings) {
  const double deck_variance = squared(settings.deck_tilt_sigma_deg * rad_per_deg);
  if (gravity)
    return {-gravity->direction_camera,
            squared(gravity->sigma_rad) + squared(settings.attitude_sigma_deg * rad_per_deg) + deck_variance,
            1, ChosenBy::attitude};
  if (previous)
    return {previous->normal_camera, squared(settings.turn_sigma_deg * rad_per_deg), previous->probability,
            ChosenBy::continuity};
  return {-Eigen::Vector3d::UnitZ(), squared(settings.camera_tilt_sigma_deg * rad_per_deg) + deck_variance, 1,
          ChosenBy::optical_axis};
}

}  // namespace

SolutionChoice choose_solution(const std::array<CircleSolution, 2>& solutions,
                               const std::optional<Gravity>& gravity,
                               const std::optional<PreviousChoice>& previous, const PoseSettings& settings) {
  const Expectation expected = expectation(gravity, previous, settings);
  // one variance for both: with one each, the solution measured worse would gain from being worse
  const double variance_rad2 =
      expected.variance_rad2 + (solutions[0].normal_variance_rad2 + solutions[1].normal_variance_rad2) / 2;
  const double off_0 = angle_between(solutions[0].normal_camera, expected.normal_camera);
  const double off_1 = angle_between(solutions[1].normal_camera, expected.normal_camera);
  const double nearer_0 = 1 / (1 + std::exp((squared(off_0) - squared(off_1)) / (2 * variance_rad2)));
  const double p_0 = expected.probability * nearer_0 + (1 - expected.probability) * (1 - nearer_0);
  SolutionChoice choice{solutions, {p_0, 1 - p_0}, expected.evidence};
  if (p_0 < 0.5) {
    std::swap(choice.solutions[0], choice.solutions[1]);
    std::swap(choice.probability[0], choice.probability[1]);
  }
  return choice;
}

}  // namespace stevedore
