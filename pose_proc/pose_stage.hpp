// TRACKS and the attitude in, POSES and, from them, PLATFORM_ESTIMATE out.
#pragma once

#include <deque>
#include <map>
#include <optional>
#include <utility>

#include "geometry/camera_model.hpp"
#include "pose_proc/platform_stage.hpp"
#include "pose_proc/pose.hpp"
#include "runtime/bus.hpp"

namespace stevedore {

class PoseStage {
 public:
  /// Without a camera there are no metres: POSES carries the marks and says why there is no pose.
  PoseStage(const PoseSettings& settings, const std::optional<CameraModel>& camera, Bus& bus,
            const PlatformSettings& platforms = {});

 private:
  void on_tracks(const tracks_t& tracks);
  pose_t pose_of(const track_t& track, const std::optional<Gravity>& gravity);
  /// From the attitude and the gimbal's angles nearest in time; nothing when either is older than it may be.
  [[nodiscard]] std::optional<Gravity> gravity_at(int64_t utime) const;

  Bus& bus_;
  const PoseSettings settings_;
  const std::optional<CameraModel> camera_;
  PlatformStage platforms_;
  std::deque<vehicle_state_t> vehicle_states_;  ///< of the last second, newest last
  std::deque<gimbal_state_t> gimbal_states_;
  bool fits_camera_ = false;                    ///< the frame's size is the camera file's
  std::map<int64_t, PreviousChoice> previous_;  ///< by track
};

}  // namespace stevedore
