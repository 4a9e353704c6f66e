// What one frame shows of a deck, what one radio message says of it, and how both follow from its state.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "platform/deck_motion.hpp"

namespace stevedore {

/// Of one circle: from the aircraft to its centre (three, NED), the normal's north and east parts.
constexpr Eigen::Index numbers_per_circle = 5;
using CircleNumbers = Eigen::Matrix<double, numbers_per_circle, 1>;
using CircleNoise = Eigen::Matrix<double, numbers_per_circle, numbers_per_circle>;

/// One circle as seen, along NED's axes as the aircraft's own attitude has them.
struct CircleView {
  Eigen::Vector3d from_aircraft_ned_m;  ///< to the circle's centre
  Eigen::Matrix3d covariance_m2;
  Eigen::Vector3d normal_ned;       ///< unit, up from the deck
  double normal_variance_rad2 = 0;  ///< in each of its two directions

  [[nodiscard]] CircleNumbers numbers() const;
  [[nodiscard]] CircleNoise noise() const;  ///< of its own; what it shares with others is not in it
};

/// Circles of one deck in one frame, each with its place on the deck (forward, right; m).
struct DeckSight {
  std::int64_t utime = 0;
  Eigen::Vector3d aircraft_odometry_m;
  double attitude_variance_rad2 = 0;  ///< of what changes from frame to frame; common to all circles in it
  std::vector<Eigen::Vector2d> places_m;
  std::vector<CircleView> circles;
};

/// What a platform says of itself, in the odometry frame, heading as the filter counts it (not turned by
/// periods of the layout).
struct DeckReport {
  std::int64_t utime = 0;
  Eigen::Vector2d position_odometry_m;
  Eigen::Vector2d velocity_mps;
  double heading_rad = 0;
};

/// Numbers that a measurement gives, with their derivatives by the state and their noise.
struct Innovation {
  Eigen::VectorXd value;
  Eigen::Matrix<double, Eigen::Dynamic, at::size> by_state;
  Eigen::MatrixXd noise;
};

/// The deck's attitude: heading, then pitch, then roll (as an aircraft's).
Eigen::Matrix3d ned_from_deck(const DeckVector& mean);
Eigen::Vector3d deck_center_odometry_m(const DeckVector& mean);

/// A vector that depends on the state.
struct Dependent {
  Eigen::Vector3d value;
  Eigen::Matrix<double, 3, at::size> by_state;
};
/// Where a place on the deck is, in odometry.
Dependent place_on_deck(const DeckVector& mean, const Eigen::Vector2d& place_m);
/// The deck's normal, up.
Dependent deck_normal(const DeckVector& mean);

/// What the aircraft should see of a circle.
struct ExpectedCircle {
  CircleNumbers value;
  Eigen::Matrix<double, numbers_per_circle, at::size> by_state;
  Eigen::Matrix<double, numbers_per_circle, 3> by_attitude;  ///< by a rotation of all that is seen
};
ExpectedCircle expected_circle(const DeckVector& mean, const Eigen::Vector2d& place_m,
                               const Eigen::Vector3d& aircraft_odometry_m);

Innovation innovation_of(const DeckVector& mean, const DeckSight& sight);

/// North, east, both velocities, heading.
Innovation innovation_of(const DeckVector& mean, const DeckReport& report);

/// To (-pi, pi].
double wrapped(double angle_rad);

}  // namespace stevedore
