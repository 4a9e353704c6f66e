#include "detector_proc/ellipse_covariance.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace stevedore {

using std::numbers::pi;

namespace {

using Row = Eigen::Matrix<double, 5, 1>;

/// Goes round an ellipse in equal steps of its parameter.
template <class Visit>
void go_round(const Ellipse& e, int count, Visit visit) {
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad);
  const double step_cosine = std::cos(2 * pi / count), step_sine = std::sin(2 * pi / count);
  double ct = 1, st = 0;
  for (int k = 0; k < count; ++k) {
    const double x = e.b_px * ct, y = e.a_px * st, length = std::sqrt(x * x + y * y);
    const double along = x / length, across = y / length;  // the normal, in the axes' frame
    // how far the edge moves outwards per unit of (u, v, a, b, alpha)
    visit(k, (Row() << c * along - s * across, s * along + c * across, along * ct, across * st,
              across * e.a_px * ct - along * e.b_px * st)
                 .finished());
    const double next = ct * step_cosine - st * step_sine;
    st = st * step_cosine + ct * step_sine;
    ct = next;
  }
}

}  // namespace

EllipseCovariance covariance_of(const Ellipse& e, const EdgeSupport& support, double deviation_px) {
  EllipseCovariance information = EllipseCovariance::Zero();
  go_round(e, support.count, [&](int k, const Row& row) {
    if (support.samples[static_cast<std::size_t>(k)].found) information += row * row.transpose();
  });
  information /= deviation_px * deviation_px;
  // What is known before any edge: alpha within half a turn (a circle's stays so), all else within 10^4 px.
  information.diagonal() +=
      (Eigen::Matrix<double, 5, 1>() << 1e-8, 1e-8, 1e-8, 1e-8, 12 / (pi * pi)).finished();
  return information.llt().solve(EllipseCovariance::Identity());
}

double worst_deviation_px(const Ellipse& ellipse, const EllipseCovariance& covariance) {
  double worst = 0;
  go_round(ellipse, 16, [&](int, const Row& row) { worst = std::max(worst, row.dot(covariance * row)); });
  return std::sqrt(worst);
}

}  // namespace stevedore
