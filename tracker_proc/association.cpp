#include "tracker_proc/association.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace stevedore {
namespace {

using std::numbers::pi;

// Farther out nothing is in any image, and fixed-point drawing would overflow.
constexpr double kLargestCoordinatePx = 20000;

// Form of a mark between two frames at 30 Hz: 1 rad/s of tilt at 45 degrees changes b / a by 2.4 %; a fit
// whose arc is cut or blurred by 5 %. Unseen, it turns on.
constexpr double kFormSigma = 0.07;
constexpr double kFormSigmaPerSecond = 0.3;

// One fit in ten is bad (blur along the motion, an arc taken from a shadow): a tenth wrong in size.
constexpr double kBadFits = 0.1;
constexpr double kBadFitSize = 0.1;

// The ratio of a ring's edges is fixed paint; half a pixel of each edge of a 20 px ring.
constexpr double kInnerEdgeSigma = 0.04;

// A label is wrong once in twenty.
constexpr double kWrongLabel = 0.05;

// Chance in a frame that a mark is jerked, and how far, in radii: 3 sigma are one radius, halfway to where a
// neighbour of the same size can be.
constexpr double kJerkChance = 0.05;
constexpr double kJerkRadii = 1.0 / 3;

// Chance of finding a mark that the border cuts, and one whose centre is outside.
constexpr double kFoundCut = 0.5, kFoundOutside = 0.05;

// No camera's frame is smaller; a clipped picture makes newcomers no likelier.
constexpr double kLeastFramePx2 = 320 * 240;

// New marks a frame: one that comes into view every three seconds.
constexpr double kNewcomers = 0.01;

/// R diag(a/b, b/a) R^T: the form without place and size.
Eigen::Matrix2d form_matrix(const Ellipse& e) {
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad);
  const double aa = e.a_px / e.b_px, bb = e.b_px / e.a_px;
  return (Eigen::Matrix2d() << aa * c * c + bb * s * s, (aa - bb) * c * s,  //
          (aa - bb) * c * s, aa * s * s + bb * c * c)
      .finished();
}

double log_normal_density(const Eigen::Vector2d& off, const Eigen::Matrix2d& covariance) {
  return -off.dot(covariance.inverse() * off) / 2 - std::log(2 * pi * std::sqrt(covariance.determinant()));
}

/// 0 at `off` = 0; a normal distribution with a share of bad fits, whose scatter is larger.
double log_size_likeness(double off, double variance) {
  const double wide = variance + kBadFitSize * kBadFitSize;
  const double share = kBadFits * std::sqrt(variance / wide);
  const double density =
      (1 - kBadFits) * std::exp(-off * off / variance / 2) + share * std::exp(-off * off / wide / 2);
  return std::log(std::max(density, std::numeric_limits<double>::min()) / (1 - kBadFits + share));
}

}  // namespace

std::optional<double> inner_edge_of(const Detection& detection) {
  if (!detection.inner) return std::nullopt;
  const Ellipse &inner = detection.inner->ellipse, &outer = detection.outer.ellipse;
  const double share = std::sqrt(inner.a_px * inner.b_px / (outer.a_px * outer.b_px));
  return std::isfinite(share) ? std::optional(share) : std::nullopt;
}

std::optional<Found> found_in(const Detection& detection) {
  const Ellipse e = normalized(detection.outer.ellipse);
  if (!is_valid(e) || std::abs(e.u_px) > kLargestCoordinatePx || std::abs(e.v_px) > kLargestCoordinatePx ||
      e.a_px > kLargestCoordinatePx)
    return std::nullopt;
  return Found{e, measurement_of(detection), detection.label, inner_edge_of(detection)};
}

double form_distance(const Ellipse& one, const Ellipse& other) {
  const Eigen::Matrix2d p = form_matrix(one), q = form_matrix(other);
  const double common = std::sqrt((p * q).trace() + 2);  // trace of (P^1/2 Q P^1/2)^1/2, determinants 1
  return std::sqrt(std::max(0.0, p.trace() + q.trace() - 2 * common));
}

double form_sigma(double unseen_s) {
  return kFormSigma + kFormSigmaPerSecond * unseen_s;
}

double log_likeness(const Expected& expected, const Found& found) {
  const Ellipse& e = expected.ellipse;
  const double growth = found.measurement.log_radius - std::log(e.a_px * e.b_px) / 2;
  double sum =
      log_size_likeness(growth, expected.log_radius_variance + found.measurement.log_radius_variance);
  const double form = form_distance(e, found.ellipse) / form_sigma(expected.unseen_s);
  sum -= form * form / 2;
  if (expected.label != Label::unknown && found.label != Label::unknown && expected.label != found.label)
    sum += std::log(kWrongLabel);
  if (expected.inner_edge && found.inner_edge) {
    const double edge = (*expected.inner_edge - *found.inner_edge) / kInnerEdgeSigma;
    sum += std::max(-edge * edge / 2, std::log(kWrongLabel));
  }
  return sum;
}

double log_place_density(const Eigen::Vector2d& off_px, const Eigen::Matrix2d& covariance_px2,
                         double radius_px) {
  const double jerk_px = kJerkRadii * radius_px;
  const double calm = std::log(1 - kJerkChance) + log_normal_density(off_px, covariance_px2);
  const double jerked =
      std::log(kJerkChance) +
      log_normal_density(off_px, covariance_px2 + jerk_px * jerk_px * Eigen::Matrix2d::Identity());
  return std::max(calm, jerked) + std::log1p(std::exp(-std::abs(calm - jerked)));
}

double log_newcomer_density(const cv::Size& frame) {
  return std::log(kNewcomers / std::max(static_cast<double>(frame.area()), kLeastFramePx2));
}

double found_probability(const Expected& expected, const Eigen::Vector2d& off_px, const cv::Size& frame) {
  const Ellipse& e = expected.ellipse;
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad);
  const double half_u = std::hypot(e.a_px * c, e.b_px * s), half_v = std::hypot(e.a_px * s, e.b_px * c);
  const double u = e.u_px + off_px.x(), v = e.v_px + off_px.y();
  // how far the ellipse's box reaches beyond the border, in its own half widths: 1 at its centre
  const double cut_u = std::max(half_u - u, u + half_u - frame.width) / half_u;
  const double cut_v = std::max(half_v - v, v + half_v - frame.height) / half_v;
  const double cut = std::max(cut_u, cut_v);
  return cut <= 0  ? expected.found_in_view
         : cut < 1 ? std::min(expected.found_in_view, kFoundCut)
                   : kFoundOutside;
}

Eigen::MatrixXd association_costs(const std::vector<Expected>& expected, const std::vector<Found>& found,
                                  const cv::Size& frame) {
  Eigen::MatrixXd costs(static_cast<Eigen::Index>(expected.size()), static_cast<Eigen::Index>(found.size()));
  for (Eigen::Index i = 0; i < costs.rows(); ++i) {
    const Expected& e = expected[static_cast<std::size_t>(i)];
    const double probability = found_probability(e, {0, 0}, frame);
    const double alone = std::log((1 - probability) / probability) + log_newcomer_density(frame);
    for (Eigen::Index k = 0; k < costs.cols(); ++k) {
      const Found& f = found[static_cast<std::size_t>(k)];
      const Eigen::Vector2d off = f.measurement.centre_px - Eigen::Vector2d(e.ellipse.u_px, e.ellipse.v_px);
      costs(i, k) = alone -
                    log_place_density(off, e.centre_covariance_px2 + f.measurement.centre_covariance_px2,
                                      std::sqrt(e.ellipse.a_px * e.ellipse.b_px)) -
                    log_likeness(e, f);
    }
  }
  return costs;
}

}  // namespace stevedore
