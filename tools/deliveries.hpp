// What became of the cargoes, as TRUTH has it.
#pragma once

#include <stevedore/truth_t.hpp>

#include <vector>

namespace stevedore {

/// Of each cargo that stands upright in a circle of another platform than the one it stood on at the start:
/// how far its rim is off the circle's middle, along the ground. start: the first TRUTH of the flight; now:
/// any later one.
std::vector<double> drop_errors_m(const truth_t& start, const truth_t& now);

}  // namespace stevedore
