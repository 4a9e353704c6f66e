// The last step: the ellipse fitted to the light of the pixels along its edge.
#pragma once

#include <optional>

#include "detector_proc/edge_support.hpp"
#include "detector_proc/light_image.hpp"
#include "geometry/detection.hpp"

namespace stevedore {

struct SubpixelFit {
  EllipseFit fit;
  double blur_px = 0;  ///< deviation of the blur across the edge, the pixel's own square included
};

/// Rows and columns of pixels that are looked at, evenly spread along the edge; 0: all.
struct StripCounts {
  int first_rounds = 0;  ///< which need only come near
  int last_round = 0;
};

/// Weighted least squares on pixel values, no interpolation between them. Every row or column that the edge
/// crosses is a blurred step: its place comes from the matched filter, which is the most likely one for white
/// noise, its two levels from the strips around it. The half level of a blurred edge lies blur^2 / (2 radius)
/// on the inner side of a curve (Bouma et al. 2005); that is put back. Outliers are weighed down (Tukey).
///
/// `blur_px` is a first guess, `reach_px` how far on either side the frame may be looked at: half the width
/// of a thin ring. Nothing where too little of the edge is seen.
std::optional<SubpixelFit> fit_subpixel(const LightImage& image, const Ellipse& guess, Bright bright,
                                        double blur_px, double reach_px, const StripCounts& counts);

}  // namespace stevedore
