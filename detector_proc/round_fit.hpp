// Round edges in a patch: voted for, then fitted. A rim is one of them.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "detector_proc/round_patch.hpp"
#include "geometry/detection.hpp"

namespace stevedore {

struct RoundPlace {
  float u, v, radius;
};

/// Where circles of one of the radii have a quarter of their edge or more, the most of it first.
std::vector<RoundPlace> voted_places(const PatchEdges& edges, const std::vector<float>& radii_px);

struct RoundFit {
  Eigen::Vector3d circle_px;  ///< centre, radius
  Eigen::Matrix3d covariance_px2;
  double coverage = 0;
  double error = 0;
};

constexpr int directions = 64;

struct PatchDirection {
  float u, v;
};

inline const std::array<PatchDirection, directions>& all_directions() {
  static const std::array<PatchDirection, directions> all = [] {
    std::array<PatchDirection, directions> d{};
    for (int k = 0; k < directions; ++k) {
      const float t = 2 * std::numbers::pi_v<float> * static_cast<float>(k) / directions;
      d[static_cast<std::size_t>(k)] = {std::cos(t), std::sin(t)};
    }
    return d;
  }();
  return all;
}

/// The pixel at a place in the patch or around it.
inline cv::Point pixel_at(float u, float v) {
  constexpr float shift = 1024.5F;  // what is cast is positive: rounds
  return {static_cast<int>(u + shift) - 1024, static_cast<int>(v + shift) - 1024};
}

/// A circle fitted to the edges around a place.
/// bands_px: of the edges looked at on either side, fit by fit.
/// radius_weight: of the place's radius, in edges.
std::optional<RoundFit> fitted(const RoundPatch& patch, const PatchEdges& edges, const RoundPlace& place,
                               const std::array<float, 3>& bands_px, double radius_weight);
/// A rim has two edges, a tenth of its radius apart; what is inside is the stronger one where it is dark.
RoundFit outermost(const RoundPatch& patch, const PatchEdges& edges, const RoundFit& fit);
EllipseFit in_image(const RoundFit& fit, const Ellipse& circle);

}  // namespace stevedore
