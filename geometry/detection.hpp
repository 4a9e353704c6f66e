// One painted mark or round thing found in an image: what detector, tracker and pose code hand to each other.
#pragma once

#include <optional>

#include "geometry/ellipse.hpp"

namespace stevedore {

enum class Kind { whole, partial };
enum class Label { unknown, circle, cargo };

/// A fitted ellipse with the covariance of its five parameters.
struct EllipseFit {
  Ellipse ellipse;
  EllipseCovariance covariance = EllipseCovariance::Zero();  ///< of (u, v, a, b, alpha)
};

/// One physical mark: the two edges of a painted ring are one detection, its outer edge.
struct Detection {
  EllipseFit outer;
  std::optional<EllipseFit> inner;  ///< the ring's inner edge, where one was fitted
  double error = 0;                 ///< mean algebraic error of the edge points, the paper's eq. (4)
  double coverage = 0;              ///< share of the perimeter supported by edges, 0..1
  Kind kind = Kind::whole;
  Label label = Label::unknown;
  std::optional<bool> occupied;  ///< a cargo stands in this circle; nothing: can't tell
};

}  // namespace stevedore
