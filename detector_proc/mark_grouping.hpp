// From edges to marks: a ring's edges are one mark.
#pragma once

#include <vector>

#include "detector_proc/ellipse_search.hpp"

namespace stevedore {

struct MarkEdges {
  EllipseEdge outer;
  std::optional<EllipseEdge> inner;
};

/// Whether they are the two edges of one ring: concentric, as far as perspective and what the fits leave open
/// let them be, and not too far apart.
bool one_ring(const EllipseEdge& inner, const EllipseEdge& outer, double min_ring_ratio);

/// Largest first; concentric edges are one mark.
std::vector<MarkEdges> group_rings(std::vector<EllipseEdge> edges, double min_ring_ratio);

}  // namespace stevedore
