#include "platform/deck_outlook.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>
#include <numbers>

#include "platform/deck_sight.hpp"

namespace stevedore {
namespace {

/// Lever arms are known to 2 cm; they don't average out.
constexpr double arm_sigma_m = 0.02;

constexpr double every_s =
    0.5;  // a wave of 5 s turns by 36 degrees: half way it is 5 % above its ends at most
constexpr int predictions = 4;

/// That a Gaussian variable lies within +-limit.
double probability_within(double limit, double mean, double sigma) {
  const double root = sigma * std::numbers::sqrt2;
  return (std::erf((limit - mean) / root) + std::erf((limit + mean) / root)) / 2;
}

/// Variance of a sum of parts of the state.
double variance_of(const DeckState& state, Eigen::Index a, Eigen::Index b) {
  return state.covariance(a, a) + state.covariance(b, b) + 2 * state.covariance(a, b);
}

}  // namespace

DeckCourse course_of(const DeckState& state) {
  Eigen::Matrix<double, 6, at::size> by_state = Eigen::Matrix<double, 6, at::size>::Zero();
  by_state(0, at::north) = by_state(1, at::east) = by_state(2, at::down) = 1;
  by_state(3, at::velocity_north) = by_state(4, at::velocity_east) = 1;
  for (const Eigen::Index wave : {0, 2})
    by_state(2, at::heave + wave) = by_state(5, at::heave + wave + 1) = 1;
  DeckCourse course{
      deck_center_odometry_m(state.mean),
      {state.mean[at::velocity_north], state.mean[at::velocity_east], swing_rate(state.mean, at::heave)},
      by_state * state.covariance * by_state.transpose()};
  course.covariance.diagonal().head<3>().array() += arm_sigma_m * arm_sigma_m;
  return course;
}

bool is_safe(const DeckState& state, const PlatformSettings& settings) {
  const double speed_sigma = std::sqrt(variance_of(state, at::heave + 1, at::heave + 3));
  const double level =
      probability_within(settings.safe_speed_mps, swing_rate(state.mean, at::heave), speed_sigma);
  // along the way it leans; the larger of both variances
  const double tilt_rad = std::hypot(swing(state.mean, at::roll), swing(state.mean, at::pitch));
  const double tilt_sigma = std::sqrt(
      std::max(variance_of(state, at::roll, at::roll + 2), variance_of(state, at::pitch, at::pitch + 2)));
  const double limit_rad = settings.safe_tilt_deg * std::numbers::pi / 180;
  return level * probability_within(limit_rad, tilt_rad, tilt_sigma) >= settings.safe_probability;
}

std::vector<DeckPrediction> outlook(const DeckState& now, const DeckMotion& motion,
                                    const Disturbance& disturbance, const PlatformSettings& settings) {
  std::vector<DeckPrediction> out;
  DeckState state = now;
  bool safe_before = is_safe(now, settings);
  for (int i = 1; i <= predictions; ++i) {
    state = motion.predicted(state, every_s, disturbance);
    const bool safe_then = is_safe(state, settings);
    const DeckCourse course = course_of(state);
    out.push_back({i * every_s, course.center_odometry_m, course.velocity_ned_mps,
                   deck_normal(state.mean).value, course.covariance, safe_before && safe_then});
    safe_before = safe_then;
  }
  return out;
}

}  // namespace stevedore
