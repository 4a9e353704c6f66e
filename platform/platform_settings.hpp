// What can be set about platforms: one struct for the room.
#pragma once

#include <string>
#include <vector>

namespace stevedore {

/// Where a painted circle is on the deck; deck axes: forward, right, down from the middle of the upper side.
struct SlotPlace {
  double forward_m = 0;
  double right_m = 0;
};

struct PlatformSettings {
  int count = 2;
  std::string layout = "learn";
  double spacing_m = 1.6;
  std::vector<SlotPlace> slots;

  double camera_forward_m = 0.8;
  double camera_right_m = 0;
  double camera_down_m = 0.25;
  double attitude_bias_deg = 0.7;  // autopilot and mount, half a degree each
  double scale_sigma = 0.006;      // half a per cent of the circles' radius, a third of the focal length
  double acceleration_sigma_mps2 = 0.3;  // 1.5 m/s gained or lost within five seconds
  double heave_sigma_m = 0.25;           // sea state 3
  double tilt_sigma_deg = 3;             // sea state 3
  double reported_heading_sigma_deg = 5;

  double safe_speed_mps = 0.3;  // a hook closes at less than this
  double safe_tilt_deg = 6;     // a bucket let down on its edge still falls back: its own limit is 40 degrees
  double safe_probability = 0.9;
};

template <class Visitor>
void describe(SlotPlace& s, Visitor& visit) {
  visit("forward_m", s.forward_m, -20.0, 20.0, "m", "centre of the circle, ahead of the deck's middle");
  visit("right_m", s.right_m, -20.0, 20.0, "m", "centre of the circle, to the right of the deck's middle");
}

template <class Visitor>
void describe(PlatformSettings& s, Visitor& visit) {
  visit("count", s.count, 1, 8, "platforms", "most that there can be; raise: false ones are possible");
  visit.choice("layout", s.layout, {"learn", "square", "row"},
               "how the circles lie; learn: a square or a row of four, which and how far apart is taken from "
               "the first good sight of all four");
  visit("spacing_m", s.spacing_m, 0.2, 20.0, "m",
        "between neighbouring circles of a square or a row; learn ignores it");
  visit.list("slots", s.slots, "the circles' places, in the order of their numbers; goes over layout");
  visit("camera_forward_m", s.camera_forward_m, -5.0, 5.0, "m",
        "the camera ahead of the point whose position VEHICLE_STATE tells");
  visit("camera_right_m", s.camera_right_m, -5.0, 5.0, "m", "the same, to the right");
  visit("camera_down_m", s.camera_down_m, -5.0, 5.0, "m", "the same, down");
  visit("attitude_bias_deg", s.attitude_bias_deg, 0.01, 10.0, "deg",
        "slow error of attitude and camera mount; raise: level decks correct it sooner, a lasting list of "
        "the deck is believed less");
  visit("scale_sigma", s.scale_sigma, 0.0, 0.1, "1",
        "relative error of all ranges together; raise: positions are said to be less certain");
  visit("acceleration_sigma_mps2", s.acceleration_sigma_mps2, 0.01, 5.0, "m/s2",
        "how hard platforms speed up and brake when they do; raise: follows sooner, velocity noisier");
  visit("heave_sigma_m", s.heave_sigma_m, 0.01, 5.0, "m",
        "rms of the heave; raise: follows sooner, vertical velocity noisier");
  visit("tilt_sigma_deg", s.tilt_sigma_deg, 0.1, 30.0, "deg", "rms of the deck's roll, and of its pitch");
  visit("reported_heading_sigma_deg", s.reported_heading_sigma_deg, 0.1, 90.0, "deg",
        "error of the heading in PLATFORM_STATE; raise: it settles slot numbers later");
  visit("safe_speed_mps", s.safe_speed_mps, 0.01, 5.0, "m/s",
        "vertical speed of the deck below which lowering is safe; raise: more and longer windows");
  visit("safe_tilt_deg", s.safe_tilt_deg, 0.1, 45.0, "deg",
        "tilt of the deck below which lowering is safe; raise: more and longer windows");
  visit("safe_probability", s.safe_probability, 0.5, 0.999, "1",
        "with which a window must hold; raise: fewer and shorter windows");
}

}  // namespace stevedore
