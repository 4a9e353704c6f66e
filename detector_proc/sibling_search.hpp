// Marks come in sets of one size: what is as large as a mark that was found needs less evidence of its own.
#pragma once

#include <vector>

#include "detector_proc/edge_chains.hpp"
#include "detector_proc/ellipse_search.hpp"

namespace stevedore {

/// The pixels of all chains with the directions of their gradients, in 256ths of a turn.
struct EdgeDirections {
  std::vector<float> u_px, v_px;
  std::vector<std::uint8_t> direction;
  std::vector<float> angle_rad;  ///< the same, finer: memory to be used again
};

void find_directions(const GradientField& field, const EdgeChains& chains, EdgeDirections& edges);

/// Ellipses of the shape of `found` elsewhere in the same plane of the frame, worn, hidden or cut as they may
/// be. Each chain's pixels vote for the centres of ellipses of this shape that they would be on, with the
/// bright side within or without (the generalized Hough transform with one shape, Ballard 1981); the best
/// places are settled with the shape as prior knowledge. `known`: ellipses that need no looking for.
std::vector<EllipseEdge> look_for_siblings(const Ellipse& found, const std::vector<Ellipse>& known,
                                           cv::Size frame, const EdgeDirections& edges,
                                           const EllipseSearch& search);

}  // namespace stevedore
