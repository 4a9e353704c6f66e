#include "detector_proc/detector.hpp"

#include <cassert>
#include <utility>

#include "detector_proc/arc_method.hpp"
#include "detector_proc/expected_mark.hpp"
#include "detector_proc/paper_method.hpp"

namespace stevedore {

Detector::Detector(DetectorSettings settings, const Optics& optics)
    : settings_(std::move(settings)),
      optics_(optics),
      arcs_(std::make_unique<ArcMethod>()),
      region_(std::make_unique<ArcMethod>()) {
  assert(settings_.method == "arcs" || settings_.method == "paper");
}

Detector::Detector(Detector&&) noexcept = default;
Detector& Detector::operator=(Detector&&) noexcept = default;
Detector::~Detector() = default;

std::vector<Detection> Detector::detect(const cv::Mat& image) const {
  if (image.empty()) return {};
  assert(image.type() == CV_8UC1 || image.type() == CV_8UC3);
  return settings_.method == "paper" ? detect_by_paper(image, settings_)
                                     : arcs_->detect(image, settings_, optics_);
}

std::optional<Detection> Detector::detect_near(const cv::Mat& image, const Detection& expected) const {
  if (image.empty() || settings_.method == "paper") return std::nullopt;
  auto found = find_expected(image, expected, settings_, optics_);
  if (!found) found = region_->detect_near(image, expected, settings_, optics_);
  // what a neighbourhood cannot tell: that a rim stands in a circle
  if (found && expected.label != Label::circle) found->label = expected.label, found->occupied.reset();
  return found;
}

}  // namespace stevedore
