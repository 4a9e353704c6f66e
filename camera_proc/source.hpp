// Where frames come from: image files, a video file, a V4L2 camera, a GStreamer pipeline. One interface for
// all; pacing, faults and re-opening are camera_proc/source_camera.hpp's.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "runtime/frame_output.hpp"

namespace stevedore {

struct CameraSettings {
  std::string kind = "images";
  std::string source;
  double rate_hz = 30;
  std::string colour = "auto";
  bool once = false;
  bool paced = true;
  int width_px = 0;
  int height_px = 0;
  FrameTransport frames;
  double retry_first_s = 0.2;
  double retry_limit_s = 5;
  double frozen_after_s = 2;
};

template <class Visitor>
void describe(CameraSettings& s, Visitor& visit) {
  visit.choice("kind", s.kind, {"images", "video", "v4l2", "gstreamer"}, "what the source is");
  visit("source", s.source,
        "images: folder, file or glob pattern; video: file; v4l2: /dev/video0; gstreamer: a pipeline that "
        "ends in "
        "appsink");
  visit("rate_hz", s.rate_hz, 0.0, 1000.0, "Hz",
        "rate at which files are played and which devices are asked for; 0: the source's own (images: 30)");
  visit.choice("colour", s.colour, {"auto", "grey", "colour"}, "pixels sent; auto: as the source has them");
  visit("once", s.once,
        "image and video files: end after one pass, or at once if there is nothing to read, instead of "
        "starting over");
  visit("paced", s.paced,
        "image and video files: play at rate_hz; off: each as soon as the tracker has answered the one "
        "before (after 1 s "
        "at the latest), stamped rate_hz");
  visit("width_px", s.width_px, 0.0, 32767.0, "px", "width a device is asked for; 0: its own");
  visit("height_px", s.height_px, 0.0, 32767.0, "px", "height a device is asked for; 0: its own");
  describe(s.frames, visit);
  visit("retry_first_s", s.retry_first_s, 0.01, 60.0, "s",
        "wait before a lost source is opened again; doubles each time");
  visit("retry_limit_s", s.retry_limit_s, 0.01, 600.0, "s", "longest such wait");
  visit("frozen_after_s", s.frozen_after_s, 0.1, 60.0, "s",
        "raise: a camera that repeats one image, or sends none, is noticed later");
}

enum class Grab {
  frame,
  none,    ///< nothing within a few tens of milliseconds; ask again
  end,     ///< of a file source: all has been read
  failed,  ///< fault() says why
};

/// One opened source. Not thread-safe.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// The next image as the source has it, in memory of its own. capture_utime is CLOCK_MONOTONIC us, taken
  /// before decoding; file sources leave it alone: their frames are captured when they are released.
  virtual Grab grab(cv::Mat& image, std::int64_t& capture_utime) = 0;
  [[nodiscard]] virtual std::string fault() const = 0;
  /// A device: it sets the pace, it can vanish and it can freeze. Otherwise files.
  [[nodiscard]] virtual bool is_live() const = 0;
  /// Frames that a device gave and nobody fetched before the next one, since the last call.
  virtual std::int64_t take_superseded() { return 0; }
  /// Rate of a video file, 0 if unknown.
  [[nodiscard]] virtual double own_rate_hz() const { return 0; }
};

/// Opens the source: null and a fault if that fails. Called again after each loss.
using Opener = std::function<std::unique_ptr<FrameSource>(std::string& fault)>;

/// The opener for these settings. Devices are opened and read in a thread of their own, so that a driver that
/// blocks (OpenCV waits 10 s for a V4L2 frame) delays nobody.
Opener make_opener(const CameraSettings& settings);

/// image.9 before image.10: runs of digits compare as numbers.
bool natural_less(const std::string& a, const std::string& b);

/// Files of a folder (image suffixes only) or of a glob pattern, in natural order.
std::vector<std::string> image_files(const std::string& folder_or_pattern);

/// gray8 or bgr8 in contiguous memory from whatever a source gave: 16-bit is scaled to 8, alpha dropped.
/// colour as in the settings. Nothing and a fault if it is no image that could be sent.
std::optional<cv::Mat> to_frame(const cv::Mat& image, const std::string& colour, std::string& fault);

/// The driver's own stamp if it is CLOCK_MONOTONIC, as V4L2 drivers' are: no more than 1 s before now.
std::int64_t capture_instant(double driver_stamp_ms, std::int64_t now_utime);

}  // namespace stevedore
