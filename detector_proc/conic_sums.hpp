// Least-squares conics whose normal equations add: an ellipse through two arcs is one more solve.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "geometry/ellipse.hpp"

namespace stevedore {

/// A place on an edge, with the direction of the edge there.
struct EdgePoint {
  float u_px, v_px;
  float tangent_u, tangent_v;  ///< unit
};

/// Pixels to the coordinates in which conics are fitted: centred, about one in size, so that the normal
/// equations are well conditioned (Hartley 1997).
struct FitFrame {
  double u_px = 0, v_px = 0, scale_px = 1;
};

/// Sums over edge points for the conic A (x^2 - y^2) + B x y + D x + E y + F + y^2 = 0, which is any conic,
/// scaled so that A + C = 1; it turns with the axes and no ellipse is left out. Every point gives two
/// equations: the conic passes through it (Q = 0), in the direction of its tangent (t . grad Q = 0).
class ConicSums {
 public:
  /// `weight` multiplies both equations' squares; `lever_px`, the point's error over the tangent's (rad), is
  /// how much the direction counts.
  void add(const EdgePoint& point, const FitFrame& frame, double weight, double lever_px);
  void add(const ConicSums& other);

  /// The ellipse, in pixels; nothing if the conic is none.
  [[nodiscard]] std::optional<Ellipse> solve(const FitFrame& frame) const;

 private:
  std::array<double, 21> sums_{};  ///< upper triangle of the 5 equations and the right-hand side, row by row
};

}  // namespace stevedore
