#include "tools/locate_frame.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

namespace stevedore {
namespace {

constexpr double frames_per_second = 30;  // of a sequence of files, which carry no time

using Clock = std::chrono::steady_clock;

double ms_since(Clock::time_point start) {
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// Without gravity the answer is the solution whose normal is nearer the optical axis, whatever else speaks
/// for the other; the probabilities stay what they are.
void put_nearer_axis_first(CirclePose& pose) {
  if (pose.solutions.size() < 2) return;
  const auto along_axis = [&](std::size_t i) { return pose.solutions[i].circle.normal_camera.z(); };
  if (along_axis(1) < along_axis(0)) std::swap(pose.solutions[0], pose.solutions[1]);
}

}  // namespace

Locator::Locator(const LocateSettings& settings)
    : settings_(settings),
      detector_(settings.detector, optics_of(settings.camera)),
      tracker_(settings.tracker) {
  if (settings_.camera) maps_ = make_rectify_maps(*settings_.camera);
  if (settings_.radius_m) settings_.pose.circle_radius_m = *settings_.radius_m;
  if (settings_.cargo_radius_m) settings_.pose.cargo_radius_m = *settings_.cargo_radius_m;
  if (!settings_.track) return;
  if (!settings_.track_pixel) {
    tracker_.follow_first_circle();
    return;
  }
  // Where the lens model has no inverse the pixel itself is the best guess.
  const Eigen::Vector2d given_px = *settings_.track_pixel;
  tracker_.follow_pixel(settings_.camera ? undistort(*settings_.camera, given_px).value_or(given_px)
                                         : given_px);
}

std::optional<std::string> Locator::refusal(const cv::Mat& image) const {
  if (!settings_.camera) return std::nullopt;
  const Pinhole& given = settings_.camera->given;
  if (image.cols == given.width_px && image.rows == given.height_px) return std::nullopt;
  const auto size = [](int width, int height) {
    return std::to_string(width) + "x" + std::to_string(height);
  };
  return "the image is " + size(image.cols, image.rows) + ", the camera file is for " +
         size(given.width_px, given.height_px);
}

std::optional<Ellipse> Locator::in_given(const Ellipse& rectified) const {
  return maps_.map_1.empty() ? rectified : distort(*settings_.camera, rectified);
}

std::vector<LocatedMark> Locator::locate(const std::vector<Detection>& detections) const {
  std::vector<LocatedMark> located;
  std::vector<MarkImage> marks;
  for (std::size_t i = 0; i < detections.size(); ++i) {
    const Detection& detection = detections[i];
    const auto given = in_given(detection.outer.ellipse);
    if (!given) continue;
    located.push_back({detection, *given, {}, static_cast<int>(i)});
    const bool radius_known = (detection.label == Label::circle && settings_.radius_m) ||
                              (detection.label == Label::cargo && settings_.cargo_radius_m);
    marks.push_back({detection.outer,
                     detection.inner,
                     radius_known ? detection.label : Label::unknown,
                     {},
                     detection.coverage,
                     detection.occupied.value_or(false)});
  }
  if (!settings_.camera) return located;
  auto poses = estimate_poses(marks, settings_.camera->rectified, {settings_.gravity, {}}, settings_.pose);
  for (std::size_t i = 0; i < located.size(); ++i) {
    located[i].pose = std::move(poses[i]);
    if (located[i].pose.reason == NoPose::another_size) {
      located[i].detection.label = Label::unknown;
      located[i].detection.occupied.reset();
    }
    if (!settings_.gravity) put_nearer_axis_first(located[i].pose);
  }
  return located;
}

LocatedTarget Locator::follow(int index, const cv::Mat& image, const std::vector<Detection>& found,
                              const std::vector<LocatedMark>& marks) {
  const TrackerResult result = tracker_.step(index / frames_per_second, image, found);
  LocatedTarget target;
  target.status = result.target.status;
  target.id = result.target.id;
  if (result.target.window) target.window = in_given(*result.target.window);
  if (target.status != TrackStatus::tracking && target.status != TrackStatus::predicted) return target;
  const auto track = std::find_if(result.tracks.begin(), result.tracks.end(),
                                  [&](const Track& t) { return t.id == result.target.id; });
  if (track == result.tracks.end()) return target;
  // what is seen is solved together with the rest of the image, where it has one pose
  const auto seen = std::find_if(marks.begin(), marks.end(), [&](const LocatedMark& mark) {
    return mark.detection_index == track->detection_index;
  });
  if (seen != marks.end()) {
    target.mark = *seen;
    return target;
  }
  auto alone = locate({track->detection});
  if (!alone.empty()) target.mark = std::move(alone.front());
  return target;
}

LocatedFrame Locator::step(int index, const cv::Mat& image) {
  LocatedFrame frame;
  const auto start = Clock::now();
  const cv::Mat rectified = rectify(image, maps_);
  const std::vector<Detection> found = detector_.detect(rectified);
  frame.detect_ms = ms_since(start);
  frame.marks = locate(found);
  if (settings_.track) frame.target = follow(index, rectified, found, frame.marks);
  return frame;
}

}  // namespace stevedore
