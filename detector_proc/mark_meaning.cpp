#include "detector_proc/mark_meaning.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace stevedore {
namespace {

using std::numbers::pi;

/// Distances of one ellipse's edge from its own centre, in another's stretched frame, where that is the unit
/// circle.
struct Stretched {
  double low = 1e9, high = 0;
};

Stretched stretched(const Ellipse& e, const Ellipse& frame) {
  Ellipse centred = frame;
  centred.u_px = e.u_px;
  centred.v_px = e.v_px;
  Stretched s;
  for (int k = 0; k < 16; ++k) {
    const double radius = std::sqrt(normalized_radius_squared(centred, point_at(e, pi * k / 8)));
    s.low = std::min(s.low, radius);
    s.high = std::max(s.high, radius);
  }
  return s;
}

/// Most of the inner one's edge lies within the outer one: a bucket's rim may stand over the circle's edge.
bool lies_within(const Ellipse& inner, const Ellipse& outer) {
  int within = 0;
  for (int k = 0; k < 16; ++k)
    within += normalized_radius_squared(outer, point_at(inner, pi * k / 8)) < 1 ? 1 : 0;
  return within >= 12;
}

/// Parallel circles look alike: in the frame in which one is round so is the other, but for the perspective
/// of a rim that is nearer.
bool is_rim(const MarkEdges& mark, const Ellipse& circle) {
  constexpr double least_coverage = 0.6;  // handle and rope hide part of a rim
  constexpr double most_stretch = 1.25;
  // From a letter's bowl to a bucket as large as fits.
  constexpr double smallest = 0.15, largest = 0.85;
  const Stretched s = stretched(mark.outer.ellipse, circle);
  return mark.outer.support.coverage() > least_coverage && s.high < most_stretch * s.low &&
         s.low > smallest && s.high < largest;
}

/// Gradient magnitudes on a grid over what lies well within an ellipse.
struct InsideSamples {
  static constexpr int grid = 24;
  std::array<ushort, std::size_t{grid} * grid> magnitudes;
  int in_frame = 0, all = 0;  ///< the first in_frame magnitudes are of the all samples

  [[nodiscard]] int above(int threshold) const {
    return static_cast<int>(std::count_if(magnitudes.begin(), magnitudes.begin() + in_frame,
                                          [&](ushort m) { return m > threshold; }));
  }
};

/// Nothing: too small to say.
std::optional<InsideSamples> sample_inside(const Ellipse& e, const GradientField& field) {
  constexpr int grid = InsideSamples::grid;
  constexpr double margin_px = 4;  // reach of the derivative at the circle's own edge, blur and all
  const double share = 1 - margin_px / e.b_px;
  if (share < 0.4) return std::nullopt;
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad);
  InsideSamples samples;
  for (int i = 0; i < grid; ++i) {
    for (int j = 0; j < grid; ++j) {
      const double x = (2 * i + 1.0) / grid - 1, y = (2 * j + 1.0) / grid - 1;
      if (x * x + y * y > 1) continue;
      ++samples.all;
      const double along = share * e.a_px * x, across = share * e.b_px * y;
      const int u = static_cast<int>(std::floor(e.u_px + c * along - s * across + 0.5));
      const int v = static_cast<int>(std::floor(e.v_px + s * along + c * across + 0.5));
      if (u < 1 || v < 1 || u >= field.magnitude.cols - 1 || v >= field.magnitude.rows - 1) continue;
      samples.magnitudes[static_cast<std::size_t>(samples.in_frame++)] = field.magnitude.ptr<ushort>(v)[u];
    }
  }
  return samples;
}

/// A rim of a quarter of the circle's size has a hundredth of the samples on its edge, noise a thousandth.
bool so_few(int edges, const InsideSamples& samples) {
  return edges * 200 < samples.in_frame;
}

/// True: no edges well within the ellipse; false: some; nothing: too small or too far out to say.
std::optional<bool> plain_inside(const Ellipse& e, const GradientField& field, int threshold) {
  const auto samples = sample_inside(e, field);
  if (!samples || 2 * samples->in_frame < samples->all) return std::nullopt;
  return so_few(samples->above(threshold), *samples);
}

}  // namespace

bool nothing_inside(const Ellipse& e, const GradientField& field, double least_in_field) {
  // what is a step of two grey levels to the frame's thresholds, and more than white noise ever is: 3.5
  // medians, taken from the lowest quarter since a small circle is full of a cargo's edges
  constexpr int faintest = 2 * GradientField::step_response;
  constexpr double noise_quarters = 5.4;
  auto samples = sample_inside(e, field);
  if (!samples || samples->in_frame < least_in_field * samples->all) return false;
  if (samples->in_frame == 0) return true;
  const auto quarter = samples->magnitudes.begin() + samples->in_frame / 4;
  std::nth_element(samples->magnitudes.begin(), quarter, samples->magnitudes.begin() + samples->in_frame);
  return so_few(samples->above(std::max(faintest, static_cast<int>(noise_quarters * *quarter))), *samples);
}

std::vector<MarkMeaning> find_meanings(const std::vector<MarkEdges>& marks, const GradientField& field,
                                       const EdgeThresholds& thresholds) {
  std::vector<MarkMeaning> meanings(marks.size());
  for (std::size_t i = 0; i < marks.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const Ellipse& circle = marks[j].outer.ellipse;
      if (meanings[j].label != Label::circle || !lies_within(marks[i].outer.ellipse, circle)) continue;
      const bool rim = is_rim(marks[i], circle);
      meanings[i].label = rim ? Label::cargo : Label::unknown;
      if (rim) meanings[j].occupied = true;
      break;
    }
  }
  for (std::size_t i = 0; i < marks.size(); ++i) {
    if (meanings[i].label != Label::circle || meanings[i].occupied) continue;
    const Ellipse& inside = marks[i].inner ? marks[i].inner->ellipse : marks[i].outer.ellipse;
    if (plain_inside(inside, field, thresholds.start) == true) meanings[i].occupied = false;
  }
  return meanings;
}

}  // namespace stevedore
