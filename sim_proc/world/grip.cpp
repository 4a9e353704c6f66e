#include "sim_proc/world/grip.hpp"

#include <algorithm>
#include <cmath>

namespace stevedore::world {

std::optional<double> Grip::step(int handle, const HookMiss& miss, double step_s) {
  const double share = std::max({miss.horizontal_m / max_horizontal_m,
                                 std::abs(miss.vertical_m) / max_vertical_m, miss.speed_mps / max_speed_mps});
  if (share > 1 || handle != handle_) {
    handle_ = handle;
    held_s_ = 0;
    if (share > 1) return std::nullopt;
  }
  held_s_ += step_s;
  if (held_s_ < hold_s - step_s / 2) return std::nullopt;
  held_s_ = 0;
  return share;
}

/// None up to 0.8 of the limits, then rising to one half at the limits themselves.
double Grip::chance_to_slip(double share_of_limits) {
  return 0.5 * std::clamp((share_of_limits - 0.8) / 0.2, 0.0, 1.0);
}

}  // namespace stevedore::world
