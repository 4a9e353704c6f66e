#include "detector_proc/edge_owners.hpp"

#include <algorithm>
#include <cmath>

#include "detector_proc/ellipse_distance.hpp"

namespace stevedore {
namespace {

/// Share of an edge's support that lies on another ellipse of the same contrast.
double share_of(const EllipseEdge& edge, const EllipseEdge& owner) {
  constexpr double near_px = 2;  // two edges this close are one to the 5x5 derivative
  const EllipseDistance distance(owner.ellipse);
  double on_px = 0;
  for (int k = 0; k < edge.support.count; ++k) {
    const EdgeSample& s = edge.support.samples[static_cast<std::size_t>(k)];
    if (s.found && std::abs(distance(s.point.u_px, s.point.v_px)) < near_px) on_px += s.length_px;
  }
  return on_px / std::max(edge.support.supported_px, 1.0);
}

}  // namespace

std::vector<EllipseEdge> settle_owners(std::vector<EllipseEdge> edges) {
  std::stable_sort(edges.begin(), edges.end(),
                   [](const EllipseEdge& a, const EllipseEdge& b) { return a.evidence > b.evidence; });
  // Two marks that touch share a few pixels; an ellipse through parts of others shares most.
  constexpr double most_shared = 0.3;
  std::vector<EllipseEdge> kept;
  for (EllipseEdge& edge : edges) {
    const bool borrowed = std::any_of(kept.begin(), kept.end(), [&](const EllipseEdge& owner) {
      // which side is the bright one differs from plane to plane
      const bool alike = owner.bright == edge.bright || owner.weights != edge.weights;
      return alike && share_of(edge, owner) > most_shared;
    });
    if (!borrowed) kept.push_back(std::move(edge));
  }
  return kept;
}

}  // namespace stevedore
