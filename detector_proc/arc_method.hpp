// The default method: arcs of edge chains, ellipses by evidence along their edges.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
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

 private:
  GradientField field_;
  EdgeLinker linker_;
  EdgeChains chains_;
  ArcSplitter splitter_;
  Arcs arcs_;
  cv::Mat small_;
};

}  // namespace stevedore
