#include "pose_proc/solution_choice.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stevedore {
namespace {

constexpr double rad_per_deg = std::numbers::pi / 180;

/// Decks roll and pitch with periods of 5 to 7 s, attitude errors wander as slowly: about a quarter of a
/// period later they are independent.
constexpr double independent_after_s = 1.5;

/// One choice in a thousand is wrong for a reason that none of the evidence knows: another circle under the
/// same track, an edge that is not the circle's.
constexpr double unforeseen = 1e-3;

/// Beams range to 20 m or so, and what else they hit may be at any distance.
constexpr double elsewhere_density = 1.0 / 20;  // 1/m

double squared(double x) {
  return x * x;
}

double beam_likelihood(const CircleSolution& circle, const BeamRange& beam) {
  const Eigen::Vector3d& n = circle.normal_camera;
  const double closing = n.dot(beam.direction_camera);
  if (closing > -0.1) return elsewhere_density;  // all but along the plane: hits it nowhere near
  const double range_m = n.dot(circle.center_camera_m - beam.origin_camera_m) / closing;
  // the foot of the beam moves along the normal by centre and tilt
  const Eigen::Vector3d from_center =
      beam.origin_camera_m + range_m * beam.direction_camera - circle.center_camera_m;
  const double variance_m2 =
      squared(beam.sigma_m) +
      (n.dot(circle.covariance_m2 * n) + from_center.dot(circle.normal_covariance_rad2 * from_center)) /
          squared(closing);
  const double on_plane = std::exp(-squared(range_m - beam.range_m) / (2 * variance_m2)) /
                          std::sqrt(2 * std::numbers::pi * variance_m2);
  return (on_plane + elsewhere_density) / 2;
}

double continuation(const CircleSolution& now, const Eigen::Vector3d& before, double variance_rad2) {
  return density({before, variance_rad2}, now.normal_camera, now.normal_covariance_rad2);
}

double weight_of_now(const LogOdds& odds) {
  if (!odds.before) return 1;
  return std::min(1.0, std::max(0.0, odds.elapsed_s) / independent_after_s + 1 - odds.before->share);
}

double log_odds_before(const LogOdds& odds) {
  return odds.before ? odds.before->log_odds : 0;
}

}  // namespace

ExpectedNormal expected_normal(const std::optional<Gravity>& gravity, const PoseSettings& settings) {
  const double deck_variance = squared(settings.deck_tilt_sigma_deg * rad_per_deg);
  if (!gravity)
    return {-Eigen::Vector3d::UnitZ(), squared(settings.camera_tilt_sigma_deg * rad_per_deg) + deck_variance};
  return {-gravity->direction_camera,
          squared(gravity->sigma_rad) + squared(settings.attitude_sigma_deg * rad_per_deg) + deck_variance};
}

double beam_log_odds(const std::array<CircleSolution, 2>& solutions, const BeamRange& beam) {
  return std::log(beam_likelihood(solutions[0], beam) / beam_likelihood(solutions[1], beam));
}

Carried carried_over(const std::array<CircleSolution, 2>& solutions, const PreviousChoice& previous,
                     const PoseSettings& settings) {
  constexpr double nominal_s = 1.0 / 30;  // which the setting is for
  const double variance_rad2 =
      squared(settings.turn_sigma_deg * rad_per_deg) * std::max(previous.elapsed_s / nominal_s, 1.0);
  const auto first_now = [&](const Eigen::Vector3d& then) {
    const double first = continuation(solutions[0], then, variance_rad2),
                 second = continuation(solutions[1], then, variance_rad2);
    return first / (first + second);
  };
  const std::array<double, 2> first{first_now(previous.normal_camera[0]),
                                    first_now(previous.normal_camera[1])};
  const double p = previous.probability * first[0] + (1 - previous.probability) * first[1];
  return {std::log(p / (1 - p)), std::abs(first[0] - first[1])};
}

double probability_of(const LogOdds& odds) {
  const double sum = log_odds_before(odds) + weight_of_now(odds) * odds.now;
  return unforeseen / 2 + (1 - unforeseen) / (1 + std::exp(-sum));
}

ChosenBy chosen_by(const LogOdds& odds, bool with_gravity) {
  if (std::abs(log_odds_before(odds)) > std::abs(weight_of_now(odds) * odds.now)) return ChosenBy::continuity;
  return with_gravity ? ChosenBy::attitude : ChosenBy::optical_axis;
}

}  // namespace stevedore
