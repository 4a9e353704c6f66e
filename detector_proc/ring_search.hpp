// A painted ring has two edges: finds the outer one from the inner.
#pragma once

#include <optional>

#include "detector_proc/ellipse_search.hpp"

namespace stevedore {

/// The next edge outwards of the opposite contrast that runs round the ellipse at one scale of it.
std::optional<EllipseEdge> look_outwards(const EllipseEdge& inner, const GradientField& field,
                                         const EdgeThresholds& thresholds, const EllipseSearch& search,
                                         double min_ring_ratio);

}  // namespace stevedore
