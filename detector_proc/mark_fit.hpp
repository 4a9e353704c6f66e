// From a mark's edges, as they were found, to what is told of it: sub-pixel ellipses in the frame.
#pragma once

#include "detector_proc/detector_settings.hpp"
#include "detector_proc/light_image.hpp"
#include "detector_proc/mark_grouping.hpp"
#include "detector_proc/subpixel_fit.hpp"
#include "geometry/detection.hpp"

namespace stevedore {

/// An ellipse of an image reduced by a whole factor, in the pixels of the image itself; and back.
Ellipse enlarged(const Ellipse& ellipse, int factor);
Ellipse lessened(const Ellipse& ellipse, int factor);

/// What a whole frame's marks are given, by `subpixel_strips`.
StripCounts strips_of(const DetectorSettings& settings);

/// The mark without its meaning. Edges are in pixels of the image reduced by `factor`, the result in those of
/// the light; an edge that no sub-pixel fit is found for stays as it is. A ring's inner edge
/// is looked at in half as many strips.
Detection detection_of(const MarkEdges& mark, const LightImage& light, int factor, const StripCounts& strips);

}  // namespace stevedore
