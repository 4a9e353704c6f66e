// Camera files: ROS camera_info YAML, with three keys more.
//   response:  linear, srgb, or the gamma of level = light^(1 / gamma); absent means srgb, with a warning
//   mount_deg: {roll: , pitch: , yaw: }, misalignment of the camera on its pan-tilt; absent means none
//   calibration: what `calibrate` notes of how sure the numbers are; for people, not read
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/camera_model.hpp"
#include "runtime/config.hpp"

namespace stevedore {

struct CameraFile {
  CameraModel camera;
  std::vector<std::string> warnings;  ///< one sentence each, for the caller to print
};

/// Throws ConfigError with file, line, key and what is expected.
CameraFile load_camera_file(const std::string& path);

/// The camera named in a configuration, its warnings logged; nothing where none is named. Throws ConfigError.
std::optional<CameraModel> camera_of(const Config& config);

}  // namespace stevedore
