#include "detector_proc/ellipse_covariance.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace stevedore {

using std::numbers::pi;

Eigen::Matrix<double, 5, 1> normal_shift(const Ellipse& e, double t) {
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad), ct = std::cos(t), st = std::sin(t);
  const double length = std::hypot(e.b_px * ct, e.a_px * st);
  const double along = e.b_px * ct / length, across = e.a_px * st / length;  // the normal, in the axes' frame
  Eigen::Matrix<double, 5, 1> row;
  row << c * along - s * across, s * along + c * across, along * ct, across * st,
      across * e.a_px * ct - along * e.b_px * st;
  return row;
}

EllipseCovariance covariance_of(const Ellipse& e, const EdgeSupport& support, double deviation_px) {
  EllipseCovariance information = EllipseCovariance::Zero();
  for (int k = 0; k < support.count; ++k) {
    if (!support.samples[static_cast<std::size_t>(k)].found) continue;
    const auto row = normal_shift(e, 2 * pi * k / support.count);
    information += row * row.transpose();
  }
  information /= deviation_px * deviation_px;
  // What is known before any edge: alpha within half a turn (a circle's stays so), all else within 10^4 px.
  information.diagonal() +=
      (Eigen::Matrix<double, 5, 1>() << 1e-8, 1e-8, 1e-8, 1e-8, 12 / (pi * pi)).finished();
  return information.llt().solve(EllipseCovariance::Identity());
}

double worst_deviation_px(const Ellipse& ellipse, const EllipseCovariance& covariance) {
  double worst = 0;
  for (int k = 0; k < 16; ++k) {
    const auto row = normal_shift(ellipse, pi * k / 8);
    worst = std::max(worst, row.dot(covariance * row));
  }
  return std::sqrt(worst);
}

}  // namespace stevedore
