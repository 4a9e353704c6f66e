#include "tracker_proc/common_motion.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <utility>

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

// Proposals looked at, the likeliest by themselves first; pairs that agreed with an earlier one propose
// nothing new. A grid of 5 x 5 equal marks allows for 81 shifts.
constexpr std::size_t kProposals = 100;

// A camera that also rolls by a degree or comes nearer by a fiftieth moves two marks against each other by so
// much of the distance between them; what each is thought to know of its velocity adds a pixel.
constexpr double kDeformation = 0.02, kDeformation_px = 1;

// Marks that look alike don't overlap: ellipses nearer to each other than one radius of the smaller are two
// edges of one thing, as a bucket's rim and the outline of its wall. Which is which says nothing about the
// shift.
constexpr double kOneThing_radii = 1;

// The second best explanation counts while it is a thousandth as likely as the best.
const double kDoubt = std::log(1000.0);

/// An expected mark and an ellipse that could be it.
struct Pair {
  std::size_t expected, found;
  Eigen::Vector2d off_px;
  double variance_px2;  ///< of off_px, the same in all directions
  double likeness;
  double radius_px;
};

/// What all proposals are about.
struct Scene {
  const std::vector<Expected>& expected;
  const std::vector<Found>& found;
  const cv::Size& frame;
  double common_px2;  ///< variance of the shift so far
  std::vector<Pair> pairs;
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

Prior prior_of(const Scene& scene, const Pair& pair) {
  const double squared = pair.off_px.squaredNorm(), variance = scene.common_px2 + pair.variance_px2;
  const Prior all[] = {
      {log_normal_density(squared, variance), Movement::expected},
      {std::log(kJerkChance) + log_normal_density(squared, variance + jerk_px2(pair.radius_px)),
       Movement::jerk},
      {std::log(kJumpChance / scene.frame.area()), Movement::jump}};
  return *std::max_element(std::begin(all), std::end(all),
                           [](const Prior& x, const Prior& y) { return x.log_density < y.log_density; });
}

/// Variance by which two marks may have moved against each other though both only followed the camera.
double deformation_px2(const Scene& scene, const Pair& one, const Pair& other) {
  const Ellipse &e = scene.expected[one.expected].ellipse, &f = scene.expected[other.expected].ellipse;
  const double apart_px = std::hypot(e.u_px - f.u_px, e.v_px - f.v_px);
  return kDeformation_px * kDeformation_px + std::pow(kDeformation * apart_px, 2);
}

std::vector<Pair> possible_pairs(const std::vector<Expected>& expected, const std::vector<Found>& found) {
  std::vector<Pair> pairs;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Expected& e = expected[i];
    for (std::size_t k = 0; k < found.size(); ++k) {
      const double likeness = log_likeness(e, found[k]);
      if (likeness < kLeastLikeness) continue;
      pairs.push_back({i, k, found[k].measurement.centre_px - Eigen::Vector2d(e.ellipse.u_px, e.ellipse.v_px),
                       (e.centre_covariance_px2 + found[k].measurement.centre_covariance_px2).trace() / 2,
                       likeness, std::sqrt(e.ellipse.a_px * e.ellipse.b_px)});
    }
  }
  return pairs;
}

/// A shift, the pairs that agree with it, and the logarithm of how likely it makes the frame.
struct Proposal {
  double gain = 0;
  Movement movement = Movement::expected;
  std::vector<const Pair*> pairs;
};

/// What a shift explains: the pairs that agree with it, those that fit best first; each mark and each ellipse
/// once. A mark that takes none should have been found where the shift puts it, or is out of view there; but
/// a jump is no excuse: what covers many marks at once (a hand, blur) is likelier than one that puts them out
/// of view.
Proposal proposal_of(const Scene& scene, const Pair& leader, const Prior& prior) {
  struct Candidate {
    const Pair* pair;
    double gain;
  };
  Proposal proposal{prior.log_density, prior.movement, {}};
  std::vector<double> alone(scene.expected.size());
  for (std::size_t mark = 0; mark < scene.expected.size(); ++mark) {
    double probability = found_probability(scene.expected[mark], leader.off_px, scene.frame);
    if (prior.movement == Movement::jump)
      probability = std::max(probability, found_probability(scene.expected[mark], {0, 0}, scene.frame));
    alone[mark] = std::log((1 - probability) / probability) + log_newcomer_density(scene.frame);
    proposal.gain += std::log(1 - probability);
  }
  std::vector<Candidate> candidates{{&leader, leader.likeness - alone[leader.expected]}};
  for (const Pair& pair : scene.pairs) {
    if (pair.expected == leader.expected || pair.found == leader.found) continue;
    const double squared = (pair.off_px - leader.off_px).squaredNorm();
    const double variance = pair.variance_px2 + leader.variance_px2 + deformation_px2(scene, pair, leader);
    if (squared > 50 * variance) continue;  // exp(-25): never worth the logarithm
    const double gain = pair.likeness - alone[pair.expected] + log_normal_density(squared, variance);
    if (gain > 0) candidates.push_back({&pair, gain});
  }
  std::stable_sort(candidates.begin() + 1, candidates.end(),
                   [](const Candidate& x, const Candidate& y) { return x.gain > y.gain; });
  std::vector<bool> placed(scene.expected.size()), taken(scene.found.size());
  for (const auto& [pair, gain] : candidates) {
    if (placed[pair->expected] || taken[pair->found]) continue;
    placed[pair->expected] = taken[pair->found] = true;
    proposal.gain += gain;
    proposal.pairs.push_back(pair);
  }
  return proposal;
}

/// Whether a proposal led by the first would say nothing that one led by the second has not said.
bool same_shift(const Pair& pair, const Pair& leader) {
  return (pair.off_px - leader.off_px).squaredNorm() < std::min(pair.variance_px2, leader.variance_px2) &&
         pair.variance_px2 > leader.variance_px2 / 2;
}

/// No ellipse is any of the marks.
double gain_of_none(const Scene& scene) {
  double gain = 0;
  for (const Expected& e : scene.expected) gain += std::log(1 - found_probability(e, {0, 0}, scene.frame));
  return gain;
}

/// The likeliest first.
std::vector<Proposal> proposals_of(const Scene& scene) {
  struct Leader {
    const Pair* pair;
    Prior prior;
  };
  std::vector<Leader> leaders;
  for (const Pair& pair : scene.pairs) leaders.push_back({&pair, prior_of(scene, pair)});
  const auto alone = [](const Leader& l) { return l.pair->likeness + l.prior.log_density; };
  std::stable_sort(leaders.begin(), leaders.end(),
                   [&](const Leader& x, const Leader& y) { return alone(x) > alone(y); });

  std::vector<Proposal> proposals;
  std::set<const Pair*> agreed;
  std::size_t most_pairs = 0, looked_at = 0;
  for (const Leader& leader : leaders) {
    if (agreed.contains(leader.pair)) continue;
    if (++looked_at > kProposals) break;
    // everything is explained by what was to be expected: no jump can do better
    const std::size_t possible = std::min(scene.expected.size(), scene.found.size());
    if (leader.prior.movement == Movement::jump && most_pairs == possible) break;
    Proposal proposal = proposal_of(scene, *leader.pair, leader.prior);
    most_pairs = std::max(most_pairs, proposal.pairs.size());
    for (const Pair* pair : proposal.pairs)
      if (same_shift(*pair, *leader.pair)) agreed.insert(pair);
    if (proposal.gain > gain_of_none(scene)) proposals.push_back(std::move(proposal));
  }
  std::stable_sort(proposals.begin(), proposals.end(),
                   [](const Proposal& x, const Proposal& y) { return x.gain > y.gain; });
  return proposals;
}

/// Whether they are two shifts: more ellipses are one mark for one of them and another, elsewhere, for the
/// other, both of them there, than are the same mark for both. Where most are the same, so is the shift, and
/// the rest is up to the assignment.
bool contradict(const Scene& scene, const Proposal& one, const Proposal& other) {
  int same = 0, different = 0;
  for (const Pair* p : one.pairs)
    for (const Pair* q : other.pairs) {
      if (p->found != q->found || scene.expected[p->expected].is_doubtful ||
          scene.expected[q->expected].is_doubtful)
        continue;
      const bool one_thing =
          (p->off_px - q->off_px).norm() < kOneThing_radii * std::min(p->radius_px, q->radius_px);
      ++(one_thing ? same : different);
    }
  return different > same;
}

/// The ellipses of all explanations that could be the right one, if there are several; else empty.
std::vector<bool> ambiguous_ones(const Scene& scene, const std::vector<Proposal>& proposals) {
  const Proposal& best = proposals.front();
  std::vector<bool> ambiguous;
  for (const Proposal& p : proposals) {
    if (p.gain < best.gain - kDoubt || !contradict(scene, best, p)) continue;
    ambiguous.resize(scene.found.size());
    for (const Pair* pair : best.pairs) ambiguous[pair->found] = true;
    for (const Pair* pair : p.pairs) ambiguous[pair->found] = true;
  }
  return ambiguous;
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
                               const cv::Size& frame, double dt_s) {
  const Scene scene{expected, found, frame, covariance_(0, 0), possible_pairs(expected, found)};
  const std::vector<Proposal> proposals = proposals_of(scene);
  if (proposals.empty()) return {};
  const Proposal& best = proposals.front();
  CommonShift doubt;
  doubt.ambiguous = ambiguous_ones(scene, proposals);
  if (!doubt.ambiguous.empty()) return doubt;

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
    return {mean, Eigen::Vector2d::Zero(), best.pairs.size(), {}};
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
  return {gain[0] * shift_px, gain[1] * shift_px, 0, {}};
}

}  // namespace stevedore
