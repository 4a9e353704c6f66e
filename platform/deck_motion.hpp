// How a deck moves, as far as a filter needs to know: its state and what time does to it.
#pragma once

#include <Eigen/Core>
#include <array>

#include "platform/platform_settings.hpp"

namespace stevedore {

/// Places of the state's parts. Positions are in the odometry frame (vehicle_history.hpp), axes as NED.
///
/// Course: position, velocity and acceleration in the plane, heading and turn rate. The velocity turns with
/// the deck; what acceleration is left decays (Singer 1970). Heave, roll and pitch: each the sum of two
/// lightly damped oscillators at either side of the middle of the 5 to 7 s that platforms swing with; their
/// sum follows any wave between and learns its phase. What the sensors get wrong for long: the camera's
/// attitude (a rotation vector in NED: measured = (1 + [error]x) true), all ranges in proportion, what
/// PLATFORM_STATE says of position and heading; and how far apart the circles are.
namespace at {
enum : Eigen::Index {
  north,
  east,
  velocity_north,
  velocity_east,
  acceleration_north,
  acceleration_east,
  heading,
  turn_rate,
  down,   ///< of the deck's middle, on average
  heave,  ///< down from there: first wave, its rate, second wave, its rate
  roll = heave + 4,
  pitch = roll + 4,
  attitude_error = pitch + 4,  ///< three
  scale_error = attitude_error + 3,
  layout_error,             ///< relative, of the distances between circles
  reported_position_error,  ///< two; of PLATFORM_STATE against the aircraft's own NED
  reported_heading_error = reported_position_error + 2,
  size
};
constexpr Eigen::Index course_size = down;
}  // namespace at

using DeckVector = Eigen::Matrix<double, at::size, 1>;
using DeckMatrix = Eigen::Matrix<double, at::size, at::size>;

struct DeckState {
  DeckVector mean = DeckVector::Zero();
  DeckMatrix covariance = DeckMatrix::Zero();
};

/// The sum of both waves, and its rate. part: at::heave, at::roll or at::pitch.
double swing(const DeckVector& mean, Eigen::Index part);
double swing_rate(const DeckVector& mean, Eigen::Index part);

/// What drives a deck off a smooth course, and the frame it is told in.
struct Disturbance {
  double acceleration_sigma_mps2 = 0;  ///< rms of the acceleration along the course and across
  double odometry_rate_m2ps = 0;       ///< how fast the odometry frame wanders: variance a second
};

class DeckMotion {
 public:
  explicit DeckMotion(const PlatformSettings& settings);

  /// What is known of a deck before anything is: at rest within what platforms do, anywhere.
  [[nodiscard]] DeckState unknown() const;

  /// In steps short enough for the course's turn to be linear.
  [[nodiscard]] DeckState predicted(DeckState state, double ahead_s, const Disturbance& disturbance) const;

 private:
  struct Decay {
    Eigen::Index place;
    double time_s;
    double sigma;  ///< when left alone
  };

  void step(DeckState& state, double dt_s, const Disturbance& disturbance) const;

  double acceleration_sigma_mps2_;
  double heave_sigma_m_, tilt_sigma_rad_, scale_sigma_, layout_sigma_;
  std::array<Decay, 6> decays_;
};

}  // namespace stevedore
