// What can be set about poses: one struct for the room.
#pragma once

#include <string>

namespace stevedore {

struct PoseSettings {
  std::string method = "conic";
  double circle_radius_m = 0.5;   // the paper's circle is one metre across
  double cargo_radius_m = 0.16;   // rim of a ten-litre bucket
  double attitude_sigma_deg = 1;  // autopilot, gimbal and mount together
  double deck_tilt_sigma_deg = 3;
  double turn_sigma_deg = 2;  // 60 deg/s at 30 frames/s
  double camera_tilt_sigma_deg = 10;
  double radius_sigma_percent = 0;
  double focal_sigma_percent = 0;
  double principal_point_sigma_px = 0;
  double altimeter_forward_m = 0;  // of the laser from the camera, along the body's axes
  double altimeter_right_m = 0;
  double altimeter_down_m = 0;
};

template <class Visitor>
void describe(PoseSettings& s, Visitor& visit) {
  visit.choice("method", s.method, {"conic", "four_point"},
               "conic: exact at any tilt; four_point: the paper's Algorithm 3, right only without tilt");
  visit("circle_radius_m", s.circle_radius_m, 0.01, 10.0, "m",
        "outer edge of a painted circle; raise: farther away");
  visit("cargo_radius_m", s.cargo_radius_m, 0.01, 10.0, "m", "rim of a cargo; raise: cargoes farther away");
  visit("attitude_sigma_deg", s.attitude_sigma_deg, 0.0, 45.0, "deg",
        "error of the gravity direction beyond its stated variance; raise: attitude decides less between two "
        "poses");
  visit("deck_tilt_sigma_deg", s.deck_tilt_sigma_deg, 0.1, 45.0, "deg",
        "how far decks lean from level; raise: attitude decides less between two poses");
  visit("turn_sigma_deg", s.turn_sigma_deg, 0.1, 45.0, "deg",
        "turn of a circle's normal between frames; raise: the previous pose decides less");
  visit("radius_sigma_percent", s.radius_sigma_percent, 0.0, 20.0, "%",
        "how well the painted radius is known, common to all circles; raise: larger covariances, which no "
        "averaging over frames should shrink");
  visit("focal_sigma_percent", s.focal_sigma_percent, 0.0, 20.0, "%",
        "how well the focal length is known; raise: the same");
  visit("principal_point_sigma_px", s.principal_point_sigma_px, 0.0, 100.0, "px",
        "how well the principal point is known; raise: the same");
  visit("altimeter_forward_m", s.altimeter_forward_m, -10.0, 10.0, "m",
        "place of the laser from the camera, forward on the aircraft; its range helps to choose between two "
        "poses");
  visit("altimeter_right_m", s.altimeter_right_m, -10.0, 10.0, "m", "the same, to the right");
  visit("altimeter_down_m", s.altimeter_down_m, -10.0, 10.0, "m", "the same, downwards");
  visit("camera_tilt_sigma_deg", s.camera_tilt_sigma_deg, 0.1, 45.0, "deg",
        "tilt of the camera when nothing else is known; raise: less sure of the pose that faces the image "
        "plane");
}

}  // namespace stevedore
