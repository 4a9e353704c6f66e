// The camera as the vision code sees it: an ideal pinhole (camera_proc removes the lens distortion).
#pragma once

#include <Eigen/Core>

namespace stevedore {

/// Camera frame: x right, y down, z forward. Pixel (0, 0) is the centre of the upper-left pixel.
struct Pinhole {
  int width_px = 0;
  int height_px = 0;
  double fx_px = 0;
  double fy_px = 0;
  double cx_px = 0;
  double cy_px = 0;

  [[nodiscard]] Eigen::Matrix3d matrix() const {
    return (Eigen::Matrix3d() << fx_px, 0, cx_px, 0, fy_px, cy_px, 0, 0, 1).finished();
  }
  /// Image point of a point in the camera frame, which must have z > 0.
  [[nodiscard]] Eigen::Vector2d project(const Eigen::Vector3d& point_camera_m) const {
    return {fx_px * point_camera_m.x() / point_camera_m.z() + cx_px,
            fy_px * point_camera_m.y() / point_camera_m.z() + cy_px};
  }
  /// Direction of a pixel's ray, with z = 1.
  [[nodiscard]] Eigen::Vector3d unproject(const Eigen::Vector2d& point_px) const {
    return {(point_px.x() - cx_px) / fx_px, (point_px.y() - cy_px) / fy_px, 1};
  }
};

}  // namespace stevedore
