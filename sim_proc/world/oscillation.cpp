#include "sim_proc/world/oscillation.hpp"

#include <cmath>
#include <cstddef>
#include <numbers>

namespace stevedore::world {

Oscillation::Oscillation(double rms, double shortest_s, double longest_s, Dice& dice) {
  const double band_s = (longest_s - shortest_s) / static_cast<double>(waves_.size());
  double power = 0;
  for (std::size_t i = 0; i < waves_.size(); ++i) {
    const double from_s = shortest_s + band_s * static_cast<double>(i);
    // away from the bands' ends: two waves of one period would only be one, and the rms another
    const double period_s = dice.uniform(from_s + 0.2 * band_s, from_s + 0.8 * band_s);
    waves_[i] = {dice.uniform(0.6, 1.0), 2 * std::numbers::pi / period_s,
                 dice.uniform(0, 2 * std::numbers::pi)};
    power += waves_[i].amplitude * waves_[i].amplitude / 2;
  }
  for (Wave& wave : waves_) wave.amplitude *= rms / std::sqrt(power);
}

Oscillation::At Oscillation::at(double time_s) const {
  At at;
  for (const Wave& wave : waves_) {
    const double angle_rad = wave.rate_radps * time_s + wave.phase_rad;
    at.value += wave.amplitude * std::sin(angle_rad);
    at.rate += wave.amplitude * wave.rate_radps * std::cos(angle_rad);
  }
  return at;
}

}  // namespace stevedore::world
