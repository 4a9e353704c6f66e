#include "detector_proc/round_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <numeric>

namespace stevedore {
namespace {

/// Centres of rims: the cargo stands up to 0.4 radii off the middle, and a rim that is 0.6 radii over the
/// deck is seen that times the tangent of the line of sight further out.
constexpr float farthest_centre_px = 0.9F * unit_px;
constexpr int cell_px = 2;
constexpr std::size_t cells = patch_px / cell_px;
constexpr std::size_t places_tried = 8;

/// Votes for centres of circles of one radius.
class Votes {
 public:
  void add(float u, float v) {
    const float x = u - middle_px, y = v - middle_px;
    if (x * x + y * y > farthest_centre_px * farthest_centre_px) return;
    ++counts_[static_cast<std::size_t>(v) / cell_px][static_cast<std::size_t>(u) / cell_px];
  }

  /// visit(u, v, sum) for the middles of all 3x3 cells.
  template <class Visit>
  void for_each_sum(Visit visit) const {
    for (std::size_t j = 1; j + 1 < cells; ++j) {
      std::array<int, cells> columns;
      for (std::size_t i = 0; i < cells; ++i)
        columns[i] = counts_[j - 1][i] + counts_[j][i] + counts_[j + 1][i];
      for (std::size_t i = 1; i + 1 < cells; ++i)
        visit((static_cast<float>(i) + 0.5F) * cell_px, (static_cast<float>(j) + 0.5F) * cell_px,
              columns[i - 1] + columns[i] + columns[i + 1]);
    }
  }

 private:
  std::array<std::array<int, cells>, cells> counts_{};
};

/// The edge is strongest here, across it, and it is not the circle's own.
bool votes_from(const PatchEdges& edges, int v, int u) {
  const float m = edges.magnitude(v, u);
  if (m < edges.threshold) return false;
  const float x = static_cast<float>(u) - middle_px, y = static_cast<float>(v) - middle_px;
  constexpr float own_px = 2.5F, low = unit_px - own_px, high = unit_px + own_px;
  const float square = x * x + y * y;
  if (square > low * low && square < high * high) return false;
  // the neighbour along the gradient
  const auto step = [&](float g) { return g > m / 2 ? 1 : g < -m / 2 ? -1 : 0; };
  const int su = step(edges.along(v, u)), sv = step(edges.down(v, u));
  return m >= edges.magnitude(v + sv, u + su) && m >= edges.magnitude(v - sv, u - su);
}

}  // namespace

std::vector<RoundPlace> voted_places(const PatchEdges& edges, const std::vector<float>& radii_px) {
  std::vector<Votes> votes(radii_px.size());
  for (int v = 2; v < patch_px - 2; ++v) {
    for (int u = 2; u < patch_px - 2; ++u) {
      if (!votes_from(edges, v, u)) continue;
      const float m = edges.magnitude(v, u), nu = edges.along(v, u) / m, nv = edges.down(v, u) / m;
      for (std::size_t r = 0; r < radii_px.size(); ++r) {
        for (const float radius : {radii_px[r], -radii_px[r]})
          votes[r].add(static_cast<float>(u) + radius * nu, static_cast<float>(v) + radius * nv);
      }
    }
  }
  struct Sum {
    float share;
    RoundPlace place;
  };
  std::vector<Sum> sums;
  for (std::size_t r = 0; r < radii_px.size(); ++r) {
    const float all = 2 * std::numbers::pi_v<float> * radii_px[r];
    votes[r].for_each_sum([&](float u, float v, int sum) {
      const float share = static_cast<float>(sum) / all;
      // a rim of which half is seen, and half of that is where it should be
      if (share > 0.25F) sums.push_back({share, {u, v, radii_px[r]}});
    });
  }
  std::stable_sort(sums.begin(), sums.end(), [](const Sum& a, const Sum& b) { return a.share > b.share; });
  std::vector<RoundPlace> places;
  for (const Sum& s : sums) {
    const bool known = std::any_of(places.begin(), places.end(), [&](const RoundPlace& p) {
      return std::hypot(p.u - s.place.u, p.v - s.place.v) < 5 && std::abs(p.radius - s.place.radius) < 2.5F;
    });
    if (!known) places.push_back(s.place);
    if (places.size() == places_tried) break;
  }
  return places;
}

std::optional<RoundFit> fitted(const RoundPatch& patch, const PatchEdges& edges, const RoundPlace& place,
                               const std::array<float, 3>& bands_px, double radius_weight) {
  constexpr float most_turn_cosine = 0.85F;  // 32 degrees: a pixel's direction at three sigma of noise
  Eigen::Vector3d circle(place.u, place.v, place.radius);
  RoundFit fit;
  for (const float band_px : bands_px) {
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    Eigen::Vector3d sums = Eigen::Vector3d::Zero();
    double looked = 0, found = 0, residuals = 0, errors = 0;
    const auto centre_u = static_cast<float>(circle.x()), centre_v = static_cast<float>(circle.y()),
               radius = static_cast<float>(circle.z());
    for (const auto& [nu, nv] : all_directions()) {
      const auto along_ray = [&, nu = nu, nv = nv](float r) {
        return pixel_at(centre_u + r * nu, centre_v + r * nv);
      };
      const cv::Point expected = along_ray(radius);
      if (!patch.sees(expected.y, expected.x)) continue;
      ++looked;
      float best = 0, best_off = 0;
      for (float off = -band_px; off <= band_px; off += 0.5F) {
        const cv::Point p = along_ray(radius + off);
        if (!patch.sees(p.y, p.x)) continue;
        const float m = edges.magnitude(p);
        if (m < edges.threshold) continue;
        const float along = std::abs(edges.along(p) * nu + edges.down(p) * nv);
        if (along > best && along > most_turn_cosine * m) best = along, best_off = off;
      }
      if (best <= 0) continue;
      const Eigen::Vector3d by(nu, nv, 1);
      squares += by * by.transpose();
      sums += by * best_off;
      residuals += best_off * best_off;
      errors += std::abs(2 * best_off / circle.z());
      ++found;
    }
    if (looked < directions / 2.0 || found < directions / 4.0) return std::nullopt;
    squares(2, 2) += radius_weight;
    sums(2) += radius_weight * (place.radius - circle.z());
    const Eigen::LDLT<Eigen::Matrix3d> solver(squares);
    const Eigen::Vector3d step = solver.solve(sums);
    if (step.norm() > 4) return std::nullopt;
    circle += step;
    fit.coverage = found / looked;
    fit.error = errors / found;
    const double variance_px2 = std::max(0.1, (residuals - step.dot(sums)) / std::max(1.0, found - 3));
    fit.covariance_px2 = variance_px2 * squares.inverse();
  }
  fit.circle_px = circle;
  return fit;
}

RoundFit outermost(const RoundPatch& patch, const PatchEdges& edges, const RoundFit& fit) {
  const double radius = fit.circle_px.z();
  const RoundPlace further{static_cast<float>(fit.circle_px.x()), static_cast<float>(fit.circle_px.y()),
                           static_cast<float>(1.12 * radius)};
  const auto outer = fitted(patch, edges, further, {1.2F, 1.2F, 1.2F}, 0);
  if (!outer || outer->coverage < 0.75 || outer->error > fit.error + 0.05) return fit;
  const double ratio = outer->circle_px.z() / radius;
  const double off = (outer->circle_px - fit.circle_px).head<2>().norm() / radius;
  return ratio > 1.05 && ratio < 1.25 && off < 0.12 ? *outer : fit;
}

EllipseFit in_image(const RoundFit& fit, const Ellipse& e) {
  const cv::Matx23d m = image_from_patch(e);
  EllipseFit out;
  out.ellipse = e;
  out.ellipse.u_px = m(0, 0) * fit.circle_px.x() + m(0, 1) * fit.circle_px.y() + m(0, 2);
  out.ellipse.v_px = m(1, 0) * fit.circle_px.x() + m(1, 1) * fit.circle_px.y() + m(1, 2);
  const double size = fit.circle_px.z() / unit_px;
  out.ellipse.a_px *= size;
  out.ellipse.b_px *= size;
  // the shape is the circle's, but for perspective: a hundredth of the semi-axes, and of the direction what
  // is left open
  Eigen::Matrix<double, 5, 3> by = Eigen::Matrix<double, 5, 3>::Zero();
  by.topLeftCorner<2, 2>() << m(0, 0), m(0, 1), m(1, 0), m(1, 1);
  by(2, 2) = e.a_px / unit_px;
  by(3, 2) = e.b_px / unit_px;
  out.covariance = by * fit.covariance_px2 * by.transpose();
  const double shape_px = 0.02 * out.ellipse.a_px;
  out.covariance(2, 2) += shape_px * shape_px;
  out.covariance(3, 3) += shape_px * shape_px;
  const double open_rad = std::min(1.0, 0.02 / std::max(0.02, 1 - out.ellipse.b_px / out.ellipse.a_px));
  out.covariance(4, 4) += open_rad * open_rad;
  return out;
}

}  // namespace stevedore
