// A camera file for a camera model: what load_camera_file of runtime reads back to the bit.
#pragma once

#include <string>

#include "geometry/camera_model.hpp"

namespace stevedore {

std::string camera_yaml(const CameraModel& camera, const std::string& name);

/// The same view on another number of pixels: the width decides, pixels stay as square as they were.
CameraModel resized(const CameraModel& camera, int width_px, int height_px);

}  // namespace stevedore
