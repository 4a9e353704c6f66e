// What the detector knows of the camera: not needed, but edges and rims are told better with it.
#pragma once

#include <optional>

#include "detector_proc/light_image.hpp"
#include "geometry/camera_model.hpp"

namespace stevedore {

struct Optics {
  LightCurve light = linear_curve();  ///< levels are taken as light where no camera is known
  double focal_px = 0;                ///< of frames of this width; 0: unknown
  int width_px = 0;

  [[nodiscard]] double focal_px_of(const cv::Mat& frame) const {
    return frame.cols == width_px ? focal_px : 0;
  }
};

/// Of the rectified frames of a camera.
inline Optics optics_of(const std::optional<CameraModel>& camera) {
  return camera ? Optics{linear_light(camera->response), camera->rectified.fx_px, camera->rectified.width_px}
                : Optics{};
}

}  // namespace stevedore
