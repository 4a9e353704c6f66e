#include "geometry/attitude.hpp"

namespace stevedore {
namespace {

Eigen::Matrix3d about_x(double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitX()).toRotationMatrix();
}

Eigen::Matrix3d about_y(double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitY()).toRotationMatrix();
}

Eigen::Matrix3d about_z(double angle_rad) {
  return Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

}  // namespace

Eigen::Matrix3d CameraMount::platform_from_camera() const {
  Eigen::Matrix3d looking_down;  // columns: camera x, y, z on the platform's forward, right, down axes
  looking_down << 0, -1, 0,      //
      1, 0, 0,                   //
      0, 0, 1;
  return about_z(yaw_rad) * about_y(pitch_rad) * about_x(roll_rad) * looking_down;
}

Eigen::Matrix3d body_from_camera(const GimbalAngles& gimbal, const CameraMount& mount) {
  return about_x(gimbal.roll_rad) * about_y(gimbal.pitch_rad) * mount.platform_from_camera();
}

Eigen::Vector3d gravity_in_camera(const Eigen::Quaterniond& ned_from_body, const GimbalAngles& gimbal,
                                  const CameraMount& mount) {
  const Eigen::Vector3d gravity_body = ned_from_body.normalized().conjugate() * Eigen::Vector3d::UnitZ();
  return body_from_camera(gimbal, mount).transpose() * gravity_body;
}

Eigen::Matrix3d level_from_camera(const Eigen::Vector3d& gravity_camera) {
  return Eigen::Quaterniond::FromTwoVectors(gravity_camera, Eigen::Vector3d::UnitZ()).toRotationMatrix();
}

}  // namespace stevedore
