// A random swing with a given rms: a sum of sinusoids, so that it can be asked for any time and has an exact
// rate.
#pragma once

#include <array>

#include "sim_proc/world/dice.hpp"

namespace stevedore::world {

class Oscillation {
 public:
  /// rms in the unit of the value; the periods are spread evenly over the range given, phases are drawn.
  Oscillation(double rms, double shortest_s, double longest_s, Dice& dice);

  struct At {
    double value = 0;
    double rate = 0;  ///< its derivative, per second
  };
  [[nodiscard]] At at(double time_s) const;

 private:
  struct Wave {
    double amplitude = 0;
    double rate_radps = 0;
    double phase_rad = 0;
  };
  std::array<Wave, 3> waves_;  ///< three: irregular, yet never more than sqrt(6) = 2.4 rms
};

}  // namespace stevedore::world
