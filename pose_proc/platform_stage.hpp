// Part of pose_proc's stage: POSES as they are published, the aircraft's state and PLATFORM_STATE in,
// PLATFORM_ESTIMATE out, one for each platform and frame.
#pragma once

#include <deque>
#include <optional>

#include "geometry/attitude.hpp"
#include "platform/platform_estimator.hpp"
#include "runtime/bus.hpp"

namespace stevedore {

class PlatformStage {
 public:
  /// Subscribes to PLATFORM_STATE; the rest is handed on by the stage that hosts it.
  PlatformStage(const PlatformSettings& settings, const CameraMount& mount, Bus& bus);

  void hear(const vehicle_state_t& vehicle);
  void hear(const gimbal_state_t& gimbal);
  /// To be called with the poses of every frame, once they are published.
  void see(const poses_t& poses);

 private:
  /// Interpolated; level against the body where no gimbal has ever been heard, nothing where it has gone
  /// silent.
  [[nodiscard]] std::optional<GimbalAngles> gimbal_at(int64_t utime) const;

  Bus& bus_;
  const CameraMount mount_;
  PlatformEstimator estimator_;
  std::deque<gimbal_state_t> gimbal_states_;  ///< newest last
};

}  // namespace stevedore
