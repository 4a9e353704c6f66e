#include "platform/layout_match.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace stevedore {
namespace {

/// From 12 m a circle's centre is known to some 5 cm, and a deck tilted by 10 degrees looks 3 cm narrower
/// between neighbours.
constexpr double place_tolerance_m = 0.25;

/// Height of a circle over the plane that all are on: 1 % of 12 m, and ten degrees of tilt on 1.2 m.
constexpr double height_tolerance_m = 0.4;

constexpr double least_spacing_m = 1.05;  // circles are a metre across
constexpr double most_spacing_m = 3.3;    // four in a row on a deck of ten metres

using Circles = std::vector<Eigen::Vector3d>;

/// Turn, scale and shift in the plane: north + i east = factor (forward + i right) + shift.
struct Similarity {
  Eigen::Vector2d forward;  ///< where one metre forward goes, scale included
  Eigen::Vector2d shift_m;

  [[nodiscard]] Eigen::Vector2d place(const Eigen::Vector2d& slot_m) const {
    return {forward.x() * slot_m.x() - forward.y() * slot_m.y() + shift_m.x(),
            forward.y() * slot_m.x() + forward.x() * slot_m.y() + shift_m.y()};
  }
};

/// That takes two points to two points.
Similarity through(const Eigen::Vector2d& a, const Eigen::Vector2d& b, const Eigen::Vector2d& to_a,
                   const Eigen::Vector2d& to_b) {
  const Eigen::Vector2d from = b - a, to = to_b - to_a;
  Similarity s;
  s.forward = Eigen::Vector2d(from.dot(to), from.x() * to.y() - from.y() * to.x()) / from.squaredNorm();
  s.shift_m.setZero();
  s.shift_m = to_a - s.place(a);
  return s;
}

using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;

Pairs pairs_under(const Similarity& s, const SlotLayout& layout, const Circles& circles_m) {
  Pairs pairs;
  for (std::size_t slot = 0; slot < layout.size(); ++slot) {
    const Eigen::Vector2d place_m = s.place(layout.slots_m[slot]);
    double nearest_m = place_tolerance_m;
    std::optional<std::size_t> taken;
    for (std::size_t c = 0; c < circles_m.size(); ++c) {
      const double off_m = (circles_m[c].head<2>() - place_m).norm();
      if (off_m >= nearest_m) continue;
      nearest_m = off_m;
      taken = c;
    }
    if (taken) pairs.emplace_back(slot, *taken);
  }
  return pairs;
}

/// Least squares over all pairs (Horn 1987, in the plane); unit scale unless it is free.
LayoutMatch fitted(const SlotLayout& layout, bool scalable, const Pairs& pairs, const Circles& circles_m) {
  const auto n = static_cast<double>(pairs.size());
  Eigen::Vector2d slots_middle_m = Eigen::Vector2d::Zero();
  Eigen::Vector3d middle_m = Eigen::Vector3d::Zero();
  for (const auto& [slot, circle] : pairs) {
    slots_middle_m += layout.slots_m[slot] / n;
    middle_m += circles_m[circle] / n;
  }
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  double squares = 0;
  for (const auto& [slot, circle] : pairs) {
    const Eigen::Vector2d from = layout.slots_m[slot] - slots_middle_m;
    const Eigen::Vector2d to = circles_m[circle].head<2>() - middle_m.head<2>();
    sum += Eigen::Vector2d(from.dot(to), from.x() * to.y() - from.y() * to.x());
    squares += from.squaredNorm();
  }
  const double scale = scalable ? sum.norm() / squares : 1;
  Similarity s{sum.normalized() * scale, Eigen::Vector2d::Zero()};
  s.shift_m = middle_m.head<2>() - s.place(slots_middle_m);
  LayoutMatch match{scalable ? layout.scaled(scale) : layout,
                    {s.shift_m.x(), s.shift_m.y(), middle_m.z()},
                    std::atan2(sum.y(), sum.x()),
                    pairs};
  for (const auto& [slot, circle] : pairs)
    match.rms_m += (circles_m[circle].head<2>() - s.place(layout.slots_m[slot])).squaredNorm() / n;
  match.rms_m = std::sqrt(match.rms_m);
  return match;
}

bool of_one_height(const Pairs& pairs, const Circles& circles_m) {
  const auto lower = [&](const auto& a, const auto& b) {
    return circles_m[a.second].z() < circles_m[b.second].z();
  };
  const auto [high, low] = std::minmax_element(pairs.begin(), pairs.end(), lower);
  return circles_m[low->second].z() - circles_m[high->second].z() < 2 * height_tolerance_m;
}

bool same_way(const LayoutMatch& a, const LayoutMatch& b) {
  const double turn_rad = std::remainder(a.heading_rad - b.heading_rad, a.layout.period_rad);
  return (a.center_m - b.center_m).norm() < place_tolerance_m && std::abs(turn_rad) < 0.2;
}

class BestMatches {
 public:
  explicit BestMatches(std::size_t least_pairs) : most_pairs_(least_pairs) {}

  [[nodiscard]] bool worth(const Pairs& pairs) const { return pairs.size() >= most_pairs_; }
  void add(const LayoutMatch& match) {
    if (match.slots_and_circles.size() > most_pairs_) matches_.clear();
    most_pairs_ = match.slots_and_circles.size();
    for (LayoutMatch& known : matches_) {
      if (!same_way(known, match)) continue;
      if (match.rms_m < known.rms_m) known = match;
      return;
    }
    matches_.push_back(match);
  }
  std::vector<LayoutMatch> sorted() {
    std::sort(matches_.begin(), matches_.end(),
              [](const LayoutMatch& a, const LayoutMatch& b) { return a.rms_m < b.rms_m; });
    return std::move(matches_);
  }

 private:
  std::size_t most_pairs_;
  std::vector<LayoutMatch> matches_;
};

}  // namespace

std::vector<LayoutMatch> match_layout(const SlotLayout& layout, bool scalable,
                                      const std::vector<Eigen::Vector3d>& circles_m) {
  const std::size_t n = layout.size();
  BestMatches best(scalable ? n : std::min<std::size_t>(3, n));
  for (std::size_t i = 0; i < circles_m.size(); ++i)
    for (std::size_t j = 0; j < circles_m.size(); ++j) {
      const double apart_m = (circles_m[i] - circles_m[j]).head<2>().norm();
      // each pair of slots once: the other order is the circles' other order
      for (std::size_t a = 0; a < n && i != j; ++a)
        for (std::size_t b = a + 1; b < n; ++b) {
          const double slots_apart_m = (layout.slots_m[a] - layout.slots_m[b]).norm();
          const double scale = apart_m / slots_apart_m;
          if (scalable ? scale < least_spacing_m || scale > most_spacing_m
                       : std::abs(apart_m - slots_apart_m) > place_tolerance_m)
            continue;
          const Similarity s =
              through(layout.slots_m[a], layout.slots_m[b], circles_m[i].head<2>(), circles_m[j].head<2>());
          const Pairs pairs = pairs_under(s, layout, circles_m);
          if (!best.worth(pairs) || !of_one_height(pairs, circles_m)) continue;
          best.add(fitted(layout, scalable, pairs, circles_m));
        }
    }
  return best.sorted();
}

}  // namespace stevedore
