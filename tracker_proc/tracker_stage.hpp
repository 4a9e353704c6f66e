// ELLIPSES, the frames they were found in, TRACK_COMMAND and the attitude in, TRACKS out.
#pragma once

#include <deque>
#include <optional>

#include "geometry/camera_model.hpp"
#include "runtime/bus.hpp"
#include "runtime/frame_codec.hpp"
#include "tracker_proc/camera_turn.hpp"
#include "tracker_proc/tracker.hpp"

namespace stevedore {

class TrackerStage {
 public:
  /// Without a camera, or for frames of another size, the attitude is of no use: all is done in pixels.
  TrackerStage(const TrackerSettings& settings, const std::optional<CameraModel>& camera, Bus& bus,
               FrameReader& frames);

 private:
  void on_frame(const frame_t& frame);
  void on_ellipses(const ellipses_t& ellipses);
  void on_command(const track_command_t& command);
  void on_vehicle(const vehicle_state_t& vehicle);
  void on_gimbal(const gimbal_state_t& gimbal);
  FrameView view_of(const ellipses_t& ellipses);
  void follow_id(int64_t id, const std::optional<Eigen::Vector2d>& pixel);
  /// The image that the ellipses were found in; empty when it is gone.
  cv::Mat image_of(const ellipses_t& ellipses);

  Bus& bus_;
  FrameReader& frames_;
  Tracker tracker_;
  std::optional<Pinhole> camera_;
  std::optional<CameraTurn> turn_;
  std::deque<frame_t> recent_frames_;       ///< newest last
  std::vector<Track> tracks_;               ///< of the newest frame
  std::optional<track_command_t> command_;  ///< in force
  TrackStatus target_status_ = TrackStatus::searching;
};

}  // namespace stevedore
