// ELLIPSES, the frames they were found in and TRACK_COMMAND in, TRACKS out.
#pragma once

#include <deque>
#include <optional>

#include "runtime/bus.hpp"
#include "runtime/frame_codec.hpp"
#include "tracker_proc/tracker.hpp"

namespace stevedore {

class TrackerStage {
 public:
  TrackerStage(const TrackerSettings& settings, Bus& bus, FrameReader& frames);

 private:
  void on_frame(const frame_t& frame);
  void on_ellipses(const ellipses_t& ellipses);
  void on_command(const track_command_t& command);
  void follow_id(int64_t id, const std::optional<Eigen::Vector2d>& pixel);
  /// The image that the ellipses were found in; empty when it is gone.
  cv::Mat image_of(const ellipses_t& ellipses);

  Bus& bus_;
  FrameReader& frames_;
  Tracker tracker_;
  std::deque<frame_t> recent_frames_;       ///< newest last
  std::vector<Track> tracks_;               ///< of the newest frame
  std::optional<track_command_t> command_;  ///< in force
  TrackStatus target_status_ = TrackStatus::searching;
};

}  // namespace stevedore
