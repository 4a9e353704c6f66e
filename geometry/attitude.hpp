// Where down is: from the aircraft's attitude, the gimbal's angles and the camera's mount to gravity in the
// camera frame.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace stevedore {

/// The down direction as the camera sees it.
struct Gravity {
  Eigen::Vector3d direction_camera;  ///< unit
  double sigma_rad = 0;              ///< of the direction, about each horizontal axis
};

/// Measured angles of the pan-tilt: camera platform against body. Roll, about the body's forward axis, is the
/// outer joint and pitch the inner one, so that (-roll, -pitch) of the aircraft holds the camera level
/// exactly.
struct GimbalAngles {
  double roll_rad = 0;
  double pitch_rad = 0;
};

/// How the camera sits on its pan-tilt: looking down with the top of the image forward (camera x = right,
/// y = backward, z = down), turned by a small misalignment about the platform's forward, right, down axes.
struct CameraMount {
  double roll_rad = 0;
  double pitch_rad = 0;
  double yaw_rad = 0;

  [[nodiscard]] Eigen::Matrix3d platform_from_camera() const;
};

/// At gimbal angles of zero the platform's axes are the body's: forward, right, down.
Eigen::Matrix3d body_from_camera(const GimbalAngles& gimbal, const CameraMount& mount);

/// Unit vector. ned_from_body: the aircraft's attitude, world north-east-down from body forward-right-down.
Eigen::Vector3d gravity_in_camera(const Eigen::Quaterniond& ned_from_body, const GimbalAngles& gimbal,
                                  const CameraMount& mount);

/// The smallest rotation that puts z along gravity: level frame from camera frame.
Eigen::Matrix3d level_from_camera(const Eigen::Vector3d& gravity_camera);

}  // namespace stevedore
