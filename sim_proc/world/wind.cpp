#include "sim_proc/world/wind.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace stevedore::world {
namespace {

constexpr double foot_m = 0.3048;
constexpr double height_ft = 20;  ///< 6 m: the middle of the heights that are flown

// MIL-F-8785C 3.7.3.4: scale lengths and the ratio of vertical to horizontal turbulence below 1000 feet.
const double base = 0.177 + 0.000823 * height_ft;
const double horizontal_scale_m = height_ft / std::pow(base, 1.2) * foot_m;
const double vertical_scale_m = height_ft * foot_m;
const double vertical_share = std::pow(base, 0.4);

/// Scale lengths are met at this speed at least: in a calm, turbulence would stand still.
constexpr double slowest_mps = 1;

Eigen::Vector3d horizontal(double bearing_rad) {
  return {std::cos(bearing_rad), std::sin(bearing_rad), 0};
}

}  // namespace

Wind::Wind(std::uint64_t seed, const WindSettings& settings, double step_s) : dice_(seed, "wind") {
  downwind_ned_ = horizontal(dice_.uniform(0, 2 * std::numbers::pi));
  mean_ned_mps_ = settings.mean_mps * downwind_ned_;
  const double speed_mps = std::max(settings.mean_mps, slowest_mps), sigma_mps = settings.turbulence_mps;
  along_ = along(sigma_mps, horizontal_scale_m / speed_mps, step_s);
  across_ = across(sigma_mps, horizontal_scale_m / speed_mps, step_s);
  vertical_ = across(sigma_mps * vertical_share, vertical_scale_m / speed_mps, step_s);
}

Wind::Along Wind::along(double sigma_mps, double time_s, double step_s) {
  const double keep = std::exp(-step_s / time_s);
  return {keep, sigma_mps * std::sqrt(1 - keep * keep), dice_.normal(sigma_mps)};
}

/// State: y and dy/dt of noise through 1 / (1 + T s)^2. Its steady covariance is diag(1, 1 / T^2) sigma^2 / 4
/// (from Lyapunov's equation), and the step's noise is what keeps it: P - F P F'.
Wind::Across Wind::across(double sigma_mps, double time_s, double step_s) {
  const double h = step_s / time_s;
  Across filter;
  filter.time_s = time_s;
  filter.keep << 1 + h, step_s, -h / time_s, 1 - h;
  filter.keep *= std::exp(-h);
  const Eigen::Vector2d sigma(sigma_mps / 2, sigma_mps / 2 / time_s);
  const Eigen::Matrix2d steady = sigma.cwiseAbs2().asDiagonal();
  const Eigen::Matrix2d noise = steady - filter.keep * steady * filter.keep.transpose();
  // triangular root by hand: in a calm the noise is zero, of which no Cholesky exists
  const double first = std::sqrt(std::max(0.0, noise(0, 0)));
  const double cross = first > 0 ? noise(1, 0) / first : 0;
  filter.kick << first, 0, cross, std::sqrt(std::max(0.0, noise(1, 1) - cross * cross));
  filter.state << dice_.normal(sigma.x()), dice_.normal(sigma.y());
  return filter;
}

double Wind::Across::value_mps() const {
  return state.x() + std::numbers::sqrt3 * time_s * state.y();
}

void Wind::step() {
  along_.value_mps = along_.keep * along_.value_mps + dice_.normal(along_.kick_mps);
  for (Across* filter : {&across_, &vertical_}) {
    const double first = dice_.normal(), second = dice_.normal();
    filter->state = filter->keep * filter->state + filter->kick * Eigen::Vector2d(first, second);
  }
}

Eigen::Vector3d Wind::gust_ned_mps() const {
  const Eigen::Vector3d sideways_ned(-downwind_ned_.y(), downwind_ned_.x(), 0);
  return along_.value_mps * downwind_ned_ + across_.value_mps() * sideways_ned +
         vertical_.value_mps() * Eigen::Vector3d::UnitZ();
}

}  // namespace stevedore::world
