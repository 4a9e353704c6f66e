// Distance of points from an ellipse.
#pragma once

#include <cmath>

#include "geometry/ellipse.hpp"

namespace stevedore {

/// Distance from one ellipse, outside positive, to first order (Sampson 1982); exact near the ellipse.
class EllipseDistance {
 public:
  explicit EllipseDistance(const Ellipse& e)
      : ellipse_(e),
        along_u_(std::cos(e.alpha_rad) / e.a_px),
        along_v_(std::sin(e.alpha_rad) / e.a_px),
        across_u_(-std::sin(e.alpha_rad) / e.b_px),
        across_v_(std::cos(e.alpha_rad) / e.b_px),
        a_square_(1 / (e.a_px * e.a_px)),
        b_square_(1 / (e.b_px * e.b_px)) {}

  double operator()(double u_px, double v_px) const {
    const double du = u_px - ellipse_.u_px, dv = v_px - ellipse_.v_px;
    const double x = along_u_ * du + along_v_ * dv, y = across_u_ * du + across_v_ * dv;
    const double square = x * x + y * y, slope_square = x * x * a_square_ + y * y * b_square_;
    return slope_square > 0 ? (square - std::sqrt(square)) / std::sqrt(slope_square) : -ellipse_.b_px;
  }

 private:
  Ellipse ellipse_;
  double along_u_, along_v_, across_u_, across_v_;  ///< to the frame in which the ellipse is the unit circle
  double a_square_, b_square_;                      ///< inverse
};

}  // namespace stevedore
