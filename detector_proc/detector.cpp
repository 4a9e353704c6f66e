#include "detector_proc/detector.hpp"

#include <cassert>
#include <utility>

#include "detector_proc/paper_method.hpp"

namespace stevedore {

Detector::Detector(DetectorSettings settings) : settings_(std::move(settings)) {
  assert(settings_.method == "paper");
}

std::vector<Detection> Detector::detect(const cv::Mat& image) const {
  if (image.empty()) return {};
  assert(image.type() == CV_8UC1 || image.type() == CV_8UC3);
  return detect_by_paper(image, settings_);
}

}  // namespace stevedore
