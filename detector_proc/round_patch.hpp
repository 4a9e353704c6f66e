// The neighbourhood of a circle with the circle made round: there, a rim is a circle too.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>

#include "geometry/ellipse.hpp"

namespace stevedore {

constexpr int patch_px = 96;
constexpr float unit_px = 34;  ///< the circle's radius in the patch: a rim of 11 px, a pixel is a tenth of it
constexpr float middle_px = (patch_px - 1) / 2.F;

/// From the patch into the image.
cv::Matx23d image_from_patch(const Ellipse& circle);
/// Middle and radius of an ellipse as round as the circle.
Eigen::Vector3d in_patch(const Ellipse& edge, const Ellipse& circle);
/// Of an ellipse's area.
double share_in_view(const Ellipse& ellipse, cv::Size size);

struct RoundPatch {
  cv::Mat pixels;
  cv::Mat_<std::uint8_t> seen;  ///< of which pixels the image has something

  [[nodiscard]] bool sees(int v, int u) const {
    return u >= 0 && v >= 0 && u < patch_px && v < patch_px && seen(v, u) != 0;
  }
};

/// Empty pixels where too little of it is in the image.
RoundPatch round_patch(const cv::Mat& image, Ellipse circle);

/// Gradient of the channel that changes most, pixel by pixel, in levels per pixel; 0 where nothing is seen.
struct PatchEdges {
  cv::Mat_<float> along, down, magnitude;
  float threshold = 0;
};

PatchEdges edges_of(const RoundPatch& patch);

}  // namespace stevedore
