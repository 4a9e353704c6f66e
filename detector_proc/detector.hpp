// Finds painted circles and cargoes, as ellipses, in one image.
#pragma once

#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "detector_proc/detector_settings.hpp"
#include "detector_proc/optics.hpp"
#include "geometry/detection.hpp"

namespace stevedore {

class ArcMethod;

class Detector {
 public:
  explicit Detector(DetectorSettings settings = {}, const Optics& optics = {});
  Detector(Detector&&) noexcept;
  Detector& operator=(Detector&&) noexcept;
  ~Detector();

  /// Marks in a gray8 or bgr8 image, largest first. The same image gives the same result to the bit,
  /// whatever came before it. One thread at a time: memory is kept from frame to frame.
  [[nodiscard]] std::vector<Detection> detect(const cv::Mat& image) const;

  /// The mark where one is expected, looked for in its neighbourhood only, at a small part of the cost;
  /// nothing where it is not, and for method paper. The label is the expected one, unless that is a circle.
  [[nodiscard]] std::optional<Detection> detect_near(const cv::Mat& image, const Detection& expected) const;

 private:
  DetectorSettings settings_;
  Optics optics_;
  std::unique_ptr<ArcMethod> arcs_, region_;  ///< of their own, so that neither's memory changes size
};

}  // namespace stevedore
