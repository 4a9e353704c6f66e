// From edges to marks: a ring's edges are one mark.
#pragma once

#include <vector>

#include "detector_proc/ellipse_search.hpp"

namespace stevedore {

struct MarkEdges {
  EllipseEdge outer;
  std::optional<EllipseEdge> inner;
};

/// Largest first; concentric edges are one mark.
std::vector<MarkEdges> group_rings(std::vector<EllipseEdge> edges, double min_ring_ratio);

}  // namespace stevedore
