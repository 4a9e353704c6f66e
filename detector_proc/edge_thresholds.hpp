// What counts as an edge in this frame: thresholds from its own noise and texture.
#pragma once

#include "detector_proc/gradient_field.hpp"

namespace stevedore {

/// Gradient magnitudes, in the units of GradientField.
struct EdgeThresholds {
  int follow = 0;  ///< an edge is followed as long as it is above
  int start = 0;   ///< and started where it is above
};

/// From the median magnitude, which is that of noise and texture as long as the edges looked for cover less
/// than half of the frame.
EdgeThresholds edge_thresholds(const GradientField& field);

}  // namespace stevedore
