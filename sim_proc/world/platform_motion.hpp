// How a platform moves: its course over ground, and what the sea does to it. Analytic in time: any time can
// be asked, in any order, and velocities are exact derivatives.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "sim_proc/world/oscillation.hpp"
#include "sim_proc/world/rigid.hpp"
#include "sim_proc/world/speed_profile.hpp"

namespace stevedore::world {

/// What a sea state stands for: rms values, periods are 5 to 7 s.
struct Sea {
  double heave_m = 0;
  double tilt_rad = 0;  ///< of roll, and of pitch
};
Sea sea_of(int sea_state);  ///< 0..4; others: std::invalid_argument

enum class Manner { straight, turning, stop_and_go };

/// The course that both platforms of a seed keep to: to and fro on a line, round a circle, or by stages along
/// a line. At most 1.5 m/s; they stay 15 to 30 m apart, within 60 m of the origin, and clear of the pad
/// there.
struct Formation {
  Manner manner = Manner::straight;
  Eigen::Vector2d center_m = Eigen::Vector2d::Zero();  ///< north, east
  double heading_rad = 0;                              ///< of the line; of the first platform's radius
  double turn_radius_m = 0;                            ///< 0: a line
  Eigen::Vector2d apart_m = Eigen::Vector2d::Zero();   ///< on a line: from the first platform to the second
  double apart_rad = 0;                                ///< on a circle: seen from its centre
  SpeedProfile speed{{{1, 0}}};
  double phase_s = 0;  ///< of the profile at time 0
};
Formation draw_formation(std::uint64_t seed);

class PlatformMotion {
 public:
  /// platform: 0 or 1.
  PlatformMotion(std::uint64_t seed, int platform, int sea_state);

  /// Deck axes: x forward, y right, z down; origin at the middle of the deck's upper side.
  [[nodiscard]] Rigid at(double time_s) const;

 private:
  /// Over ground, without the sea.
  struct Track {
    Eigen::Vector2d position_m;
    Eigen::Vector2d velocity_mps;
    double heading_rad;
    double turn_radps;
  };
  [[nodiscard]] Track on_line(double distance_m, double speed_mps) const;
  [[nodiscard]] Track on_circle(double distance_m, double speed_mps) const;

  PlatformMotion(std::uint64_t seed, int platform, const Sea& sea, Dice dice);

  int platform_;
  Formation formation_;
  double rest_down_m_;  ///< z of the deck in a calm sea
  Oscillation sway_m_;  ///< along the course: no two platforms keep their distance to the centimetre
  Oscillation heave_m_, roll_rad_, pitch_rad_;
  Oscillation steering_rad_;
};

}  // namespace stevedore::world
