// Wind: a mean from a drawn direction, and Dryden's turbulence.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "sim_proc/world/dice.hpp"

namespace stevedore::world {

struct WindSettings {
  double mean_mps = 5;
  double turbulence_mps = 1;  ///< rms of each horizontal component
};

/// Turbulence after MIL-F-8785C (1980), 3.7.2 and 3.7.3: forming filters of the Dryden spectra with the scale
/// lengths of low altitude, discretised exactly; carried past by the mean wind, as a hovering aircraft meets
/// it. It begins in its steady state.
class Wind {
 public:
  Wind(std::uint64_t seed, const WindSettings& settings, double step_s);

  void step();
  [[nodiscard]] const Eigen::Vector3d& mean_ned_mps() const { return mean_ned_mps_; }
  [[nodiscard]] Eigen::Vector3d gust_ned_mps() const;

 private:
  /// sigma * sqrt(2 T / pi) / (1 + T s): along the mean wind.
  struct Along {
    double keep, kick_mps;
    double value_mps;
  };
  /// sigma * sqrt(T / pi) (1 + sqrt(3) T s) / (1 + T s)^2: across it, and vertical.
  struct Across {
    double time_s;
    Eigen::Matrix2d keep, kick;
    Eigen::Vector2d state;

    [[nodiscard]] double value_mps() const;
  };
  [[nodiscard]] Along along(double sigma_mps, double time_s, double step_s);
  [[nodiscard]] Across across(double sigma_mps, double time_s, double step_s);

  Dice dice_;
  Eigen::Vector3d downwind_ned_;
  Eigen::Vector3d mean_ned_mps_;
  Along along_;
  Across across_, vertical_;
};

}  // namespace stevedore::world
