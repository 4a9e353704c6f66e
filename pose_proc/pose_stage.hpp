// TRACKS and the attitude in, POSES and, from them, PLATFORM_ESTIMATE out.
#pragma once

#include <array>
#include <deque>
#include <map>
#include <optional>
#include <utility>
#include <vector>

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
  /// How the aircraft and its camera stand.
  struct Attitude {
    Eigen::Matrix3d ned_from_body, body_from_camera;
    double sigma_rad = 0;
    [[nodiscard]] Gravity gravity() const;
  };
  /// Of a track's two normals in its last frame, the chosen one first. World: north-east-down, or the
  /// camera's axes where no attitude was known.
  struct Believed {
    std::array<Eigen::Vector3d, 2> normal_world;
    double probability = 0;
    int64_t utime = 0;
    bool in_ned = false;
  };

  void on_tracks(const tracks_t& tracks);
  /// Why no pose can be had; null: it can.
  [[nodiscard]] const char* obstacle() const;
  std::vector<CirclePose> estimates_of(const tracks_t& tracks, const std::optional<Attitude>& attitude);
  /// From the attitude and the gimbal's angles nearest in time; nothing when either is older than it may be.
  [[nodiscard]] std::optional<Attitude> attitude_at(int64_t utime) const;
  [[nodiscard]] std::optional<BeamRange> beam_at(int64_t utime, const Attitude& attitude) const;
  [[nodiscard]] std::optional<PreviousChoice> previous_of(int64_t track_id, int64_t utime,
                                                          const Eigen::Matrix3d& world_from_camera) const;

  Bus& bus_;
  const PoseSettings settings_;
  const std::optional<CameraModel> camera_;
  PlatformStage platforms_;
  std::deque<vehicle_state_t> vehicle_states_;  ///< of the last second, newest last
  std::deque<gimbal_state_t> gimbal_states_;
  std::deque<altimeter_t> altimeter_;
  bool fits_camera_ = false;              ///< the frame's size is the camera file's
  std::map<int64_t, Believed> previous_;  ///< by track
  bool previous_in_ned_now_ = false;      ///< the frame in hand has an attitude
};

}  // namespace stevedore
