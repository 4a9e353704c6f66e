#include "detector_proc/mark_grouping.hpp"

#include <algorithm>
#include <cmath>

namespace stevedore {
namespace {

/// Ratio of the inner to the outer ellipse along rays from the outer one's centre: lowest and highest.
struct Ratios {
  double low, high;
};

Ratios ratios_of(const Ellipse& inner, const Ellipse& outer) {
  Ratios r{1e9, 0};
  for (int k = 0; k < 16; ++k) {
    const double ratio = std::sqrt(normalized_radius_squared(outer, point_at(inner, M_PI * k / 8)));
    r.low = std::min(r.low, ratio);
    r.high = std::max(r.high, ratio);
  }
  return r;
}

}  // namespace

/// Perspective moves the centre of a ring's inner edge by less than a tenth of its width at 60 degrees from
/// above; what a cut ellipse's fit leaves open comes on top.
bool one_ring(const EllipseEdge& inner, const EllipseEdge& outer, double min_ring_ratio) {
  // centres further apart than this spread the ratios by more than is let pass below
  const double apart_px =
      std::hypot(inner.ellipse.u_px - outer.ellipse.u_px, inner.ellipse.v_px - outer.ellipse.v_px);
  if (apart_px > 0.3 * outer.ellipse.a_px || inner.ellipse.b_px > 1.05 * outer.ellipse.b_px) return false;
  const Ratios r = ratios_of(inner.ellipse, outer.ellipse);
  const double mean = (r.low + r.high) / 2;
  const bool cut = std::min(inner.support.coverage(), outer.support.coverage()) < 0.7;
  return r.high < 1.02 && mean > min_ring_ratio && r.high - r.low < (cut ? 0.3 : 0.2);
}

std::vector<MarkEdges> group_rings(std::vector<EllipseEdge> edges, double min_ring_ratio) {
  std::stable_sort(edges.begin(), edges.end(), [](const EllipseEdge& a, const EllipseEdge& b) {
    return a.ellipse.a_px * a.ellipse.b_px > b.ellipse.a_px * b.ellipse.b_px;
  });
  std::vector<MarkEdges> marks;
  for (EllipseEdge& edge : edges) {
    const auto ring = std::find_if(marks.begin(), marks.end(), [&](const MarkEdges& mark) {
      return one_ring(edge, mark.outer, min_ring_ratio);
    });
    if (ring == marks.end()) {
      marks.push_back({std::move(edge), std::nullopt});
    } else if (!ring->inner) {
      ring->inner = std::move(edge);
    }
  }
  return marks;
}

}  // namespace stevedore
