// Distance of points from an ellipse.
#pragma once

#include <cmath>

#include "geometry/ellipse.hpp"

namespace stevedore {

/// Distance from one ellipse, outside positive, to first order (Sampson 1982); exact near the ellipse.
class EllipseDistance {
 public:
  explicit EllipseDistance(const Ellipse& e)
      : ellipse_(e), cosine_(std::cos(e.alpha_rad)), sine_(std::sin(e.alpha_rad)) {}

  double operator()(double u_px, double v_px) const {
    const double du = u_px - ellipse_.u_px, dv = v_px - ellipse_.v_px;
    const double x = (cosine_ * du + sine_ * dv) / ellipse_.a_px,
                 y = (cosine_ * dv - sine_ * du) / ellipse_.b_px;
    const double square = x * x + y * y;
    const double slope_square =
        x * x / (ellipse_.a_px * ellipse_.a_px) + y * y / (ellipse_.b_px * ellipse_.b_px);
    return slope_square > 0 ? (square - std::sqrt(square)) / std::sqrt(slope_square) : -ellipse_.b_px;
  }

 private:
  Ellipse ellipse_;
  double cosine_, sine_;
};

}  // namespace stevedore
