// A cargo in a circle has a round rim parallel to it: looked for, or ruled out, in every circle.
#pragma once

#include <opencv2/core.hpp>
#include <optional>

#include "geometry/detection.hpp"

namespace stevedore {

struct Rim {
  EllipseFit fit;
  double coverage = 0;  ///< share of its edge that was found
  double error = 0;     ///< mean of |normalized radius squared - 1| over the edge found: eq. (4) of the paper
};

struct RimSearch {
  std::optional<Rim> rim;
  std::optional<bool> occupied;  ///< nothing: there is something that may be a cargo, or part is out of view
};

/// What a rim's radius may be, in radii of the circle as it is seen.
struct RimRadii {
  double smallest, largest;
  bool known = false;  ///< as well as it can be: the camera is
};

/// Looks into the frame in which the circle is the unit circle, where a rim is a circle too, larger than on
/// the ground because it is nearer (for a bucket's rim of 0.16 m over a circle of 0.5 m, 0.3 m nearer to the
/// camera: 0.32 from far away, 0.40 from 1.5 m). Any change of colour is an edge, whichever side is the
/// brighter: a rim is lit here, in shadow there. Each edge pixel votes for the centres of circles that it
/// could be on, along its gradient (Kimme, Ballard, Sklansky 1975); circles are fitted to the edges around
/// the best. Painted rings, letters and worn paint can be as round: what is inside a rim has a colour of its
/// own, neither the paint's nor the ground's nor a mixture. image: gray8 or bgr8, of a camera that looks
/// down. inner: the circle's inner edge, where it is a ring.
RimSearch look_for_rim(const cv::Mat& image, const Ellipse& circle, const std::optional<EllipseFit>& inner,
                       const RimRadii& radii);

/// Whether a round edge in a circle is paint: in the middle, where rings are painted, and with nothing inside
/// it that has a colour of its own.
bool is_painted(const cv::Mat& image, const Ellipse& circle, const std::optional<EllipseFit>& inner,
                const Ellipse& edge);

}  // namespace stevedore
