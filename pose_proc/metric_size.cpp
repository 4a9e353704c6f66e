#include "pose_proc/metric_size.hpp"

#include <cmath>
#include <cstddef>

namespace stevedore {
namespace {

/// Of the logarithm of radii: a cut edge's semi-axes err by up to 0.07, and over a deck that is 5 degrees off
/// level a mark 30 degrees off the plumb line by 0.05.
constexpr double same_size = 0.12;

/// Two decks differ in height by their waves: 0.4 m rms each (sea state 4), at 2.6 deviations.
constexpr double decks_apart_m = 1.5;

/// From any circle of a deck to any other: four in a row.
constexpr double deck_reach_m = 5;

/// What a thing that would be larger than a mark weighs against that, in circles that agree. It must outvote
/// a mark of which a third is seen and a smaller thing seen whole.
constexpr double weight_of_larger = 2;

/// What a mark's word counts: a rim of the right kind in it is as good as an edge seen whole.
double weight_of(const SupposedCircle& circle) {
  return circle.coverage + (circle.holds_cargo ? 1 : 0);
}

/// Radius of the other over the mark's, were it on the first one's deck: depths along the normal.
double log_size(const SupposedCircle& first, const SupposedCircle& other) {
  const Eigen::Vector3d& n = first.normal_camera;
  const double depth = n.dot(first.center_camera_m), other_depth = n.dot(other.center_camera_m);
  const double ratio = depth / other_depth;
  return ratio > 0 ? std::log(ratio) : HUGE_VAL;  // beyond the horizon of that deck
}

double agreement(const SupposedCircle& first, const std::vector<SupposedCircle>& circles) {
  double sum = 0;
  for (const SupposedCircle& other : circles) {
    const double size = log_size(first, other);
    if (std::abs(size) < same_size)
      sum += weight_of(other);
    else if (size > 0)
      sum -= weight_of_larger * weight_of(other);
  }
  return sum;
}

/// Where the ray of the other meets the first one's deck, from the first.
double apart_m(const SupposedCircle& first, const SupposedCircle& other) {
  return (other.center_camera_m * std::exp(log_size(first, other)) - first.center_camera_m).norm();
}

}  // namespace

std::vector<bool> have_marks_size(const std::vector<SupposedCircle>& circles) {
  std::vector<bool> have(circles.size(), true);
  const SupposedCircle* best = nullptr;
  double most = 0;
  for (const SupposedCircle& c : circles) {
    const double sum = agreement(c, circles);
    if (!best || sum > most) best = &c, most = sum;
  }
  for (std::size_t i = 0; i < circles.size(); ++i) {
    const double size = log_size(*best, circles[i]);
    if (std::abs(size) < same_size) continue;
    const double below_m =
        std::abs(best->normal_camera.dot(best->center_camera_m - circles[i].center_camera_m));
    const bool may_be_another_deck =
        std::isfinite(size) && below_m < decks_apart_m && apart_m(*best, circles[i]) > deck_reach_m;
    have[i] = may_be_another_deck;
  }
  return have;
}

}  // namespace stevedore
