#include "platform/deck_motion.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace stevedore {
namespace {

using std::numbers::pi;
constexpr double rad_per_deg = pi / 180;

using Course = Eigen::Matrix<double, at::course_size, at::course_size>;

// ---- the course over ground ----

constexpr double acceleration_time_s = 3;  // braking from 1.5 m/s takes that long at 0.5 m/s2
constexpr double turn_sigma_radps = 0.12;  // 1.5 m/s round a circle of 12 m
constexpr double turn_time_s = 20;         // a turn once begun goes on
constexpr double longest_step_s = 0.5;     // 0.06 rad of turn: its square is nothing
constexpr double fastest_mps = 1.5;

/// x' = f(x) for the course's mean, and its derivative by x.
Course move_course(Eigen::Ref<DeckVector> mean, double dt_s) {
  const double keep = std::exp(-dt_s / acceleration_time_s), keep_turn = std::exp(-dt_s / turn_time_s);
  // integrals of a decaying acceleration, once and twice (Singer 1970)
  const double to_velocity_s = acceleration_time_s * (1 - keep);
  const double to_position_s2 = acceleration_time_s * (dt_s - to_velocity_s);
  const double angle_rad = mean[at::turn_rate] * dt_s;
  const Eigen::Matrix2d turn = Eigen::Rotation2Dd(angle_rad).toRotationMatrix();
  const Eigen::Matrix2d half_turn = Eigen::Rotation2Dd(angle_rad / 2).toRotationMatrix();
  Eigen::Matrix2d quarter;  // turns by +90 degrees: derivative of a rotation
  quarter << 0, -1, 1, 0;

  Course f = Course::Identity();
  f.block<2, 2>(at::north, at::velocity_north) = half_turn * dt_s;
  f.block<2, 2>(at::north, at::acceleration_north) = Eigen::Matrix2d::Identity() * to_position_s2;
  f.block<2, 2>(at::velocity_north, at::velocity_north) = turn;
  f.block<2, 2>(at::velocity_north, at::acceleration_north) = Eigen::Matrix2d::Identity() * to_velocity_s;
  f.block<2, 2>(at::acceleration_north, at::acceleration_north) = Eigen::Matrix2d::Identity() * keep;
  f(at::heading, at::turn_rate) = turn_time_s * (1 - keep_turn);
  f(at::turn_rate, at::turn_rate) = keep_turn;
  mean.head<at::course_size>() = (f * mean.head<at::course_size>()).eval();

  const Eigen::Vector2d velocity_mps = mean.segment<2>(at::velocity_north);
  f.block<2, 1>(at::velocity_north, at::turn_rate) = quarter * velocity_mps * dt_s;
  f.block<2, 1>(at::north, at::turn_rate) = quarter * velocity_mps * (dt_s * dt_s / 2);
  return f;
}

/// Noise of position, velocity and acceleration over a step in which the acceleration is white-driven so that
/// its variance stays what it is; to leading order in the step, which is short against its time.
Course course_noise(double dt_s, double acceleration_sigma_mps2) {
  Course q = Course::Zero();
  const double jerk = 2 * acceleration_sigma_mps2 * acceleration_sigma_mps2 / acceleration_time_s;
  const double d1 = dt_s, d2 = d1 * dt_s, d3 = d2 * dt_s, d4 = d3 * dt_s, d5 = d4 * dt_s;
  for (const Eigen::Index axis : {0, 1}) {
    const Eigen::Index p = at::north + axis, v = at::velocity_north + axis, a = at::acceleration_north + axis;
    q(p, p) = jerk * d5 / 20;
    q(p, v) = q(v, p) = jerk * d4 / 8;
    q(p, a) = q(a, p) = jerk * d3 / 6;
    q(v, v) = jerk * d3 / 3;
    q(v, a) = q(a, v) = jerk * d2 / 2;
    q(a, a) = jerk * d1;
  }
  const double turning = 2 * turn_sigma_radps * turn_sigma_radps / turn_time_s;
  q(at::turn_rate, at::turn_rate) = turning * d1;
  q(at::heading, at::turn_rate) = q(at::turn_rate, at::heading) = turning * d2 / 2;
  q(at::heading, at::heading) = turning * d3 / 3;
  return q;
}

// ---- the waves ----

constexpr std::array<double, 2> wave_periods_s = {5.4, 6.6};
/// A wave keeps its phase for about a minute, ten periods.
constexpr double wave_damping_radps = 0.015;

/// Exact over any step: of the damped oscillator x'' = -rate^2 x - 2 damping x'.
Eigen::Matrix2d swing_on(double rate_radps, double dt_s) {
  const double free = std::sqrt(rate_radps * rate_radps - wave_damping_radps * wave_damping_radps);
  const double c = std::cos(free * dt_s), s = std::sin(free * dt_s) / free;
  Eigen::Matrix2d f;
  f << c + wave_damping_radps * s, s, -rate_radps * rate_radps * s, c - wave_damping_radps * s;
  return f * std::exp(-wave_damping_radps * dt_s);
}

/// Covariance of (value, rate) of one of the two waves when left alone.
Eigen::Matrix2d swing_variance(double rate_radps, double sigma) {
  const double variance = sigma * sigma / static_cast<double>(wave_periods_s.size());
  return Eigen::Vector2d(variance, variance * rate_radps * rate_radps).asDiagonal();
}

constexpr std::array<Eigen::Index, 3> swinging = {at::heave, at::roll, at::pitch};

// ---- what the sensors get wrong ----

constexpr double attitude_error_time_s = 100;  // the estimator of the autopilot works over minutes
constexpr double reported_error_time_s = 60;   // so do the fixes of satellite navigation
constexpr double heading_error_time_s = 300;   // a compass's error changes with the course only
constexpr double position_error_sigma_m = 3;   // the platform's 2 to 3 m and the aircraft's 1.5

constexpr double told_layout_sigma = 0.003;   // half a centimetre in 1.6 m
constexpr double learnt_layout_sigma = 0.05;  // four circles from 12 m, each to 5 cm

}  // namespace

double swing(const DeckVector& mean, Eigen::Index part) {
  return mean[part] + mean[part + 2];
}

double swing_rate(const DeckVector& mean, Eigen::Index part) {
  return mean[part + 1] + mean[part + 3];
}

DeckMotion::DeckMotion(const PlatformSettings& settings)
    : acceleration_sigma_mps2_(settings.acceleration_sigma_mps2),
      heave_sigma_m_(settings.heave_sigma_m),
      tilt_sigma_rad_(settings.tilt_sigma_deg * rad_per_deg),
      scale_sigma_(settings.scale_sigma),
      layout_sigma_(settings.layout == "learn" && settings.slots.empty() ? learnt_layout_sigma
                                                                         : told_layout_sigma) {
  const double attitude_rad = settings.attitude_bias_deg * rad_per_deg;
  decays_ = {{{at::attitude_error, attitude_error_time_s, attitude_rad},
              {at::attitude_error + 1, attitude_error_time_s, attitude_rad},
              {at::attitude_error + 2, attitude_error_time_s, attitude_rad},
              {at::reported_position_error, reported_error_time_s, position_error_sigma_m},
              {at::reported_position_error + 1, reported_error_time_s, position_error_sigma_m},
              {at::reported_heading_error, heading_error_time_s,
               settings.reported_heading_sigma_deg * rad_per_deg}}};
}

DeckState DeckMotion::unknown() const {
  constexpr double anywhere_m = 1000;
  DeckState state;
  DeckVector sigma = DeckVector::Zero();
  sigma.segment<2>(at::north).setConstant(anywhere_m);
  sigma[at::down] = anywhere_m;
  sigma.segment<2>(at::velocity_north).setConstant(fastest_mps / std::numbers::sqrt3);  // of a uniform one
  sigma.segment<2>(at::acceleration_north).setConstant(acceleration_sigma_mps2_);
  sigma[at::heading] = pi / std::numbers::sqrt3;
  sigma[at::turn_rate] = turn_sigma_radps;
  sigma[at::scale_error] = scale_sigma_;
  sigma[at::layout_error] = layout_sigma_;
  for (const Decay& decay : decays_) sigma[decay.place] = decay.sigma;
  state.covariance = sigma.cwiseAbs2().asDiagonal();
  for (const Eigen::Index part : swinging) {
    const double swing_sigma = part == at::heave ? heave_sigma_m_ : tilt_sigma_rad_;
    for (Eigen::Index wave = 0; wave < 2; ++wave) {
      const double rate_radps = 2 * pi / wave_periods_s[static_cast<std::size_t>(wave)];
      state.covariance.block<2, 2>(part + 2 * wave, part + 2 * wave) =
          swing_variance(rate_radps, swing_sigma);
    }
  }
  return state;
}

DeckState DeckMotion::predicted(DeckState state, double ahead_s, const Disturbance& disturbance) const {
  constexpr double most_steps = 600;  // five minutes; after that nothing is known that steps could spoil
  const int steps = static_cast<int>(std::clamp(std::ceil(ahead_s / longest_step_s), 1.0, most_steps));
  for (int i = 0; i < steps && ahead_s > 0; ++i) step(state, ahead_s / steps, disturbance);
  return state;
}

/// The transition is block-diagonal; its blocks are put on the rows of the covariance, then on its columns.
void DeckMotion::step(DeckState& state, double dt_s, const Disturbance& disturbance) const {
  DeckMatrix& p = state.covariance;
  const Course course = move_course(state.mean, dt_s);
  std::array<Eigen::Matrix2d, 2> waves;
  for (std::size_t w = 0; w < waves.size(); ++w) waves[w] = swing_on(2 * pi / wave_periods_s[w], dt_s);
  for (const Eigen::Index part : swinging)
    for (Eigen::Index w = 0; w < 2; ++w)
      state.mean.segment<2>(part + 2 * w) =
          (waves[static_cast<std::size_t>(w)] * state.mean.segment<2>(part + 2 * w)).eval();
  DeckVector keep = DeckVector::Ones();
  for (const Decay& decay : decays_) keep[decay.place] = std::exp(-dt_s / decay.time_s);
  state.mean = state.mean.cwiseProduct(keep);

  for (int side = 0; side < 2; ++side) {
    p.topRows<at::course_size>() = (course * p.topRows<at::course_size>()).eval();
    for (const Eigen::Index part : swinging)
      for (Eigen::Index w = 0; w < 2; ++w)
        p.middleRows<2>(part + 2 * w) =
            (waves[static_cast<std::size_t>(w)] * p.middleRows<2>(part + 2 * w)).eval();
    for (const Decay& decay : decays_) p.row(decay.place) *= keep[decay.place];
    p.transposeInPlace();
  }

  p.topLeftCorner<at::course_size, at::course_size>() +=
      course_noise(dt_s, disturbance.acceleration_sigma_mps2);
  p.diagonal().segment<2>(at::north).array() += disturbance.odometry_rate_m2ps * dt_s;
  p(at::down, at::down) += disturbance.odometry_rate_m2ps * dt_s;
  for (const Eigen::Index part : swinging)
    for (Eigen::Index w = 0; w < 2; ++w) {
      const Eigen::Matrix2d& f = waves[static_cast<std::size_t>(w)];
      const Eigen::Matrix2d still = swing_variance(2 * pi / wave_periods_s[static_cast<std::size_t>(w)],
                                                   part == at::heave ? heave_sigma_m_ : tilt_sigma_rad_);
      p.block<2, 2>(part + 2 * w, part + 2 * w) += still - f * still * f.transpose();
    }
  for (const Decay& decay : decays_)
    p(decay.place, decay.place) += decay.sigma * decay.sigma * (1 - keep[decay.place] * keep[decay.place]);
}

}  // namespace stevedore
