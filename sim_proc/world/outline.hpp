// Where a circle is in the image, exactly, and how much of it can be seen: the truth that detections are held
// against.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "geometry/ellipse.hpp"
#include "sim_proc/world/scene.hpp"

namespace stevedore::world {

struct Circle3 {
  Eigen::Vector3d center_ned_m;
  Eigen::Vector3d normal_ned;  ///< unit
  double radius_m = 0;
};

struct Outline {
  Ellipse ideal;  ///< in the undistorted image of lens.rectified: exact
  Ellipse given;  ///< in the image as given: exact without distortion, else the ellipse nearest to the bent
                  ///< outline
  double visible_share = 0;  ///< of its edge's points (equal steps of the circle's angle) that are in the
                             ///< image and hidden by nothing
};

/// Circle to image through eye.lens. Nothing if a part of it is behind the camera, or none of it is in the
/// image.
std::optional<Outline> outline_of(const Scene& scene, const Circle3& circle);

}  // namespace stevedore::world
