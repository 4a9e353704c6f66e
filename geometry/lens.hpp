// A lens by itself: how it bends directions, both ways, with analytic derivatives.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "geometry/camera_model.hpp"
#include "geometry/ellipse.hpp"

namespace stevedore {

/// A point and how it follows a small step of what it was made from.
struct MappedPoint {
  Eigen::Vector2d point;
  Eigen::Matrix2d jacobian;  ///< d point / d the point it was made from
};

/// The ideal ray (x/z, y/z) as the lens bends it. Brown (1966) for plumb_bob, in the form of OpenCV's calib3d
/// page; Kannala and Brandt (2006) for equidistant, whose radius is an odd polynomial of the angle from the
/// optical axis.
MappedPoint distort_ray(const CameraModel& camera, const Eigen::Vector2d& ideal);

/// The way back: Newton's method with the derivative above. Nothing where the lens model has no inverse, for
/// plumb_bob beyond the radius at which its image folds back on itself.
std::optional<MappedPoint> undistort_ray(const CameraModel& camera, const Eigen::Vector2d& bent);

/// Pixel of the image as given, of a point in front of the camera.
struct ProjectedPoint {
  Eigen::Vector2d pixel_px;
  Eigen::Matrix<double, 2, 3> jacobian;  ///< d pixel / d point, px/m
};

/// Nothing for a point that is not in front (z <= 0).
std::optional<ProjectedPoint> project(const CameraModel& camera, const Eigen::Vector3d& point_camera_m);

/// Direction with z = 1 of a pixel's ray, and d (x, y) / d pixel. Nothing where the lens has no inverse.
std::optional<MappedPoint> unproject(const CameraModel& camera, const Eigen::Vector2d& given_px);

/// Points of the image as given, taken to the ideal image.
struct IdealPoints {
  Eigen::Matrix2Xd point_px;                    ///< of the rectified camera, a column a point
  Eigen::Array<bool, 1, Eigen::Dynamic> valid;  ///< false: the lens has no inverse there
};

/// The same as undistort() for every point, the steps of all points taken together.
IdealPoints undistort_points(const CameraModel& camera, const Eigen::Matrix2Xd& given_px);

}  // namespace stevedore
