// A camera that never ends by itself: it paces file sources, notices when a device vanishes or freezes, says
// so, and opens it again.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "camera_proc/source.hpp"

namespace stevedore {

/// Ticks at an absolute schedule: start + n / rate, without drift. Waits for nobody: ticks that were missed
/// by a period and more are left out and counted.
class Pacer {
 public:
  Pacer(double rate_hz, std::int64_t start_utime);
  [[nodiscard]] std::int64_t due_utime() const;
  /// The due tick was taken now.
  void advance(std::int64_t now_utime);
  [[nodiscard]] std::int64_t late_ticks() const { return late_ticks_; }

 private:
  double period_us_;
  std::int64_t start_utime_;
  std::int64_t tick_ = 0;
  std::int64_t late_ticks_ = 0;
};

struct CameraStatus {
  enum class State {
    ok,
    degraded,  ///< frames come, but something was wrong within the last 2 s
    failed,    ///< no frames; it is being opened again
    finished,  ///< a file source with `once` has been played
  };
  State state = State::failed;
  std::string message = "not opened yet";
};

/// Since the start.
struct CameraCounts {
  std::int64_t frames = 0;      ///< delivered
  std::int64_t unreadable = 0;  ///< image files or frames that could not be read or used
  std::int64_t late_ticks = 0;  ///< of the schedule of a file source
  std::int64_t superseded = 0;  ///< frames of a device that came faster than they were fetched
  std::int64_t reopened = 0;    ///< times that a lost device was opened again
};

struct CameraFrame {
  cv::Mat pixels;  ///< gray8 or bgr8, contiguous; shared with the camera: don't write into it
  std::int64_t capture_utime = 0;
};

class Camera {
 public:
  using Clock = std::function<std::int64_t()>;  ///< CLOCK_MONOTONIC us

  explicit Camera(const CameraSettings& settings);
  Camera(const CameraSettings& settings, Opener open, Clock clock);

  /// A frame, if there is one now. Never throws; returns within 50 ms (0.6 s when a blocking device is given
  /// up).
  std::optional<CameraFrame> next();

  [[nodiscard]] bool finished() const { return finished_; }
  [[nodiscard]] CameraStatus status() const;
  [[nodiscard]] CameraCounts counts() const;
  /// How long next() surely has nothing, at most 100 ms: sleep that long, so that a stop request is obeyed
  /// soon.
  [[nodiscard]] std::int64_t wait_us() const;
  /// Sleeps that long.
  void wait() const;

 private:
  bool open();
  [[nodiscard]] bool is_file() const;
  void lose(const std::string& why);
  void note_fault(const std::string& what);
  std::optional<CameraFrame> next_of_files();
  bool read_ahead();
  void end_of_files();
  std::optional<CameraFrame> next_of_device();
  bool check_frozen(const cv::Mat& raw, std::int64_t now);
  void check_silence(std::int64_t now);
  CameraFrame deliver(cv::Mat frame, std::int64_t capture_utime);

  CameraSettings settings_;
  Opener open_;
  Clock clock_;
  std::unique_ptr<FrameSource> source_;
  bool finished_ = false;

  // file sources
  std::optional<Pacer> pacer_;
  cv::Mat ahead_;                 // decoded before its tick, so that it is released on time
  std::int64_t pass_frames_ = 0;  // since the files were opened

  // devices
  cv::Mat last_;                             // newest image, as the device gave it
  std::int64_t changed_utime_ = 0;           // when it last differed from the one before, or of opening
  std::optional<std::int64_t> heard_utime_;  // newest image since opening
  std::int64_t opened_utime_ = 0;
  bool frozen_ = false;  // until an image differs: repeated ones are withheld

  // faults
  bool lost_ = true;  // until a frame comes
  std::string fault_ = "not opened yet";
  std::optional<std::int64_t> fault_utime_;
  std::int64_t retry_utime_ = 0;
  std::int64_t retry_wait_us_ = 0;
  CameraCounts counts_;
};

}  // namespace stevedore
