#include "sim_proc/world/outline.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <numbers>

#include "geometry/rectify.hpp"
#include "sim_proc/world/ray.hpp"

namespace stevedore::world {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

/// The circle in camera axes: centre and two radii at right angles.
struct CameraCircle {
  Vector3d centre, across, along;  // metres; across and along have the circle's radius as length

  [[nodiscard]] Vector3d at(double angle_rad) const {
    return centre + std::cos(angle_rad) * across + std::sin(angle_rad) * along;
  }
  [[nodiscard]] double least_depth_m() const { return centre.z() - std::hypot(across.z(), along.z()); }
};

CameraCircle in_camera(const Rigid& eye, const Circle3& circle) {
  const Vector3d across = circle.normal_ned.unitOrthogonal(), along = circle.normal_ned.cross(across);
  const auto camera_from_ned = eye.ned_from_local.conjugate();
  return {eye.to_local(circle.center_ned_m), camera_from_ned * (circle.radius_m * across),
          camera_from_ned * (circle.radius_m * along)};
}

/// The conic of a circle's image: H^-T diag(1, 1, -1) H^-1 with H from the circle's plane to the image
/// (Hartley and Zisserman 2004, section 2.2.3).
std::optional<Ellipse> ideal_outline(const Pinhole& pinhole, const CameraCircle& circle) {
  Matrix3d image_from_plane;
  image_from_plane << circle.across, circle.along, circle.centre;
  const Matrix3d plane_from_image = (pinhole.matrix() * image_from_plane).inverse();
  return ellipse_from_conic(plane_from_image.transpose() * Vector3d(1, 1, -1).asDiagonal() *
                            plane_from_image);
}

/// Pixel of the image as given, where the lens takes the point into the image.
std::optional<Vector2d> pixel_of(const CameraModel& lens, const Vector3d& point_camera_m) {
  const Vector2d ideal_px = lens.rectified.project(point_camera_m), given_px = distort(lens, ideal_px);
  constexpr double pixel_edge = 0.5;  // (0, 0) is a pixel's centre
  const bool inside = given_px.x() >= -pixel_edge && given_px.x() < lens.given.width_px - pixel_edge &&
                      given_px.y() >= -pixel_edge && given_px.y() < lens.given.height_px - pixel_edge;
  if (!inside) return std::nullopt;
  if (lens.distortion != Distortion::none) {
    // far outside its image a lens polynomial folds back: such a point is not seen where it lands
    const auto back_px = undistort(lens, given_px);
    if (!back_px || (*back_px - ideal_px).norm() > 0.01) return std::nullopt;
  }
  return given_px;
}

bool is_hidden(const Scene& scene, const Vector3d& point_ned_m) {
  constexpr double own_surface_m = 0.003;  // what lies on the circle is at least a rope's 4 mm before it
  const Vector3d line = point_ned_m - scene.eye.rigid.position_ned_m;
  const double distance_m = line.norm();
  const auto hit = first_hit(scene, scene.eye.rigid.position_ned_m, line / distance_m);
  return hit && hit->range_m < distance_m - own_surface_m;
}

}  // namespace

std::optional<Outline> outline_of(const Scene& scene, const Circle3& circle) {
  const Rigid& eye = scene.eye.rigid;
  const CameraModel& lens = scene.eye.lens;
  const CameraCircle seen = in_camera(eye, circle);
  if (seen.least_depth_m() <= 0) return std::nullopt;
  constexpr int samples = 180;  // a share to 0.6 %
  int in_image = 0, visible = 0;
  for (int i = 0; i < samples; ++i) {
    const Vector3d point_camera_m = seen.at(2 * std::numbers::pi * i / samples);
    if (!pixel_of(lens, point_camera_m)) continue;
    ++in_image;
    if (!is_hidden(scene, eye.to_ned(point_camera_m))) ++visible;
  }
  if (in_image == 0) return std::nullopt;
  const auto ideal = ideal_outline(lens.rectified, seen);
  const auto given = ideal ? distort(lens, *ideal) : std::nullopt;
  if (!given) return std::nullopt;
  return Outline{*ideal, *given, static_cast<double>(visible) / samples};
}

}  // namespace stevedore::world
