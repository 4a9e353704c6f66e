// An ellipse in the image, as every room uses it.
#pragma once

#include <Eigen/Core>
#include <optional>

namespace stevedore {

/// Image frame: u right, v down, (0, 0) is the centre of the upper-left pixel.
/// alpha is the angle from the u-axis to the major axis, clockwise as seen (u towards v): the paper's Fig. 4.
struct Ellipse {
  double u_px = 0;  ///< centre
  double v_px = 0;
  double a_px = 0;  ///< semi-major axis, a >= b > 0
  double b_px = 0;  ///< semi-minor axis
  double alpha_rad = 0;
};

/// Covariance of (u, v, a, b, alpha), in px^2, px rad and rad^2.
using EllipseCovariance = Eigen::Matrix<double, 5, 5>;

/// The same ellipse with a >= b and alpha in [-pi/2, pi/2).
Ellipse normalized(const Ellipse& ellipse);

/// Finite, a >= b > 0.
bool is_valid(const Ellipse& ellipse);

/// The symmetric matrix C with [u v 1] C [u v 1]^T = 0 on the ellipse and < 0 inside it, scaled so that
/// the value at the centre is -1.
Eigen::Matrix3d conic_from_ellipse(const Ellipse& ellipse);

/// Inverse of conic_from_ellipse, for a conic of any scale and sign. Nothing if it is not a real ellipse.
std::optional<Ellipse> ellipse_from_conic(const Eigen::Matrix3d& conic);

/// Point at parameter t (rad): centre + a cos t along the major axis + b sin t along the minor axis.
Eigen::Vector2d point_at(const Ellipse& ellipse, double t_rad);

/// Value of the left-hand side of the paper's eq. (4) at a point, before "- 1": 1 on the ellipse, 0 at its
/// centre.
double normalized_radius_squared(const Ellipse& ellipse, const Eigen::Vector2d& point_px);

/// Ramanujan (1914), relative error below 1e-4 for a / b < 10.
double perimeter_px(const Ellipse& ellipse);

}  // namespace stevedore
