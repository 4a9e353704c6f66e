// How much speaks for an ellipse: one figure from all that was seen along it.
#pragma once

#include "detector_proc/edge_support.hpp"

namespace stevedore {

/// Log odds that these edges are an ellipse and not texture that one happens to go through.
double log_odds(const EdgeSupport& support);

/// The same if every edge found were in its place: what is below can be left.
double best_log_odds(const EdgeSupport& support);

}  // namespace stevedore
