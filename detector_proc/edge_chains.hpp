// Linking: chains of edge pixels, from seeds that look ahead.
#pragma once

#include <vector>

#include "detector_proc/edge_thresholds.hpp"
#include "detector_proc/gradient_field.hpp"

namespace stevedore {

/// Pixels of all chains one behind the other. Walking along a chain the bright side is on the right hand: the
/// tangent is the gradient (u, v) turned a quarter, (v, -u). Round a bright disc the way turns clockwise.
struct EdgeChains {
  struct Range {
    int begin, end;
  };
  std::vector<int> pixels;  ///< offsets into the magnitude's rows: v * width + u
  std::vector<Range> chains;
};

/// Links edges. The cost of linking is texture: an edge is followed only from a seed that stands on one of a
/// grid's lines, is above the start threshold, and whose gradient still agrees a few pixels along the tangent
/// to either side.
class EdgeLinker {
 public:
  /// Chains of at least `min_length` pixels.
  void link(const GradientField& field, const EdgeThresholds& thresholds, int min_length, EdgeChains& chains);

 private:
  cv::Mat taken_;  ///< CV_8UC1, pixels of chains so far
  std::vector<int> backward_;
};

}  // namespace stevedore
