// Random numbers that depend on the seed and on what they are for, never on who asked first.
#pragma once

#include <cstdint>
#include <string_view>

namespace stevedore::world {

/// One stream: splitmix64 (Steele, Lea, Flood 2014), started from a hash of the seed and the stream's name.
/// Everything is defined to the bit on every machine, which std::normal_distribution is not.
class Dice {
 public:
  Dice(std::uint64_t seed, std::string_view name);

  std::uint64_t next();
  double uniform(double lowest, double highest);
  int whole(int lowest, int highest);  ///< both included
  bool chance(double probability);
  double normal(double sigma = 1);  ///< Box-Muller

 private:
  std::uint64_t state_;
};

}  // namespace stevedore::world
