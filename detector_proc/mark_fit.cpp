#include "detector_proc/mark_fit.hpp"

#include <algorithm>
#include <cmath>

#include "detector_proc/ellipse_covariance.hpp"

namespace stevedore {
namespace {

/// Fit and covariance as the search leaves them, at full size.
EllipseFit coarse_fit(const EllipseEdge& edge, int factor) {
  EllipseFit fit{enlarged(edge.ellipse, factor),
                 covariance_of(edge.ellipse, edge.support, std::max(edge.support.rms_px, 0.1))};
  fit.covariance.topRows<4>() *= factor;
  fit.covariance.leftCols<4>() *= factor;
  return fit;
}

/// Half the way to the mark's other edge: what may be looked at of this one.
double reach_px(const MarkEdges& mark, int factor) {
  constexpr double unlimited_px = 100;
  if (!mark.inner) return unlimited_px;
  return factor * std::max(mark.outer.ellipse.b_px - mark.inner->ellipse.b_px, 0.0) / 2;
}

EllipseFit fine_fit(const EllipseEdge& edge, const LightImage& light, int factor, double reach,
                    const StripCounts& strips) {
  const Ellipse coarse = enlarged(edge.ellipse, factor);
  const double blur_px = 0.8 * factor;  // of a sharp lens at the size where it was found
  const auto fine = fit_subpixel(light.weighted(edge.weights), coarse, edge.bright, blur_px, reach, strips);
  // it must be the same edge
  const double margin_px = std::max(1.5, 0.05 * edge.ellipse.b_px) * factor;
  const bool same =
      fine && std::abs(fine->fit.ellipse.a_px - coarse.a_px) < margin_px &&
      std::abs(fine->fit.ellipse.b_px - coarse.b_px) < margin_px &&
      std::hypot(fine->fit.ellipse.u_px - coarse.u_px, fine->fit.ellipse.v_px - coarse.v_px) < margin_px;
  return same ? fine->fit : coarse_fit(edge, factor);
}

/// For half as many strips: a ring's inner edge tells of the same ellipse.
StripCounts half_of(const StripCounts& strips) {
  return {(strips.first_rounds + 1) / 2, (strips.last_round + 1) / 2};
}

/// Eq. (4) of the paper: mean of |left-hand side - 1| over the edge points.
double algebraic_error(const EllipseEdge& edge) {
  double sum = 0, count = 0;
  for (int k = 0; k < edge.support.count; ++k) {
    const EdgeSample& s = edge.support.samples[static_cast<std::size_t>(k)];
    if (!s.found) continue;
    sum += std::abs(normalized_radius_squared(edge.ellipse, {s.point.u_px, s.point.v_px}) - 1);
    ++count;
  }
  return count > 0 ? sum / count : 0;
}

}  // namespace

Ellipse enlarged(const Ellipse& e, int factor) {
  return {(e.u_px + 0.5) * factor - 0.5, (e.v_px + 0.5) * factor - 0.5, e.a_px * factor, e.b_px * factor,
          e.alpha_rad};
}

Ellipse lessened(const Ellipse& e, int factor) {
  return {(e.u_px + 0.5) / factor - 0.5, (e.v_px + 0.5) / factor - 0.5, e.a_px / factor, e.b_px / factor,
          e.alpha_rad};
}

StripCounts strips_of(const DetectorSettings& settings) {
  constexpr int enough_to_come_near = 64;
  const int strips = settings.subpixel_strips;
  return strips > 0 ? StripCounts{strips, 4 * strips} : StripCounts{enough_to_come_near, 0};
}

Detection detection_of(const MarkEdges& mark, const LightImage& light, int factor,
                       const StripCounts& strips) {
  // An edge with a gap of more than a tenth is not seen whole.
  constexpr double whole_coverage = 0.9;
  Detection d;
  const double reach = reach_px(mark, factor);
  d.outer = fine_fit(mark.outer, light, factor, reach, strips);
  if (mark.inner) d.inner = fine_fit(*mark.inner, light, factor, reach, half_of(strips));
  d.coverage = std::min(1.0, mark.outer.support.coverage());
  d.error = algebraic_error(mark.outer);
  d.kind = d.coverage >= whole_coverage ? Kind::whole : Kind::partial;
  return d;
}

}  // namespace stevedore
