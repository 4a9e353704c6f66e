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
  visit("camera_tilt_sigma_deg", s.camera_tilt_sigma_deg, 0.1, 45.0, "deg",
        "tilt of the camera when nothing else is known; raise: less sure of the pose that faces the image "
        "plane");
}

}  // namespace stevedore
