#include "platform/slot_identity.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace stevedore {
namespace {

constexpr double beyond_three_sigma = 0.0027;

/// One message moves the odds by a factor of 20 at most: headings told are wrong for seconds at a time, and
/// four in agreement, two seconds, must be needed to be certain.
constexpr double most_told = 3;

/// Never so sure that a dozen messages can't turn it.
constexpr double least_probability = 1e-6;

void normalise(std::vector<double>& p) {
  for (double& x : p) x = std::max(x, least_probability);
  const double sum = std::accumulate(p.begin(), p.end(), 0.0);
  for (double& x : p) x /= sum;
}

}  // namespace

SlotIdentity::SlotIdentity(double period_rad, int periods)
    : period_rad_(period_rad), probability_(static_cast<std::size_t>(periods), 1.0 / periods) {}

std::vector<double> SlotIdentity::found(double residual_rad, double sigma_rad) {
  const std::size_t n = probability_.size();
  std::vector<double> slipped(n, 0.0);
  constexpr int far = 3;  // periods beyond which a Gaussian has nothing left that matters
  for (int k = -far * static_cast<int>(n); k <= far * static_cast<int>(n); ++k) {
    const double off = (residual_rad + k * period_rad_) / sigma_rad;
    const auto turn =
        static_cast<std::size_t>(((k % static_cast<int>(n)) + static_cast<int>(n)) % static_cast<int>(n));
    slipped[turn] += std::exp(-off * off / 2);
  }
  // the rule: certain only while three sigma are less than half a period
  const bool known = n == 1 || 3 * sigma_rad < period_rad_ / 2;
  const double most = *std::max_element(slipped.begin(), slipped.end());
  if (!known)
    for (double& s : slipped) s = std::max(s, 2 * beyond_three_sigma * most);
  normalise(slipped);

  std::vector<double> mixed(n, 0.0);
  for (std::size_t before = 0; before < n; ++before)
    for (std::size_t slip = 0; slip < n; ++slip)
      mixed[(before + slip) % n] += probability_[before] * slipped[slip];
  probability_ = mixed;
  normalise(probability_);
  choose();
  return slipped;
}

void SlotIdentity::told(double off_rad, double sigma_rad) {
  std::vector<double> log_likelihood;
  for (std::size_t k = 0; k < probability_.size(); ++k) {
    const double off =
        std::remainder(off_rad - static_cast<double>(k) * period_rad_, 2 * std::numbers::pi) / sigma_rad;
    log_likelihood.push_back(-off * off / 2);
  }
  const double best = *std::max_element(log_likelihood.begin(), log_likelihood.end());
  for (std::size_t k = 0; k < probability_.size(); ++k)
    probability_[k] *= std::exp(std::max(log_likelihood[k] - best, -most_told));
  normalise(probability_);
  choose();
}

bool SlotIdentity::certain() const {
  return 1 - probability_[static_cast<std::size_t>(turns_)] < beyond_three_sigma;
}

double SlotIdentity::spread_rad2() const {
  double spread = 0;
  for (std::size_t k = 0; k < probability_.size(); ++k) {
    const double off =
        std::remainder(static_cast<double>(static_cast<int>(k) - turns_) * period_rad_, 2 * std::numbers::pi);
    spread += probability_[k] * off * off;
  }
  return spread;
}

/// Keeps to its choice among ways that are as good.
void SlotIdentity::choose() {
  const auto best =
      static_cast<int>(std::max_element(probability_.begin(), probability_.end()) - probability_.begin());
  constexpr double clearly = 1.5;
  if (probability_[static_cast<std::size_t>(best)] > clearly * probability_[static_cast<std::size_t>(turns_)])
    turns_ = best;
}

}  // namespace stevedore
