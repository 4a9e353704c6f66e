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

EllipseCovariance information_of(const ShapePrior& prior) {
  const Ellipse& e = prior.shape;
  const double axis_px = prior.share * e.b_px;
  // what turns the axes' ends by as much as the axes may differ
  const double turn_rad = std::min(pi, prior.share / std::max(1e-3, 1 - e.b_px / e.a_px));
  EllipseCovariance information = EllipseCovariance::Zero();
  information.diagonal() << 0, 0, 1 / (axis_px * axis_px), 1 / (axis_px * axis_px), 1 / (turn_rad * turn_rad);
  return information;
}

EllipseCovariance information_of(const Ellipse& e, const EdgeSupport& support, double deviation_px) {
  EllipseCovariance information = EllipseCovariance::Zero();
  go_round(e, support.count, [&](int k, const Row& row) {
    if (support.samples[static_cast<std::size_t>(k)].found) information += row * row.transpose();
  });
  information /= deviation_px * deviation_px;
  // What is known before any edge: alpha within half a turn (a circle's stays so), all else within 10^4 px.
  information.diagonal() +=
      (Eigen::Matrix<double, 5, 1>() << 1e-8, 1e-8, 1e-8, 1e-8, 12 / (pi * pi)).finished();
  return information;
}

}  // namespace

EllipseCovariance covariance_of(const Ellipse& e, const EdgeSupport& support, double deviation_px) {
  return information_of(e, support, deviation_px).llt().solve(EllipseCovariance::Identity());
}

EllipseCovariance covariance_of(const Ellipse& e, const EdgeSupport& support, double deviation_px,
                                const ShapePrior& prior) {
  return (information_of(e, support, deviation_px) + information_of(prior))
      .llt()
      .solve(EllipseCovariance::Identity());
}

std::optional<Ellipse> refit(EdgeSupport& support, const Ellipse& ellipse, const ShapePrior& prior) {
  constexpr double edge_px = 0.3;  // an edge's own error, and that of a shape that is not quite this one
  Ellipse e = ellipse;
  for (int step = 0; step < 3; ++step) {
    const double limit_px = outlier_limit_px(support, edge_px);
    EllipseCovariance information = information_of(prior);
    Row right = information * Row(0, 0, prior.shape.a_px - e.a_px, prior.shape.b_px - e.b_px,
                                  std::remainder(prior.shape.alpha_rad - e.alpha_rad, pi));
    int used = 0;
    go_round(e, support.count, [&](int k, const Row& row) {
      const EdgeSample& s = support.samples[static_cast<std::size_t>(k)];
      const double ratio = s.offset_px / limit_px;
      if (!s.found || std::abs(ratio) >= 1) return;
      ++used;
      const double weight = (1 - ratio * ratio) * (1 - ratio * ratio) / (edge_px * edge_px);
      information += weight * row * row.transpose();
      right += weight * s.offset_px * row;
    });
    if (used < 6) return std::nullopt;
    const Row by = information.llt().solve(right);
    e.u_px += by[0], e.v_px += by[1], e.a_px += by[2], e.b_px += by[3], e.alpha_rad += by[4];
    if (!(e.b_px > 1) || !(e.a_px > 1)) return std::nullopt;
    measure_from(support, e);
  }
  return normalized(e);
}

double worst_deviation_px(const Ellipse& ellipse, const EllipseCovariance& covariance) {
  double worst = 0;
  go_round(ellipse, 16, [&](int, const Row& row) { worst = std::max(worst, row.dot(covariance * row)); });
  return std::sqrt(worst);
}

}  // namespace stevedore
