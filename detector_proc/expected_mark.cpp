#include "detector_proc/expected_mark.hpp"

#include <algorithm>
#include <cmath>

#include "detector_proc/edge_owners.hpp"
#include "detector_proc/mark_fit.hpp"
#include "detector_proc/profile_search.hpp"

namespace stevedore {

double mismatch(const Ellipse& found, const Ellipse& expected) {
  return std::hypot(found.u_px - expected.u_px, found.v_px - expected.v_px) / expected.b_px +
         std::abs(std::log(found.a_px / expected.a_px)) + std::abs(std::log(found.b_px / expected.b_px)) / 2;
}

int reduction_for(const Detection& expected) {
  // what a 5 pixels wide derivative tells apart: the two edges of a ring, of which the thinnest usual one is
  // a fifth of its radius wide
  constexpr double least_ring_px = 5, usual_ring_ratio = 0.2;
  const double b_px = expected.outer.ellipse.b_px;
  const double ring_px = expected.inner ? b_px - expected.inner->ellipse.b_px : usual_ring_ratio * b_px;
  return std::max(1, static_cast<int>(std::min(ring_px, usual_ring_ratio * b_px) / least_ring_px));
}

namespace {

/// A ring's inner edge, where it was in the outer one.
void add_inner(const cv::Mat& image, const Detection& expected, int factor, const DetectorSettings& settings,
               MarkEdges& mark) {
  Ellipse guess = mark.outer.ellipse;
  guess.a_px *= expected.inner->ellipse.a_px / expected.outer.ellipse.a_px;
  guess.b_px *= expected.inner->ellipse.b_px / expected.outer.ellipse.b_px;
  const Bright opposite = mark.outer.bright == Bright::within ? Bright::without : Bright::within;
  const auto inner = look_closely(image, guess, opposite, factor, settings);
  if (inner && one_ring(*inner, mark.outer, settings.min_ring_ratio)) mark.inner = *inner;
}

}  // namespace

std::optional<Detection> find_expected(const cv::Mat& image, const Detection& expected,
                                       const DetectorSettings& settings, const Optics& optics) {
  const Ellipse& place = expected.outer.ellipse;
  const int factor = reduction_for(expected);
  const Ellipse here = lessened(place, factor);
  constexpr double reach_share = 0.4;
  auto marks = group_rings(look_across(image, here, factor, reach_share * here.b_px, settings),
                           settings.min_ring_ratio);
  MarkEdges* nearest = nullptr;
  double least = most_mismatch;
  for (MarkEdges& mark : marks) {
    const double m = mismatch(enlarged(mark.outer.ellipse, factor), place);
    if (m < least) least = m, nearest = &mark;
  }
  if (!nearest) return std::nullopt;
  if (!nearest->inner && expected.inner) add_inner(image, expected, factor, settings, *nearest);
  // the tracker smooths over frames: a quarter of what a whole frame's marks are given
  StripCounts strips = strips_of(settings);
  strips = {(strips.first_rounds + 1) / 2, (strips.last_round + 3) / 4};
  Detection found = detection_of(*nearest, LightImage(image, optics.light), factor, strips);
  found.label = Label::circle;
  const Ellipse& inside = nearest->inner ? nearest->inner->ellipse : nearest->outer.ellipse;
  if (is_plain_within(image, inside, factor)) found.occupied = false;
  return found;
}

}  // namespace stevedore
