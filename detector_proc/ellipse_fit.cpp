#include "detector_proc/ellipse_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace stevedore {
namespace {

using std::numbers::pi;
using Row = Eigen::Matrix<double, 5, 1>;

Eigen::Vector2d vector(const cv::Point& p) {
  return {p.x, p.y};
}

/// Parameter t of the point of the ellipse in the direction of p, in its own stretched frame.
double parameter_of(const Ellipse& e, const Eigen::Vector2d& p) {
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad);
  const double du = p.x() - e.u_px, dv = p.y() - e.v_px;
  return std::atan2((c * dv - s * du) / e.b_px, (c * du + s * dv) / e.a_px);
}

/// How far the ellipse at parameter t moves outwards, along its normal, per unit of each parameter.
Row normal_shift(const Ellipse& e, double t) {
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad);
  const Eigen::Vector2d major(c, s), minor(-s, c);
  const double x = e.a_px * std::cos(t), y = e.b_px * std::sin(t);
  const Eigen::Vector2d normal = (e.b_px * std::cos(t) * major + e.a_px * std::sin(t) * minor).normalized();
  const Eigen::Vector2d turned = x * minor - y * major;  // d point / d alpha
  Row row;
  row << normal, normal.dot(major) * std::cos(t), normal.dot(minor) * std::sin(t), normal.dot(turned);
  return row;
}

}  // namespace

Ellipse ellipse_from_rotated_rect(const cv::RotatedRect& rect) {
  return normalized(
      {rect.center.x, rect.center.y, rect.size.width / 2.0, rect.size.height / 2.0, rect.angle * pi / 180});
}

std::optional<Ellipse> fit_ellipse(const std::vector<cv::Point>& points) {
  if (points.size() < 6) return std::nullopt;  // five always fit exactly and prove nothing
  const Ellipse ellipse = ellipse_from_rotated_rect(cv::fitEllipse(points));
  return is_valid(ellipse) ? std::optional(ellipse) : std::nullopt;
}

double algebraic_error(const Ellipse& ellipse, const std::vector<cv::Point>& points) {
  double sum = 0;
  for (const auto& p : points) sum += std::abs(normalized_radius_squared(ellipse, vector(p)) - 1);
  return sum / static_cast<double>(points.size());
}

double distance_px(const Ellipse& e, const Eigen::Vector2d& p) {
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad);
  const double along = (c * (p.x() - e.u_px) + s * (p.y() - e.v_px)) / e.a_px;
  const double across = (-s * (p.x() - e.u_px) + c * (p.y() - e.v_px)) / e.b_px;
  const double half_gradient = std::hypot(along / e.a_px, across / e.b_px);
  const double radius = std::hypot(along, across);
  return half_gradient > 0 ? (radius - 1) * radius / half_gradient : -e.b_px;
}

double coverage(const Ellipse& e, const std::vector<cv::Point>& points, double max_distance_px) {
  // Bins of about three pixels: a contour that is there leaves none empty, even on the diagonal.
  constexpr std::size_t max_bins = 120;
  const auto bins = std::clamp<std::size_t>(static_cast<std::size_t>(perimeter_px(e) / 3), 6, max_bins);
  const double bin_rad = 2 * pi / static_cast<double>(bins);
  std::array<bool, max_bins> filled{};
  for (const auto& point : points) {
    const Eigen::Vector2d p = vector(point);
    if (std::abs(distance_px(e, p)) > max_distance_px) continue;
    const auto bin = static_cast<std::size_t>((parameter_of(e, p) + pi) / bin_rad);
    filled[std::min(bin, bins - 1)] = true;
  }
  double supported = 0, total = 0;
  for (std::size_t i = 0; i < bins; ++i) {
    const double t = -pi + (static_cast<double>(i) + 0.5) * bin_rad;
    const double length = std::hypot(e.a_px * std::sin(t), e.b_px * std::cos(t));
    total += length;
    if (filled[i]) supported += length;
  }
  return supported / total;
}

EllipseCovariance fit_covariance(const Ellipse& e, const std::vector<cv::Point>& points,
                                 double correlation_length_px) {
  EllipseCovariance information = EllipseCovariance::Zero();
  double sum_of_squares = 0;
  for (const auto& point : points) {
    const Eigen::Vector2d p = vector(point);
    const Row row = normal_shift(e, parameter_of(e, p));
    information += row * row.transpose();
    sum_of_squares += std::pow(distance_px(e, p), 2);
  }
  // A point on the pixel grid errs evenly within half a pixel, 1 / sqrt(12) px rms. A fit to few points can
  // leave smaller residuals, never smaller errors.
  const double freedom = std::max(1.0, static_cast<double>(points.size()) - 5);
  const double variance_px2 = std::max(sum_of_squares / freedom, 1.0 / 12);
  information /= variance_px2 * correlation_length_px;
  // What is known before any point: alpha within half a turn (a circle's stays so), all else within 10^4 px.
  information.diagonal() += (Row() << 1e-8, 1e-8, 1e-8, 1e-8, 12 / (pi * pi)).finished();
  return information.inverse();
}

}  // namespace stevedore
