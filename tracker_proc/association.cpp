#include "tracker_proc/association.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace stevedore {
namespace {

// Covers the scatter of the measured centres of very small ellipses, whose own radius is no measure of it.
constexpr double kCentreNoisePx = 2.0;

double distance_px(const Ellipse& one, const Ellipse& other) {
  return std::hypot(one.u_px - other.u_px, one.v_px - other.v_px);
}

/// R diag(a^2, b^2) R^T: the shape without the place.
Eigen::Matrix2d shape_matrix(const Ellipse& e) {
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad);
  const double aa = e.a_px * e.a_px, bb = e.b_px * e.b_px;
  return (Eigen::Matrix2d() << aa * c * c + bb * s * s, (aa - bb) * c * s,  //
          (aa - bb) * c * s, aa * s * s + bb * c * c)
      .finished();
}

double gate_radii(const Expected& expected, const AssociationGates& gates) {
  return gates.radii + gates.radii_per_s * expected.unseen_s;
}

struct Pair {
  double cost_px;
  std::size_t track, found;
};

}  // namespace

double gate_px(const Expected& expected, const Eigen::Vector2d& centre_px, const AssociationGates& gates) {
  const Ellipse& e = expected.ellipse;
  const double distance = (centre_px - Eigen::Vector2d(e.u_px, e.v_px)).norm();
  const double in_radii = std::sqrt(normalized_radius_squared(e, centre_px));
  const double radius = in_radii > 0 ? distance / in_radii : e.b_px;
  return gate_radii(expected, gates) * radius + kCentreNoisePx;
}

bool may_be(const Expected& expected, const Ellipse& found, const AssociationGates& gates) {
  const Ellipse& e = expected.ellipse;
  const double distance = distance_px(e, found);
  if (distance > gate_radii(expected, gates) * e.a_px + kCentreNoisePx)
    return false;  // cheap: no gate is wider than this
  const double growth = std::abs(std::log(found.a_px * found.b_px / (e.a_px * e.b_px))) / 2;
  return growth <= std::log(gates.size_ratio) + gates.size_rate_per_s * expected.unseen_s &&
         distance <= gate_px(expected, {found.u_px, found.v_px}, gates);
}

double shape_distance_px(const Ellipse& one, const Ellipse& other) {
  const Eigen::Matrix2d p = shape_matrix(one), q = shape_matrix(other);
  const double common = std::sqrt((p * q).trace() + 2 * one.a_px * one.b_px * other.a_px *
                                                        other.b_px);  // trace of (P^½ Q P^½)^½
  const double shape = std::max(0.0, p.trace() + q.trace() - 2 * common);
  return std::sqrt(std::pow(distance_px(one, other), 2) + shape);
}

std::vector<std::optional<std::size_t>> associate(std::size_t tracks, const std::vector<Expected>& expected,
                                                  const std::vector<Ellipse>& found,
                                                  const AssociationGates& gates) {
  std::vector<Pair> pairs;
  for (const Expected& e : expected)
    for (std::size_t k = 0; k < found.size(); ++k)
      if (may_be(e, found[k], gates)) pairs.push_back({shape_distance_px(e.ellipse, found[k]), e.track, k});
  std::sort(pairs.begin(), pairs.end(), [](const Pair& x, const Pair& y) {
    return std::tie(x.cost_px, x.track, x.found) < std::tie(y.cost_px, y.track, y.found);
  });

  std::vector<std::optional<std::size_t>> match(tracks);
  std::vector<bool> taken(found.size(), false);
  for (const Pair& pair : pairs) {
    if (match[pair.track] || taken[pair.found]) continue;
    match[pair.track] = pair.found;
    taken[pair.found] = true;
  }
  return match;
}

}  // namespace stevedore
