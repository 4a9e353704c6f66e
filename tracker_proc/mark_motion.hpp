// Where one mark is in the image, how large, how both change, and how well that is known: a Kalman filter.
#pragma once

#include <Eigen/Core>

#include "geometry/detection.hpp"

namespace stevedore {

/// How much the motion of a mark may change by itself: variance of its velocity after one second, grown from
/// zero (white acceleration). Velocities are in radii a second, sizes in logarithms.
struct Unrest {
  double velocity_radiips = 0;
  double size_rate_ps = 0;
};

/// What one detection says: centre and logarithm of the mean radius sqrt(a b), with their variances.
struct MarkMeasurement {
  Eigen::Vector2d centre_px;
  Eigen::Matrix2d centre_covariance_px2;
  double log_radius = 0;
  double log_radius_variance = 0;
};

MarkMeasurement measurement_of(const Detection& detection);

/// State: centre (px) and its velocity (px/s), logarithm of the mean radius and its rate (1/s). The two are
/// filtered apart: a circle's place and its size change for different reasons.
class MarkMotion {
 public:
  using Matrix4 = Eigen::Matrix4d;

  /// The first measurement; velocity (px/s) with its standard deviation as known from elsewhere.
  MarkMotion(const MarkMeasurement& first, const Eigen::Vector2d& velocity_pxps, double velocity_sigma_pxps,
             double size_rate_sigma_ps);

  void predict(double dt_s, const Unrest& unrest);
  /// Something known moved the image here: the point to `centre_px`, directions by `jacobian`.
  void carry(const Eigen::Vector2d& centre_px, const Eigen::Matrix2d& jacobian);
  /// All marks moved together, in addition to what each does by itself. doubt: covariance of shift and change
  /// of velocity, the same in both image directions.
  void shift(const Eigen::Vector2d& by_px, const Eigen::Vector2d& faster_by_pxps,
             const Eigen::Matrix2d& doubt);
  void update(const MarkMeasurement& measured);
  /// The same from `surprise_px` away: whether the mark was jerked there or the measurement is wrong, the
  /// next one will tell.
  void update_jerked(const MarkMeasurement& measured, double surprise_px);
  /// A place alone, with equal variance in both directions.
  void update_centre(const Eigen::Vector2d& centre_px, const Eigen::Matrix2d& covariance_px2);
  /// Starts again at a place: what led there says nothing of the velocity now.
  void restart(const MarkMeasurement& measured, double velocity_sigma_pxps);
  /// The velocity is not known any more.
  void forget_velocity(double sigma_pxps);

  [[nodiscard]] Eigen::Vector2d centre_px() const { return state_.head<2>(); }
  [[nodiscard]] Eigen::Vector2d velocity_pxps() const { return state_.tail<2>(); }
  [[nodiscard]] Eigen::Matrix2d centre_covariance_px2() const { return covariance_.topLeftCorner<2, 2>(); }
  [[nodiscard]] double log_radius_variance() const { return size_covariance_(0, 0); }
  [[nodiscard]] double radius_px() const;

 private:
  void update_size(double log_radius, double variance);
  void add(const Eigen::Matrix2d& covariance);

  Eigen::Vector4d state_;
  Matrix4 covariance_ = Matrix4::Zero();
  Eigen::Vector2d size_;
  Eigen::Matrix2d size_covariance_ = Eigen::Matrix2d::Zero();
};

/// Covariance of (position, velocity) after dt_s of white acceleration whose velocity variance grows by
/// `variance` in a second, grown from zero.
Eigen::Matrix2d white_acceleration(double dt_s, double variance);

}  // namespace stevedore
