// When the hook takes hold of a handle, and how well.
#pragma once

#include <optional>

namespace stevedore::world {

/// Hook against the apex of a handle.
struct HookMiss {
  double horizontal_m = 0;
  double vertical_m = 0;  ///< either sign
  double speed_mps = 0;   ///< relative
};

/// Closes once the hook has been within all limits for 0.3 s on end, told to close, at one and the same
/// handle.
class Grip {
 public:
  static constexpr double max_horizontal_m = 0.08, max_vertical_m = 0.06, max_speed_mps = 0.3;
  static constexpr double hold_s = 0.3;

  /// Once a step, with the nearest handle. Returns, in the step in which it closes, the miss as it then is as
  /// a share of its limits, 0..1.
  std::optional<double> step(int handle, const HookMiss& miss, double step_s);
  void reset() { held_s_ = 0; }

  /// A hold near the limits is a bad one: nobody can tell before it slips.
  static double chance_to_slip(double share_of_limits);

 private:
  int handle_ = -1;
  double held_s_ = 0;
};

}  // namespace stevedore::world
