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

  Bus& bus_;
  Camera camera_;
  RectifyMaps maps_;
  FrameOutput output_;
  int64_t frame_seq_ = 0;
  std::optional<std::string> refusal_;  ///< of the newest frame
};

}  // namespace stevedore
