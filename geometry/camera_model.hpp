// A real camera: the lens and sensor that take the image as given, and the ideal pinhole the vision code
// works in.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "geometry/attitude.hpp"
#include "geometry/camera.hpp"

namespace stevedore {

/// Lens models, with the names ROS camera files use.
enum class Distortion {
  none,
  plumb_bob,    ///< Brown (1966): k1, k2, p1, p2, k3
  equidistant,  ///< Kannala and Brandt (2006): k1, k2, k3, k4
};

/// How a grey level follows from light.
struct Response {
  enum class Curve { linear, srgb, gamma };
  Curve curve = Curve::srgb;
  double gamma = 1;  ///< level = light^(1 / gamma); only for Curve::gamma
};

/// Light, 0..1, of each of the 256 grey levels.
std::array<float, 256> linear_light(const Response& response);

struct CameraModel {
  Pinhole given;      ///< intrinsics of the image as the camera gives it
  Pinhole rectified;  ///< the ideal camera that remains once the distortion is taken out
  Distortion distortion = Distortion::none;
  std::vector<double> coefficients;  ///< in the order named at Distortion; empty for none
  Response response;
  CameraMount mount;
};

}  // namespace stevedore
