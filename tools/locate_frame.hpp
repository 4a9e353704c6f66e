// What locate does with one image: rectify, detect, follow the target, solve poses. No files, no JSON.
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "detector_proc/detector.hpp"
#include "geometry/camera_model.hpp"
#include "geometry/rectify.hpp"
#include "pose_proc/pose.hpp"
#include "tracker_proc/tracker.hpp"

namespace stevedore {

struct LocateSettings {
  DetectorSettings detector;
  TrackerSettings tracker;
  PoseSettings pose;
  std::optional<CameraModel> camera;
  std::optional<double> radius_m;  ///< of a circle's outer edge
  std::optional<double> cargo_radius_m;
  std::optional<Gravity> gravity;
  bool track = false;
  std::optional<Eigen::Vector2d> track_pixel;  ///< in the image as given; none: the first circle
};

struct LocatedMark {
  Detection detection;  ///< where the vision code works: in the rectified image
  Ellipse given;        ///< its outer edge in the image as given
  CirclePose pose;      ///< without solutions where camera or radius are missing
  int detection_index;  ///< among those that were located with it
};

struct LocatedTarget {
  TrackStatus status = TrackStatus::searching;
  std::optional<std::int64_t> id;
  std::optional<LocatedMark> mark;  ///< measured or predicted; none while searching or lost
  std::optional<Ellipse> window;    ///< CAMShift's, in the image as given
};

struct LocatedFrame {
  double detect_ms = 0;
  std::vector<LocatedMark> marks;
  std::optional<LocatedTarget> target;  ///< with tracking only
};

class Locator {
 public:
  explicit Locator(const LocateSettings& settings);

  /// Why this image can't be used with the camera; nothing if it can.
  [[nodiscard]] std::optional<std::string> refusal(const cv::Mat& image) const;

  /// A gray8 or bgr8 image, the index-th of the sequence.
  LocatedFrame step(int index, const cv::Mat& image);

 private:
  [[nodiscard]] std::optional<Ellipse> in_given(const Ellipse& rectified) const;
  [[nodiscard]] std::vector<LocatedMark> locate(const std::vector<Detection>& detections) const;
  /// marks: of these detections.
  [[nodiscard]] LocatedTarget follow(int index, const cv::Mat& image, const std::vector<Detection>& found,
                                     const std::vector<LocatedMark>& marks);

  LocateSettings settings_;
  RectifyMaps maps_;
  Detector detector_;
  Tracker tracker_;
};

}  // namespace stevedore
