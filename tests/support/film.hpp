// A small film for tests: a platform with four painted rings under a camera that moves, with exact truth.
// (The world to fly in is sim_proc's; this one only moves circles.)
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "geometry/camera.hpp"
#include "geometry/ellipse.hpp"

namespace stevedore {

/// Rings of 0.5 m radius (outer edge) on a level platform, one at each corner of a square of 1.6 m.
inline constexpr double film_circle_radius_m = 0.5;

struct FilmFrame {
  cv::Mat image;                     ///< bgr8
  std::vector<Ellipse> outer_edges;  ///< of the four rings, exact
};

/// 640x480, 87 x 71 degrees: config/cameras/paper_640x480.yaml.
Pinhole film_camera();

/// Frame k at 30 frames/s: the camera circles over the platform between 3 and 4 m, tilted by up to 6 degrees.
FilmFrame film_frame(int k);

}  // namespace stevedore
