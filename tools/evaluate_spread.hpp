// How errors are distributed, in a few numbers.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace stevedore {

struct Spread {
  int64_t count = 0;
  double mean = 0;  ///< with sign
  double rms = 0;
  double median = 0;  ///< these three of the values without their sign
  double p95 = 0;
  double worst = 0;
};

/// Zeros for no values. Percentiles by nearest rank.
inline Spread spread_of(std::vector<double> values) {
  Spread spread;
  if (values.empty()) return spread;
  const auto count = static_cast<double>(values.size());
  for (double& value : values) {
    spread.mean += value / count;
    spread.rms += value * value / count;
    value = std::abs(value);
  }
  spread.rms = std::sqrt(spread.rms);
  std::sort(values.begin(), values.end());
  const auto at = [&](double share) {
    return values[static_cast<std::size_t>(std::max(0.0, std::ceil(share * count) - 1))];
  };
  spread.count = static_cast<int64_t>(values.size());
  spread.median = at(0.5);
  spread.p95 = at(0.95);
  spread.worst = values.back();
  return spread;
}

}  // namespace stevedore
