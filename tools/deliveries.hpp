// What became of the cargoes, as TRUTH has it.
#pragma once

#include <stevedore/truth_t.hpp>

#include <cstdint>
#include <vector>

namespace stevedore {

/// A cargo that stands upright in a circle of another platform than the one it stood on at the start.
struct BroughtCargo {
  std::int16_t cargo = 0;
  double off_m = 0;  ///< of its rim from the circle's middle, along the ground
};

/// start: the first TRUTH of the flight; now: any later one.
std::vector<BroughtCargo> brought_cargoes(const truth_t& start, const truth_t& now);
/// The off_m of each.
std::vector<double> drop_errors_m(const truth_t& start, const truth_t& now);

}  // namespace stevedore
