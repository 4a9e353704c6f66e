#include "detector_proc/ring_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace stevedore {
namespace {

constexpr int directions = 32;

/// Votes for one scale: in every direction each edge that faces the right way votes once.
std::vector<float> votes_of(const EllipseEdge& inner, const GradientField& field, int threshold, int bins) {
  const Ellipse& e = inner.ellipse;
  const float sign = inner.bright == Bright::within ? 1.F : -1.F;  // opposite to the inner edge's
  std::vector<float> votes(static_cast<std::size_t>(bins), 0.F);
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad);
  for (int k = 0; k < directions; ++k) {
    const double t = 2 * M_PI * k / directions, ct = std::cos(t), st = std::sin(t);
    const double rim_u = c * e.a_px * ct - s * e.b_px * st, rim_v = s * e.a_px * ct + c * e.b_px * st;
    // outward normal of any scaled copy in this direction
    const double x = e.b_px * ct, y = e.a_px * st, length = std::sqrt(x * x + y * y);
    const auto nu = static_cast<float>((c * x - s * y) / length),
               nv = static_cast<float>((s * x + c * y) / length);
    const double step_u = rim_u / e.b_px, step_v = rim_v / e.b_px;
    float last = 0, before_last = 0;
    for (int bin = 2; bin < bins; ++bin) {
      const int u = static_cast<int>(std::floor(e.u_px + rim_u + bin * step_u + 0.5));
      const int v = static_cast<int>(std::floor(e.v_px + rim_v + bin * step_v + 0.5));
      if (u < 1 || v < 1 || u > field.magnitude.cols - 2 || v > field.magnitude.rows - 2) break;
      const short* g = field.gradient.ptr<short>(v) + 2 * u;
      const float across = sign * (static_cast<float>(g[0]) * nu + static_cast<float>(g[1]) * nv);
      if (last > static_cast<float>(threshold) && last >= before_last && last > across) {
        votes[static_cast<std::size_t>(bin - 1)] += 1;
      }
      before_last = last;
      last = across;
    }
  }
  return votes;
}

}  // namespace

std::optional<EllipseEdge> look_outwards(const EllipseEdge& inner, const GradientField& field,
                                         const EdgeThresholds& thresholds, const EllipseSearch& search,
                                         double min_ring_ratio) {
  const Ellipse& e = inner.ellipse;
  const int bins = static_cast<int>(e.b_px * (1 / min_ring_ratio - 1)) + 2;
  const std::vector<float> votes = votes_of(inner, field, thresholds.follow, bins);
  int best = -1;
  float most = 0;
  for (int bin = 1; bin + 1 < bins; ++bin) {
    const auto k = static_cast<std::size_t>(bin);
    const float sum = votes[k - 1] + votes[k] + votes[k + 1];
    if (sum > most) most = sum, best = bin;
  }
  // a third of the way round, as much as an ellipse needs at first sight
  if (most < directions / 3.F) return std::nullopt;
  Ellipse outer = e;
  const double scale = 1 + best / e.b_px;
  outer.a_px *= scale;
  outer.b_px *= scale;
  return search.settle(outer, inner.bright == Bright::within ? Bright::without : Bright::within, -2);
}

}  // namespace stevedore
