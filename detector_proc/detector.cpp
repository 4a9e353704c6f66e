#include "detector_proc/detector.hpp"

#include <cassert>
#include <utility>

#include "detector_proc/arc_method.hpp"
#include "detector_proc/paper_method.hpp"

namespace stevedore {

Detector::Detector(DetectorSettings settings, const LightCurve& curve)
    : settings_(std::move(settings)), curve_(curve), arcs_(std::make_unique<ArcMethod>()) {
  assert(settings_.method == "arcs" || settings_.method == "paper");
}

Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;
Detector::~Detector() = default;

std::vector<Detection> Detector::detect(const cv::Mat& image) const {
  if (image.empty()) return {};
  assert(image.type() == CV_8UC1 || image.type() == CV_8UC3);
  return settings_.method == "paper" ? detect_by_paper(image, settings_)
                                     : arcs_->detect(image, settings_, curve_);
}

}  // namespace stevedore
