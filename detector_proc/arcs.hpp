// Arcs: pieces of edge chains that turn steadily to one side.
#pragma once

#include <vector>

#include "detector_proc/conic_sums.hpp"
#include "detector_proc/edge_chains.hpp"

namespace stevedore {

struct Arc {
  int begin, end;  ///< of Arcs::points
  float turn_rad;  ///< > 0: clockwise as seen, the bright side within
  ConicSums sums;
};

struct Arcs {
  std::vector<EdgePoint> points;
  std::vector<Arc> arcs;
};

/// How much an edge point's direction counts against its place: the error of a place is about 0.15 px, that
/// of the gradient's direction 3 degrees.
inline constexpr double tangent_lever_px = 3;

/// Splits chains where the sense of turning changes and at corners; keeps what turns enough to show an
/// ellipse, with its points to sub-pixel.
class ArcSplitter {
 public:
  void split(const GradientField& field, const EdgeChains& chains, const FitFrame& frame, Arcs& arcs);

 private:
  std::vector<float> turns_rad_;  ///< along one chain, from its start
};

/// Sums over some of the points.
ConicSums sums_of(const std::vector<EdgePoint>& points, int begin, int end, const FitFrame& frame);

}  // namespace stevedore
