// One edge, one ellipse: duplicates go, and what lives on other ellipses' edges.
#pragma once

#include <vector>

#include "detector_proc/ellipse_search.hpp"

namespace stevedore {

/// Keeps, best evidence first, what does not have a good part of its edge in common with a better one.
std::vector<EllipseEdge> settle_owners(std::vector<EllipseEdge> edges);

}  // namespace stevedore
