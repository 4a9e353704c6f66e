// How well edges pin an ellipse down.
#pragma once

#include <optional>

#include "detector_proc/edge_support.hpp"
#include "geometry/ellipse.hpp"

namespace stevedore {

/// Covariance of the ellipse through the supported samples, each of which errs by `deviation_px` along the
/// normal.
EllipseCovariance covariance_of(const Ellipse& ellipse, const EdgeSupport& support, double deviation_px);

/// What is known of an ellipse before any edge of it: semi-axes and direction are about those of another.
struct ShapePrior {
  Ellipse shape;
  double share = 0.04;  ///< deviation of the semi-axes, in semi-minor axes
};

EllipseCovariance covariance_of(const Ellipse& ellipse, const EdgeSupport& support, double deviation_px,
                                const ShapePrior& prior);

/// The ellipse that fits edges and prior best, one step from where the support was looked for: weighted least
/// squares (Tukey's weights). The support's offsets are measured from it then.
std::optional<Ellipse> refit(EdgeSupport& support, const Ellipse& ellipse, const ShapePrior& prior);

/// Largest deviation of the edge along its normal, over the perimeter: what is extrapolated counts most.
double worst_deviation_px(const Ellipse& ellipse, const EllipseCovariance& covariance);

}  // namespace stevedore
