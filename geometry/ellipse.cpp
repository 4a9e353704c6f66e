#include "geometry/ellipse.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>
#include <utility>

namespace stevedore {
namespace {

using std::numbers::pi;

struct Axes {
  double cosine, sine;
};

Axes axes_of(const Ellipse& e) {
  return {std::cos(e.alpha_rad), std::sin(e.alpha_rad)};
}

}  // namespace

Ellipse normalized(const Ellipse& ellipse) {
  Ellipse e = ellipse;
  if (e.b_px > e.a_px) {
    std::swap(e.a_px, e.b_px);
    e.alpha_rad += pi / 2;
  }
  e.alpha_rad -= pi * std::floor(e.alpha_rad / pi + 0.5);
  return e;
}

bool is_valid(const Ellipse& e) {
  return std::isfinite(e.u_px) && std::isfinite(e.v_px) && std::isfinite(e.a_px) &&
         std::isfinite(e.alpha_rad) && e.b_px > 0 && e.a_px >= e.b_px;
}

Eigen::Matrix3d conic_from_ellipse(const Ellipse& e) {
  const auto [c, s] = axes_of(e);
  Eigen::Matrix3d from_image;  // image point to the ellipse's own unit circle
  from_image << c / e.a_px, s / e.a_px, -(c * e.u_px + s * e.v_px) / e.a_px,  //
      -s / e.b_px, c / e.b_px, (s * e.u_px - c * e.v_px) / e.b_px,            //
      0, 0, 1;
  return from_image.transpose() * Eigen::Vector3d(1, 1, -1).asDiagonal() * from_image;
}

std::optional<Ellipse> ellipse_from_conic(const Eigen::Matrix3d& conic) {
  const Eigen::Matrix2d quadratic = conic.topLeftCorner<2, 2>();
  if (!conic.allFinite() || !(quadratic.determinant() > 0)) return std::nullopt;
  const Eigen::Vector2d centre = -quadratic.inverse() * conic.topRightCorner<2, 1>();
  const double at_centre = conic(2, 2) + centre.dot(conic.topRightCorner<2, 1>());
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(quadratic / -at_centre);
  const Eigen::Vector2d inverse_squares = eigen.eigenvalues();  // ascending: major axis first
  if (!(inverse_squares[0] > 0)) return std::nullopt;
  const Eigen::Vector2d major = eigen.eigenvectors().col(0);
  const Ellipse ellipse = normalized({centre.x(), centre.y(), 1 / std::sqrt(inverse_squares[0]),
                                      1 / std::sqrt(inverse_squares[1]), std::atan2(major.y(), major.x())});
  return is_valid(ellipse) ? std::optional(ellipse) : std::nullopt;
}

Eigen::Vector2d point_at(const Ellipse& e, double t_rad) {
  const auto [c, s] = axes_of(e);
  const double along = e.a_px * std::cos(t_rad), across = e.b_px * std::sin(t_rad);
  return {e.u_px + c * along - s * across, e.v_px + s * along + c * across};
}

double normalized_radius_squared(const Ellipse& e, const Eigen::Vector2d& p) {
  const auto [c, s] = axes_of(e);
  const double along = (c * (p.x() - e.u_px) + s * (p.y() - e.v_px)) / e.a_px;
  const double across = (-s * (p.x() - e.u_px) + c * (p.y() - e.v_px)) / e.b_px;
  return along * along + across * across;
}

double perimeter_px(const Ellipse& e) {
  const double h = std::pow((e.a_px - e.b_px) / (e.a_px + e.b_px), 2);
  return pi * (e.a_px + e.b_px) * (1 + 3 * h / (10 + std::sqrt(4 - 3 * h)));
}

}  // namespace stevedore
