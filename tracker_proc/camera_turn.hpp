// How the camera turned between two frames, from what autopilot and pan-tilt tell.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <deque>
#include <optional>

#include "geometry/attitude.hpp"
#include "geometry/camera.hpp"

namespace stevedore {

struct AttitudeSample {
  double time_s = 0;
  Eigen::Quaterniond ned_from_body;
  Eigen::Vector3d rate_body_radps;
};

struct GimbalSample {
  double time_s = 0;
  GimbalAngles angles;
};

/// The last samples of both, in one clock with the frames.
class CameraTurn {
 public:
  CameraTurn(const Pinhole& camera, const CameraMount& mount) : camera_(camera), mount_(mount) {}

  void add(const AttitudeSample& sample);
  void add(const GimbalSample& sample);

  /// Homography from the image of the frame asked for before to the one at time_s: K R K^-1 (Hartley and
  /// Zisserman 2004, 8.4.2). Nothing for the first frame, or where either frame's attitude is not known: no
  /// sample near enough, or a pan-tilt that has fallen silent.
  std::optional<Eigen::Matrix3d> homography_to(double time_s);

  /// World (north, east, down) from camera.
  [[nodiscard]] std::optional<Eigen::Matrix3d> ned_from_camera(double time_s) const;

 private:
  Pinhole camera_;
  CameraMount mount_;
  std::deque<AttitudeSample> attitudes_;  ///< newest last
  std::deque<GimbalSample> gimbals_;
  std::optional<Eigen::Matrix3d> before_;  ///< ned_from_camera of the frame before
};

}  // namespace stevedore
