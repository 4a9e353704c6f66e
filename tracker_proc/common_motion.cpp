#include "tracker_proc/common_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

namespace stevedore {
namespace {

using std::numbers::pi;

// Chance in a frame that the picture jumps to anywhere: once in nine hours at 30 Hz. One mark that moved so
// far is sooner a newcomer (5 % missed x 1 % newcomers); two that agree can't be chance.
constexpr double kJumpChance = 1e-6;

// Chance of a jerk of the camera, and its size in radii of a mark, as for a mark by itself.
constexpr double kJerkChance = 0.05;
constexpr double kJerkRadii = 1.0 / 3;

// Pairs this unlike are two different things: exp(-12) is less than any motion could make up for.
constexpr double kLeastLikeness = -12;

// Proposals looked at, the likeliest by themselves first. A right shift is proposed by every mark that is
// seen, so that with ten marks and forty ellipses (400 pairs) one of the first 100 is sure to be right.
constexpr std::size_t kProposals = 100;

/// An expected mark and an ellipse that could be it.
struct Pair {
  std::size_t expected, found;
  Eigen::Vector2d off_px;
  double variance_px2;  ///< of off_px, the same in all directions
  double gain;          ///< for the pair, but for its place
  double radius_px;
};

/// How the picture moved, and the variance of the shift that goes with it; jump: any.
enum class Movement { expected, jerk, jump };

struct Prior {
  double log_density;
  Movement movement;
};

double log_normal_density(double squared_px2, double variance_px2) {
  return -squared_px2 / variance_px2 / 2 - std::log(2 * pi * variance_px2);
}

double jerk_px2(double radius_px) {
  return kJerkRadii * kJerkRadii * radius_px * radius_px;
}

Prior prior_of(const Pair& pair, double common_px2, double frame_px2) {
  const double squared = pair.off_px.squaredNorm(), variance = common_px2 + pair.variance_px2;
  const Prior all[] = {
      {log_normal_density(squared, variance), Movement::expected},
      {std::log(kJerkChance) + log_normal_density(squared, variance + jerk_px2(pair.radius_px)),
       Movement::jerk},
      {std::log(kJumpChance / frame_px2), Movement::jump}};
  return *std::max_element(std::begin(all), std::end(all),
                           [](const Prior& x, const Prior& y) { return x.log_density < y.log_density; });
}

std::vector<Pair> possible_pairs(const std::vector<Expected>& expected, const std::vector<Found>& found,
                                 double frame_px2) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Expected& e = expected[i];
    const double alone = log_missed_odds(e.seen_probability) + log_newcomer_density(frame_px2);
    for (std::size_t k = 0; k < found.size(); ++k) {
      const double likeness = log_likeness(e, found[k]);
      if (likeness < kLeastLikeness) continue;
      pairs.push_back({i, k, found[k].measurement.centre_px - Eigen::Vector2d(e.ellipse.u_px, e.ellipse.v_px),
                       (e.centre_covariance_px2 + found[k].measurement.centre_covariance_px2).trace() / 2,
                       likeness - alone, std::sqrt(e.ellipse.a_px * e.ellipse.b_px)});
    }
  }
  return pairs;
}

/// A shift, the pairs that agree with it, and how much better they explain the frame than no pair at all.
struct Proposal {
  double gain = 0;
  Movement movement = Movement::expected;
  std::vector<const Pair*> pairs;
};

/// Each expected mark (the pairs are in their order) takes the ellipse that fits best of those still free.
Proposal proposal_of(const std::vector<Pair>& pairs, const Pair& leader, const Prior& prior,
                     std::size_t found_count) {
  Proposal proposal{leader.gain + prior.log_density, prior.movement, {&leader}};
  std::vector<bool> taken(found_count, false);
  taken[leader.found] = true;
  for (std::size_t i = 0; i < pairs.size();) {
    const std::size_t mark = pairs[i].expected;
    const Pair* best = nullptr;
    double most = 0;
    for (; i < pairs.size() && pairs[i].expected == mark; ++i) {
      const Pair& pair = pairs[i];
      if (mark == leader.expected || taken[pair.found]) continue;
      const double squared = (pair.off_px - leader.off_px).squaredNorm();
      const double variance = pair.variance_px2 + leader.variance_px2;
      if (squared > 50 * variance) continue;  // exp(-25): never worth the logarithm
      const double gain = pair.gain + log_normal_density(squared, variance);
      if (gain > most) best = &pair, most = gain;
    }
    if (!best) continue;
    proposal.gain += most;
    proposal.pairs.push_back(best);
    taken[best->found] = true;
  }
  return proposal;
}

Proposal best_proposal(const std::vector<Pair>& pairs, std::size_t expected_count, std::size_t found_count,
                       double common_px2, double frame_px2) {
  struct Leader {
    const Pair* pair;
    Prior prior;
  };
  std::vector<Leader> leaders;
  for (const Pair& pair : pairs) leaders.push_back({&pair, prior_of(pair, common_px2, frame_px2)});
  const auto alone = [](const Leader& l) { return l.pair->gain + l.prior.log_density; };
  std::stable_sort(leaders.begin(), leaders.end(),
                   [&](const Leader& x, const Leader& y) { return alone(x) > alone(y); });
  leaders.resize(std::min(leaders.size(), kProposals));

  Proposal best;
  for (const Leader& leader : leaders) {
    // everything is explained by what was to be expected: no jump can do better
    if (leader.prior.movement == Movement::jump && best.pairs.size() == std::min(expected_count, found_count))
      break;
    Proposal proposal = proposal_of(pairs, *leader.pair, leader.prior, found_count);
    if (proposal.gain > best.gain) best = std::move(proposal);
  }
  return best;
}

}  // namespace

CommonMotion::CommonMotion(double velocity_sigma_pxps) : covariance_(Eigen::Matrix2d::Zero()) {
  covariance_(1, 1) = velocity_sigma_pxps * velocity_sigma_pxps;
}

void CommonMotion::predict(double dt_s, double velocity_walk_pxps) {
  const Eigen::Matrix2d f = (Eigen::Matrix2d() << 1, dt_s, 0, 1).finished();
  covariance_ =
      f * covariance_ * f.transpose() + white_acceleration(dt_s, velocity_walk_pxps * velocity_walk_pxps);
}

CommonShift CommonMotion::find(const std::vector<Expected>& expected, const std::vector<Found>& found,
                               double frame_px2, double dt_s) {
  const std::vector<Pair> pairs = possible_pairs(expected, found, frame_px2);
  const Proposal best = best_proposal(pairs, expected.size(), found.size(), covariance_(0, 0), frame_px2);
  if (best.pairs.empty()) return {};

  double weight = 0, radius = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const Pair* pair : best.pairs) {
    weight += 1 / pair->variance_px2;
    mean += pair->off_px / pair->variance_px2;
    radius += pair->radius_px / static_cast<double>(best.pairs.size());
  }
  mean /= weight;
  if (best.movement == Movement::jump) {  // where the picture is now is told by the marks alone
    covariance_(0, 1) = covariance_(1, 0) = 0;
    covariance_(0, 0) = 1 / weight;
    return {mean, Eigen::Vector2d::Zero(), best.pairs.size()};
  }
  if (best.movement == Movement::jerk) {  // and perhaps goes on
    covariance_(0, 0) += jerk_px2(radius);
    if (dt_s > 0) covariance_(1, 1) += mean.squaredNorm() / (dt_s * dt_s) / 2;
  }
  CommonShift shift = observe(mean, 1 / weight);
  shift.marks = best.pairs.size();
  return shift;
}

CommonShift CommonMotion::observe(const Eigen::Vector2d& shift_px, double variance_px2) {
  const Eigen::Vector2d gain = covariance_.col(0) / (covariance_(0, 0) + variance_px2);
  covariance_ -= gain * covariance_.row(0).eval();
  return {gain[0] * shift_px, gain[1] * shift_px};
}

}  // namespace stevedore
