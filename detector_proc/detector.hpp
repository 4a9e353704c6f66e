// Finds painted circles and cargoes, as ellipses, in one image.
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "detector_proc/detector_settings.hpp"
#include "geometry/detection.hpp"

namespace stevedore {

class Detector {
 public:
  explicit Detector(DetectorSettings settings = {});

  /// Marks in a gray8 or bgr8 image, largest first. The same image gives the same result to the bit.
  [[nodiscard]] std::vector<Detection> detect(const cv::Mat& image) const;

 private:
  DetectorSettings settings_;
};

}  // namespace stevedore
