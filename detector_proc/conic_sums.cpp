#include "detector_proc/conic_sums.hpp"

#include <Eigen/Cholesky>
#include <cmath>
#include <utility>

namespace stevedore {
namespace {

/// (A, B, D, E, F) to the ellipse, in the fit's frame.
std::optional<Ellipse> ellipse_from(const Eigen::Matrix<double, 5, 1>& conic) {
  const double a = conic[0], b = conic[1] / 2, c = 1 - a, d = conic[2] / 2, e = conic[3] / 2, f = conic[4];
  const double determinant = a * c - b * b;
  if (!(determinant > 0)) return std::nullopt;
  const double x = (b * e - c * d) / determinant, y = (b * d - a * e) / determinant;
  const double at_centre = f + d * x + e * y;
  if (!(at_centre < 0)) return std::nullopt;  // a + c = 1 > 0: positive definite, so real if negative there
  const double half_difference = std::hypot((a - c) / 2, b);
  const double low = determinant / (0.5 + half_difference), high = 0.5 + half_difference;  // eigenvalues
  // the major axis is along the eigenvector of the lower one
  return Ellipse{x, y, std::sqrt(-at_centre / low), std::sqrt(-at_centre / high),
                 std::atan2(-b, -(a - c) / 2) / 2};
}

}  // namespace

void ConicSums::add(const EdgePoint& p, const FitFrame& frame, double weight, double lever_px) {
  const double inverse = 1 / frame.scale_px;
  const double x = (p.u_px - frame.u_px) * inverse, y = (p.v_px - frame.v_px) * inverse;
  const double tx = lever_px * inverse * p.tangent_u, ty = lever_px * inverse * p.tangent_v;
  const double w = weight, a = x * x - y * y, b = x * y, r = -y * y;             // on the conic
  const double c = 2 * (x * tx - y * ty), d = y * tx + x * ty, q = -2 * y * ty;  // along it
  const double wa = w * a, wb = w * b, wx = w * x, wy = w * y;
  const double wc = w * c, wd = w * d, wtx = w * tx, wty = w * ty;
  const std::array<double, 21> terms{wa * a + wc * c,
                                     wa * b + wc * d,
                                     wa * x + wc * tx,
                                     wa * y + wc * ty,
                                     wa,
                                     wa * r + wc * q,
                                     wb * b + wd * d,
                                     wb * x + wd * tx,
                                     wb * y + wd * ty,
                                     wb,
                                     wb * r + wd * q,
                                     wx * x + wtx * tx,
                                     wx * y + wtx * ty,
                                     wx,
                                     wx * r + wtx * q,
                                     wy * y + wty * ty,
                                     wy,
                                     wy * r + wty * q,
                                     w,
                                     w * r,
                                     w * (r * r + q * q)};
  for (std::size_t k = 0; k < terms.size(); ++k) sums_[k] += terms[k];
}

void ConicSums::add(const ConicSums& other) {
  for (std::size_t k = 0; k < sums_.size(); ++k) sums_[k] += other.sums_[k];
}

std::optional<Ellipse> ConicSums::solve(const FitFrame& frame) const {
  Eigen::Matrix<double, 5, 5> normal;
  Eigen::Matrix<double, 5, 1> right;
  std::size_t k = 0;
  for (int row = 0; row < 5; ++row) {
    for (int column = row; column < 5; ++column) normal(row, column) = normal(column, row) = sums_[k++];
    right[row] = sums_[k++];
  }
  const Eigen::LLT<Eigen::Matrix<double, 5, 5>> cholesky(normal);
  if (cholesky.info() != Eigen::Success) return std::nullopt;
  auto ellipse = ellipse_from(cholesky.solve(right));
  if (!ellipse) return std::nullopt;
  ellipse->u_px = ellipse->u_px * frame.scale_px + frame.u_px;
  ellipse->v_px = ellipse->v_px * frame.scale_px + frame.v_px;
  ellipse->a_px *= frame.scale_px;
  ellipse->b_px *= frame.scale_px;
  return is_valid(*ellipse) ? ellipse : std::nullopt;
}

}  // namespace stevedore
