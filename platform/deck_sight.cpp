#include "platform/deck_sight.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

namespace stevedore {
namespace {

/// Paint and deck are flat and in place to some millimetres; also keeps circles from being believed better
/// than the models that lead to them.
constexpr double place_sigma_m = 0.005;

constexpr double report_position_sigma_m = 0.5;  // what changes from message to message
constexpr double report_velocity_sigma_mps = 0.3;
constexpr double report_heading_sigma_rad = 0.02;

using Jacobian3 = Eigen::Matrix<double, 3, at::size>;

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// Axes about which heading, pitch and roll turn the deck, in NED.
Eigen::Matrix3d turning_axes(const DeckVector& mean) {
  const Eigen::AngleAxisd yaw(mean[at::heading], Eigen::Vector3d::UnitZ());
  const Eigen::AngleAxisd pitch(swing(mean, at::pitch), Eigen::Vector3d::UnitY());
  Eigen::Matrix3d axes;
  axes << Eigen::Vector3d::UnitZ(), yaw * Eigen::Vector3d::UnitY(), yaw * (pitch * Eigen::Vector3d::UnitX());
  return axes;
}

/// Derivative of a direction fixed to the deck.
void put_turning(const DeckVector& mean, const Eigen::Vector3d& direction_ned, Jacobian3& by_state) {
  const Eigen::Matrix3d by_angles = -cross_matrix(direction_ned) * turning_axes(mean);
  by_state.col(at::heading) = by_angles.col(0);
  for (const Eigen::Index wave : {0, 2}) {
    by_state.col(at::pitch + wave) = by_angles.col(1);
    by_state.col(at::roll + wave) = by_angles.col(2);
  }
}

/// What the error of attitude does to a vector that was turned with it, and its derivative.
Eigen::Vector3d as_measured(const DeckVector& mean, const Eigen::Vector3d& true_ned, Jacobian3& by_state) {
  const Eigen::Vector3d error_rad = mean.segment<3>(at::attitude_error);
  by_state += cross_matrix(error_rad) * by_state;
  by_state.middleCols<3>(at::attitude_error) = -cross_matrix(true_ned);
  return true_ned + error_rad.cross(true_ned);
}

}  // namespace

CircleNumbers CircleView::numbers() const {
  CircleNumbers out;
  out << from_aircraft_ned_m, normal_ned.head<2>();
  return out;
}

CircleNoise CircleView::noise() const {
  CircleNoise out = CircleNoise::Zero();
  out.topLeftCorner<3, 3>() = covariance_m2 + Eigen::Matrix3d::Identity() * (place_sigma_m * place_sigma_m);
  out.diagonal().tail<2>().setConstant(normal_variance_rad2);
  return out;
}

Eigen::Matrix3d ned_from_deck(const DeckVector& mean) {
  return (Eigen::AngleAxisd(mean[at::heading], Eigen::Vector3d::UnitZ()) *
          Eigen::AngleAxisd(swing(mean, at::pitch), Eigen::Vector3d::UnitY()) *
          Eigen::AngleAxisd(swing(mean, at::roll), Eigen::Vector3d::UnitX()))
      .toRotationMatrix();
}

Eigen::Vector3d deck_center_odometry_m(const DeckVector& mean) {
  return {mean[at::north], mean[at::east], mean[at::down] + swing(mean, at::heave)};
}

Dependent place_on_deck(const DeckVector& mean, const Eigen::Vector2d& place_m) {
  const Eigen::Vector3d unscaled_ned_m = ned_from_deck(mean).leftCols<2>() * place_m;
  const Eigen::Vector3d arm_ned_m = (1 + mean[at::layout_error]) * unscaled_ned_m;
  Dependent place{deck_center_odometry_m(mean) + arm_ned_m, Jacobian3::Zero()};
  put_turning(mean, arm_ned_m, place.by_state);
  place.by_state.col(at::layout_error) = unscaled_ned_m;
  place.by_state(0, at::north) = place.by_state(1, at::east) = place.by_state(2, at::down) = 1;
  place.by_state(2, at::heave) = place.by_state(2, at::heave + 2) = 1;
  return place;
}

Dependent deck_normal(const DeckVector& mean) {
  Dependent normal{-ned_from_deck(mean).col(2), Jacobian3::Zero()};
  put_turning(mean, normal.value, normal.by_state);
  return normal;
}

ExpectedCircle expected_circle(const DeckVector& mean, const Eigen::Vector2d& place_m,
                               const Eigen::Vector3d& aircraft_odometry_m) {
  Dependent center = place_on_deck(mean, place_m), normal = deck_normal(mean);
  center.value -= aircraft_odometry_m;
  ExpectedCircle out;
  out.by_attitude << -cross_matrix(center.value), -cross_matrix(normal.value).topRows<2>();
  const Eigen::Vector3d true_m = center.value;
  out.value << as_measured(mean, true_m, center.by_state) + mean[at::scale_error] * true_m,
      as_measured(mean, normal.value, normal.by_state).head<2>();
  center.by_state.col(at::scale_error) = true_m;  // the camera's arm is scaled too: 5 mm at most
  out.by_state << center.by_state, normal.by_state.topRows<2>();
  return out;
}

Innovation innovation_of(const DeckVector& mean, const DeckSight& sight) {
  const auto n = static_cast<Eigen::Index>(sight.circles.size()) * numbers_per_circle;
  Innovation out{Eigen::VectorXd(n), Eigen::Matrix<double, Eigen::Dynamic, at::size>(n, at::size),
                 Eigen::MatrixXd::Zero(n, n)};
  Eigen::Matrix<double, Eigen::Dynamic, 3> by_attitude(n, 3);
  for (std::size_t i = 0; i < sight.circles.size(); ++i) {
    const CircleView& circle = sight.circles[i];
    const Eigen::Index row = static_cast<Eigen::Index>(i) * numbers_per_circle;
    const ExpectedCircle expected = expected_circle(mean, sight.places_m[i], sight.aircraft_odometry_m);
    out.value.segment<numbers_per_circle>(row) = circle.numbers() - expected.value;
    out.by_state.middleRows<numbers_per_circle>(row) = expected.by_state;
    by_attitude.middleRows<numbers_per_circle>(row) = expected.by_attitude;
    out.noise.block<numbers_per_circle, numbers_per_circle>(row, row) = circle.noise();
  }
  out.noise += sight.attitude_variance_rad2 * by_attitude * by_attitude.transpose();
  return out;
}

Innovation innovation_of(const DeckVector& mean, const DeckReport& report) {
  Innovation out{Eigen::VectorXd(5), Eigen::Matrix<double, Eigen::Dynamic, at::size>::Zero(5, at::size),
                 Eigen::MatrixXd::Zero(5, 5)};
  const Eigen::Vector2d error_m = mean.segment<2>(at::reported_position_error);
  out.value.head<2>() = report.position_odometry_m - mean.segment<2>(at::north) - error_m;
  out.value.segment<2>(2) = report.velocity_mps - mean.segment<2>(at::velocity_north);
  out.value[4] = wrapped(report.heading_rad - mean[at::heading] - mean[at::reported_heading_error]);
  for (const Eigen::Index axis : {0, 1}) {
    out.by_state(axis, at::north + axis) = out.by_state(axis, at::reported_position_error + axis) = 1;
    out.by_state(2 + axis, at::velocity_north + axis) = 1;
    out.noise(axis, axis) = report_position_sigma_m * report_position_sigma_m;
    out.noise(2 + axis, 2 + axis) = report_velocity_sigma_mps * report_velocity_sigma_mps;
  }
  out.by_state(4, at::heading) = out.by_state(4, at::reported_heading_error) = 1;
  out.noise(4, 4) = report_heading_sigma_rad * report_heading_sigma_rad;
  return out;
}

double wrapped(double angle_rad) {
  return std::remainder(angle_rad, 2 * std::numbers::pi);
}

}  // namespace stevedore
