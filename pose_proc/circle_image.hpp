// How a circle in space appears: the forward model that every fit in this room compares with measured edges.
#pragma once

#include <Eigen/Core>

#include "geometry/camera.hpp"
#include "geometry/detection.hpp"

namespace stevedore {

using Vector5d = Eigen::Matrix<double, 5, 1>;
using Matrix5d = Eigen::Matrix<double, 5, 5>;

/// An ellipse as its centre m and shape S, on the plane z = 1 in front of the camera: the points m + S^(1/2)
/// w with |w| = 1. As a vector (m_x, m_y, S_xx, S_xy, S_yy). Unlike (a, b, alpha) this is smooth where the
/// ellipse is a circle.
struct EdgeImage {
  Vector5d value;
  Matrix5d covariance;
};

/// A fitted ellipse in that form; first-order in its covariance.
EdgeImage edge_image(const EllipseFit& fit, const Pinhole& camera);

/// The image of a circle with its derivatives.
struct CircleImage {
  Vector5d value;
  Eigen::Matrix<double, 5, 3> by_center;  ///< 1/m
  Eigen::Matrix<double, 5, 3> by_normal;
  Vector5d by_radius;  ///< 1/m
};

/// A plane l through the camera touches the circle where (l.c)^2 = r^2 (l.l - (l.n)^2): the dual conic of the
/// image is c c^T - r^2 (I - n n^T) (Hartley and Zisserman 2004, 8.3 and 17), of which m and S are quotients.
CircleImage circle_image(const Eigen::Vector3d& center_camera_m, const Eigen::Vector3d& normal_camera,
                         double radius_m);

}  // namespace stevedore
