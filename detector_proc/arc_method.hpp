// The default method: arcs of edge chains, ellipses by evidence along their edges.
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detector_proc/arcs.hpp"
#include "detector_proc/detector_settings.hpp"
#include "detector_proc/edge_chains.hpp"
#include "detector_proc/gradient_field.hpp"
#include "detector_proc/light_image.hpp"
#include "geometry/detection.hpp"

namespace stevedore {

/// Holds what one frame after the other can use again: memory, nothing that a result depends on.
class ArcMethod {
 public:
  std::vector<Detection> detect(const cv::Mat& image, const DetectorSettings& settings,
                                const LightCurve& curve);

  /// The mark nearest to an expected ellipse, looked for in its neighbourhood only: the same method at the
  /// size at which the mark is small. Nothing within half a semi-axis and a fifth of size: not there.
  std::optional<Detection> detect_near(const cv::Mat& image, const Ellipse& expected,
                                       const DetectorSettings& settings, const LightCurve& curve);

 private:
  std::vector<Detection> detect_reduced(const cv::Mat& image, int reduction, const DetectorSettings& settings,
                                        const LightCurve& curve);

  GradientField field_;
  EdgeLinker linker_;
  EdgeChains chains_;
  ArcSplitter splitter_;
  Arcs arcs_;
  cv::Mat small_;
};

}  // namespace stevedore
