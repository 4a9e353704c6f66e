#include "detector_proc/evidence.hpp"

#include <algorithm>
#include <cmath>

namespace stevedore {

double best_log_odds(const EdgeSupport& support) {
  return 9.6 * support.coverage() + 7.85 * std::log(std::clamp(support.supported_px, 1.0, 150.0)) - 34.8;
}

double log_odds(const EdgeSupport& support) {
  return best_log_odds(support) - 32.5 * support.rms_px;
}

}  // namespace stevedore
