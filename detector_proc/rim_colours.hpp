// What a round edge in a circle is by its colours: a cargo's, or painted.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "detector_proc/round_fit.hpp"

namespace stevedore {

/// Grey levels are as good as colours: missing channels are zero.
using PatchColour = Eigen::Array3d;

/// Within it there is no paint of the circle's own, in circle radii.
double clear_radius(const Ellipse& circle, const std::optional<EllipseFit>& inner);

/// A circle's own colours.
struct CircleColours {
  PatchColour ground, paint;
  double clear;  ///< see clear_radius

  CircleColours(const RoundPatch& patch, double clear_of_paint);
  /// Of a colour from the nearest mixture of the two: worn paint, blurred lines.
  [[nodiscard]] double off_mixtures(const PatchColour& c) const;
};

/// What is inside a round edge.
struct RimInside {
  double off_surround = 0;    ///< levels, between its core and the rest of the circle's inside
  double off_mixtures = 0;    ///< levels
  double two_sided = 0;       ///< share of its directions in which inside and outside differ
  double like_surround = 0;   ///< share of its core that looks like the rest of the circle's inside
  bool goes_through = false;  ///< a stripe of its core's colour goes on beyond it on both sides
};

RimInside inside_of(const RoundPatch& patch, const CircleColours& surface, const RoundFit& fit);

/// A cargo that stands there and is as grey as the paint or the ground is given up for it. Of a stripe across
/// a ring the ground beside it is seen within the ring; of a cargo none.
bool may_be_paint(const RoundFit& fit, const RimInside& inside);

constexpr double half_coverage = 0.5;

enum class CargoSign { cargo, perhaps, none };

/// Whether a cargo makes this round edge, be it its rim, its foot or its shadow.
CargoSign sign_of_cargo(const RoundFit& fit, const RimInside& inside);

}  // namespace stevedore
