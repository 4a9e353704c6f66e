// An error that wanders: known in size, never by the next look.
#pragma once

#include <Eigen/Core>
#include <cmath>

#include "sim_proc/world/dice.hpp"

namespace stevedore::world {

inline Eigen::Vector3d normal3(double sigma, Dice& dice) {
  const double x = dice.normal(sigma), y = dice.normal(sigma), z = dice.normal(sigma);
  return {x, y, z};
}

/// First-order Gauss-Markov process (Gelb 1974) in three axes, stationary from the start: rms sigma each,
/// correlation exp(-t / time_s). It is stepped once a reading.
class GaussMarkov {
 public:
  GaussMarkov(double sigma, double time_s, double period_s, Dice& dice)
      : keep_(std::exp(-period_s / time_s)),
        kick_(sigma * std::sqrt(1 - keep_ * keep_)),
        value_(normal3(sigma, dice)) {}

  const Eigen::Vector3d& step(Dice& dice) {
    value_ = keep_ * value_ + normal3(kick_, dice);
    return value_;
  }

 private:
  double keep_, kick_;
  Eigen::Vector3d value_;
};

}  // namespace stevedore::world
