#include "platform/slot_assignment.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace stevedore {
namespace {

/// Chi-square of five numbers, exceeded once in ten thousand times (25.7), and a pose of probability 0.01
/// (9.2) that the rest speaks for.
constexpr double gate = 35;

/// The same for the centre alone: three numbers.
constexpr double center_gate = 21;

constexpr double barred = std::numeric_limits<double>::infinity();

/// What the filter expects of a slot, ready to be compared with many circles.
struct ExpectedSlot {
  CircleNumbers value;
  CircleNoise covariance;
};

ExpectedSlot expect_slot(const DeckState& state, const Eigen::Vector2d& place_m,
                         const Eigen::Vector3d& aircraft_odometry_m, double attitude_variance_rad2) {
  const ExpectedCircle circle = expected_circle(state.mean, place_m, aircraft_odometry_m);
  return {circle.value, circle.by_state * state.covariance * circle.by_state.transpose() +
                            attitude_variance_rad2 * circle.by_attitude * circle.by_attitude.transpose()};
}

double cost_of(const ExpectedSlot& slot, const CircleView& view, double probability) {
  const CircleNumbers off = view.numbers() - slot.value;
  const CircleNoise covariance = slot.covariance + view.noise();
  const Eigen::Vector3d center = off.head<3>();
  if (center.dot(covariance.topLeftCorner<3, 3>().ldlt().solve(center)) > center_gate) return barred;
  const double squares = off.dot(covariance.ldlt().solve(off));
  const double cost = squares - 2 * std::log(std::max(probability, 1e-6));
  return cost < gate ? cost : barred;
}

struct Pairing {
  double cost = barred;
  std::size_t view = 0;
};

Pairing pair(const ExpectedSlot& slot, const CircleCandidates& circle) {
  Pairing best;
  for (std::size_t v = 0; v < circle.views.size(); ++v) {
    const double cost = cost_of(slot, circle.views[v], circle.probability[v]);
    if (cost < best.cost) best = {cost, v};
  }
  return best;
}

/// Least cost over all ways to give circles to the slots of a set, circle after circle.
class AssignmentTable {
 public:
  AssignmentTable(std::size_t slots, std::size_t circles)
      : sets_(std::size_t{1} << slots), slots_(slots), pairs_(slots * circles), taken_(sets_ * circles, -1) {}

  Pairing& at(std::size_t slot, std::size_t circle) { return pairs_[circle * slots_ + slot]; }

  std::vector<SlotMatch> solve() {
    const std::size_t circles = pairs_.size() / slots_;
    std::vector<double> least(sets_, barred);
    least[0] = 0;
    for (std::size_t c = 0; c < circles; ++c) least = with_circle(c, least);
    std::vector<SlotMatch> matches;
    auto set = static_cast<std::size_t>(std::min_element(least.begin(), least.end()) - least.begin());
    for (std::size_t c = circles; c-- > 0;) {
      const int slot = taken_[c * sets_ + set];
      if (slot < 0) continue;
      const auto s = static_cast<std::size_t>(slot);
      matches.push_back({s, c, at(s, c).view});
      set &= ~(std::size_t{1} << s);
    }
    std::sort(matches.begin(), matches.end(),
              [](const SlotMatch& a, const SlotMatch& b) { return a.slot < b.slot; });
    return matches;
  }

 private:
  std::vector<double> with_circle(std::size_t c, const std::vector<double>& least) {
    std::vector<double> next = least;
    for (double& cost : next) cost += gate;  // left out
    for (std::size_t set = 0; set < sets_; ++set)
      for (std::size_t s = 0; s < slots_; ++s) {
        const std::size_t with = set | std::size_t{1} << s;
        const double cost = least[set] + at(s, c).cost;
        if (with == set || !(cost < next[with])) continue;
        next[with] = cost;
        taken_[c * sets_ + with] = static_cast<int>(s);
      }
    return next;
  }

  std::size_t sets_, slots_;
  std::vector<Pairing> pairs_;
  std::vector<int> taken_;  ///< slot that the circle was given when the set came about; -1: none
};

}  // namespace

std::vector<SlotMatch> assign_slots(const DeckState& state, const SlotLayout& layout,
                                    const Eigen::Vector3d& aircraft_odometry_m, double attitude_variance_rad2,
                                    const std::vector<CircleCandidates>& circles) {
  AssignmentTable table(layout.size(), circles.size());
  const double reach_m = layout.spacing_m() / 2 + 1;  // no circle farther away can be within the gate
  for (std::size_t s = 0; s < layout.size(); ++s) {
    const Eigen::Vector3d place_m = place_on_deck(state.mean, layout.slots_m[s]).value - aircraft_odometry_m;
    std::optional<ExpectedSlot> slot;
    for (std::size_t c = 0; c < circles.size(); ++c) {
      const auto& views = circles[c].views;
      if (views.empty() || (views.front().from_aircraft_ned_m - place_m).head<2>().norm() > reach_m) continue;
      if (!slot) slot = expect_slot(state, layout.slots_m[s], aircraft_odometry_m, attitude_variance_rad2);
      table.at(s, c) = pair(*slot, circles[c]);
    }
  }
  return table.solve();
}

double worst_slot_sigma_m(const DeckState& state, const SlotLayout& layout) {
  double worst_m2 = 0;
  for (const Eigen::Vector2d& slot_m : layout.slots_m) {
    const auto by_state = place_on_deck(state.mean, slot_m).by_state.topRows<2>().eval();
    const Eigen::Matrix2d covariance = by_state * state.covariance * by_state.transpose();
    const double middle = covariance.trace() / 2;
    const double away = std::hypot((covariance(0, 0) - covariance(1, 1)) / 2, covariance(0, 1));
    worst_m2 = std::max(worst_m2, middle + away);
  }
  return std::sqrt(worst_m2);
}

}  // namespace stevedore
