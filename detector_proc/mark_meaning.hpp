// What a mark is, from the image alone.
#pragma once

#include <optional>
#include <vector>

#include "detector_proc/edge_thresholds.hpp"
#include "detector_proc/mark_grouping.hpp"
#include "geometry/detection.hpp"

namespace stevedore {

struct MarkMeaning {
  Label label = Label::circle;
  std::optional<bool> occupied;  ///< of a circle; nothing: can't tell
};

/// In the order of the marks, which come largest first. An ellipse on its own is a circle. Within a circle,
/// what looks like a circle parallel to it is the rim of a cargo, which makes the circle occupied; anything
/// else there is unknown. A circle is empty where nothing in it has an edge; with edges that make no rim (a
/// cross, a shadow, a bucket whose rim is not seen) there is no telling.
std::vector<MarkMeaning> find_meanings(const std::vector<MarkEdges>& marks, const GradientField& field,
                                       const EdgeThresholds& thresholds);

/// Nothing stands well within the ellipse: no edge there is above the noise of its own inside. False where
/// the ellipse is too small to say, or less than this share of it is in the field.
bool nothing_inside(const Ellipse& e, const GradientField& field, double least_in_field);

}  // namespace stevedore
