// How well edges pin an ellipse down.
#pragma once

#include "detector_proc/edge_support.hpp"
#include "geometry/ellipse.hpp"

namespace stevedore {

/// Covariance of the ellipse through the supported samples, each of which errs by `deviation_px` along the
/// normal.
EllipseCovariance covariance_of(const Ellipse& ellipse, const EdgeSupport& support, double deviation_px);

/// Largest deviation of the edge along its normal, over the perimeter: what is extrapolated counts most.
double worst_deviation_px(const Ellipse& ellipse, const EllipseCovariance& covariance);

}  // namespace stevedore
