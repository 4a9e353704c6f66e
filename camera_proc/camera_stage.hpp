// A camera in, FRAME out.
#pragma once

#include <optional>

#include "camera_proc/source_camera.hpp"
#include "geometry/camera_model.hpp"
#include "geometry/rectify.hpp"
#include "runtime/bus.hpp"
#include "runtime/condition.hpp"
#include "runtime/frame_output.hpp"

namespace stevedore {

class CameraStage {
 public:
  /// With a camera whose lens distorts, frames are rectified before they are sent.
  CameraStage(const CameraSettings& settings, const std::optional<CameraModel>& camera, std::string ring_name,
              Bus& bus);

  /// Waits for the next frame, 100 ms at most, sends it, and says how the camera is.
  Condition work();

 private:
  void send(const CameraFrame& frame);

  /// Unpaced files wait for the line: until the newest frame sent came out of the tracker, or for a second.
  [[nodiscard]] bool line_is_busy() const;
  [[nodiscard]] input_health_t source_health() const;

  const CameraSettings settings_;
  Bus& bus_;
  Camera camera_;
  std::optional<CameraModel> model_;
  RectifyMaps maps_;
  FrameOutput output_;
  int64_t frame_seq_ = 0;
  int64_t sent_utime_ = 0;              ///< of the newest frame, by this host's clock
  int64_t answered_seq_ = -1;           ///< frame_seq of the newest TRACKS
  int64_t refused_ = 0;                 ///< frames that could not be sent
  std::optional<std::string> refusal_;  ///< of the newest frame
};

}  // namespace stevedore
