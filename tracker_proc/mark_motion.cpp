#include "tracker_proc/mark_motion.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace stevedore {
namespace {

// Edges are found on a grid of pixels; a fit's own covariance does not know what pixels, paint and blur do to
// all of its edge points together.
constexpr double kCentreFloor_px = 0.3;
constexpr double kSizeFloor = 0.01;

// A partial ellipse may have taken a wrong edge along for an eighth of its circumference: its centre is then
// off by a twentieth of the radius or so, its size by twice that.
constexpr double kPartialCentre_radii = 0.05;
constexpr double kPartialSize = 0.1;

Eigen::Matrix4d transition(double dt_s) {
  Eigen::Matrix4d f = Eigen::Matrix4d::Identity();
  f.topRightCorner<2, 2>() = dt_s * Eigen::Matrix2d::Identity();
  return f;
}

}  // namespace

Eigen::Matrix2d white_acceleration(double dt_s, double variance) {
  const double dt2 = dt_s * dt_s;
  return variance * (Eigen::Matrix2d() << dt2 * dt_s / 3, dt2 / 2, dt2 / 2, dt_s).finished();
}

MarkMeasurement measurement_of(const Detection& detection) {
  const Ellipse& e = detection.outer.ellipse;
  const EllipseCovariance& c = detection.outer.covariance;
  const bool partial = detection.kind == Kind::partial;
  const double radius = std::sqrt(e.a_px * e.b_px);
  const double centre_floor = std::hypot(kCentreFloor_px, partial ? kPartialCentre_radii * radius : 0);
  const double size_floor = std::hypot(kSizeFloor, partial ? kPartialSize : 0);
  MarkMeasurement m;
  m.centre_px = {e.u_px, e.v_px};
  m.centre_covariance_px2 =
      c.topLeftCorner<2, 2>() + centre_floor * centre_floor * Eigen::Matrix2d::Identity();
  m.log_radius = std::log(radius);
  m.log_radius_variance =  // of (log a + log b) / 2
      (c(2, 2) / (e.a_px * e.a_px) + c(3, 3) / (e.b_px * e.b_px) + 2 * c(2, 3) / (e.a_px * e.b_px)) / 4 +
      size_floor * size_floor;
  return m;
}

MarkMotion::MarkMotion(const MarkMeasurement& first, const Eigen::Vector2d& velocity_pxps,
                       double velocity_sigma_pxps, double size_rate_sigma_ps)
    : size_(first.log_radius, 0) {
  state_ << first.centre_px, velocity_pxps;
  covariance_.topLeftCorner<2, 2>() = first.centre_covariance_px2;
  covariance_.bottomRightCorner<2, 2>().diagonal().setConstant(velocity_sigma_pxps * velocity_sigma_pxps);
  size_covariance_.diagonal() << first.log_radius_variance, size_rate_sigma_ps * size_rate_sigma_ps;
}

double MarkMotion::radius_px() const {
  return std::exp(size_[0]);
}

void MarkMotion::predict(double dt_s, const Unrest& unrest) {
  const double walk = unrest.velocity_radiips * radius_px();
  const Eigen::Matrix2d noise = white_acceleration(dt_s, walk * walk);
  const Matrix4 f = transition(dt_s);
  state_ = f * state_;
  covariance_ = f * covariance_ * f.transpose();
  add(noise);
  const Eigen::Matrix2d g = (Eigen::Matrix2d() << 1, dt_s, 0, 1).finished();
  size_ = g * size_;
  size_covariance_ = g * size_covariance_ * g.transpose() +
                     white_acceleration(dt_s, unrest.size_rate_ps * unrest.size_rate_ps);
}

/// Of (place, velocity), in each image direction.
void MarkMotion::add(const Eigen::Matrix2d& covariance) {
  for (int axis = 0; axis < 2; ++axis)
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j) covariance_(axis + 2 * i, axis + 2 * j) += covariance(i, j);
}

void MarkMotion::carry(const Eigen::Vector2d& centre_px, const Eigen::Matrix2d& jacobian) {
  Matrix4 j = Matrix4::Zero();
  j.topLeftCorner<2, 2>() = jacobian;
  j.bottomRightCorner<2, 2>() = jacobian;
  state_ = j * state_;
  state_.head<2>() = centre_px;
  covariance_ = j * covariance_ * j.transpose();
  size_[0] += std::log(std::abs(jacobian.determinant())) / 2;
}

void MarkMotion::shift(const Eigen::Vector2d& by_px, const Eigen::Vector2d& faster_by_pxps,
                       const Eigen::Matrix2d& doubt) {
  add(doubt);
  state_.head<2>() += by_px;
  state_.tail<2>() += faster_by_pxps;
}

void MarkMotion::update(const MarkMeasurement& measured) {
  update_centre(measured.centre_px, measured.centre_covariance_px2);
  update_size(measured.log_radius, measured.log_radius_variance);
}

void MarkMotion::update_centre(const Eigen::Vector2d& centre_px, const Eigen::Matrix2d& covariance_px2) {
  const Eigen::Matrix2d innovation = centre_covariance_px2() + covariance_px2;
  const Eigen::Matrix<double, 4, 2> gain = covariance_.leftCols<2>() * innovation.inverse();
  state_ += gain * (centre_px - this->centre_px());
  covariance_ -= gain * innovation * gain.transpose();
  covariance_ = (covariance_ + covariance_.transpose().eval()) / 2;
}

void MarkMotion::update_jerked(const MarkMeasurement& measured, double surprise_px) {
  const Eigen::Matrix2d doubt = surprise_px * surprise_px / 4 * Eigen::Matrix2d::Identity();
  covariance_.topLeftCorner<2, 2>() += doubt;
  update_centre(measured.centre_px, measured.centre_covariance_px2 + doubt);
  update_size(measured.log_radius, measured.log_radius_variance);
}

void MarkMotion::update_size(double log_radius, double variance) {
  const double innovation = size_covariance_(0, 0) + variance;
  const Eigen::Vector2d gain = size_covariance_.col(0) / innovation;
  size_ += gain * (log_radius - size_[0]);
  size_covariance_ -= innovation * gain * gain.transpose();
}

void MarkMotion::restart(const MarkMeasurement& measured, double velocity_sigma_pxps) {
  const double rate = size_[1], rate_variance = size_covariance_(1, 1);
  *this = MarkMotion(measured, velocity_pxps(), velocity_sigma_pxps, std::sqrt(rate_variance));
  size_[1] = rate;
}

void MarkMotion::forget_velocity(double sigma_pxps) {
  state_.tail<2>().setZero();
  covariance_.topRightCorner<2, 2>().setZero();
  covariance_.bottomLeftCorner<2, 2>().setZero();
  covariance_.bottomRightCorner<2, 2>() = sigma_pxps * sigma_pxps * Eigen::Matrix2d::Identity();
}

}  // namespace stevedore
