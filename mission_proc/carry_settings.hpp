// What can be set about the carrying of cargoes.
#pragma once

namespace stevedore {

/// Heights are over the plane of the target's circle; the camera's where nothing else is said.
struct CarrySettings {
  bool start_at_once = false;
  int load_platform = 0;
  int drop_platform = 1;
  int cargoes = 4;

  // The aircraft, along its own axes from the point whose position VEHICLE_STATE tells.
  double camera_forward_m = 0.8;
  double camera_right_m = 0;
  double camera_down_m = 0.25;
  double hook_forward_m = 0;
  double hook_right_m = 0;
  double hook_down_m = 0.35;
  double rope_m = 0.8;
  double altimeter_forward_m = -0.5;
  double altimeter_right_m = 0;
  double altimeter_down_m = 0.25;
  // An aircraft leans into the wind until thrust balances drag; what hangs on a rope leans by its own drag
  // over its own weight. The paper's bucket has about the aircraft's ratio, a bare hook a fifth of it.
  double empty_lean = 0.2;
  double loaded_lean = 1.0;
  double lag_s = 0.48;  // 0.1 s on the way and 2 x 0.7 / 2.5 rad/s in the velocity loop, less by the
                        // autopilot's feedback of velocity

  // The cargo.
  double handle_over_rim_m = 0.12;
  double rim_over_deck_m = 0.30;
  double loaded_n = 7;  // half a bucket's weight over the empty hook's: 14 sigma of the load cell

  // Heights and gates.
  double take_off_height_m = 4;
  double search_height_m = 7;     // a deck of 4 m fills two thirds of the image
  double inspect_height_m = 3.5;  // a rim is 17 px large, and all four circles are in view
  double closer_height_m = 2;  // a rim is 27 px large: dark buckets on dark paint are told there if anywhere
  double transit_height_m = 5;
  double approach_height_m = 3;  // all four circles of a deck are in view, and the rim is 18 px large
  double land_height_m = 1.5;    // the pad's circle is still whole in view; straight down from there
  double clearance_m = 0.35;  // of the hook over the handle, of the cargo over the deck, before the last step
  double aligned_m = 0.15;
  double aligned_s = 1.0;  // half a period of the hook's swing
  double grab_m = 0.045;   // the hook holds well within 0.06 m: the rest is for what is not known
  double release_m =
      0.10;  // twice what the swing is known to: one that is lifted again swings as nobody knows
  double oldest_s =
      1.0;  // a deck that was not seen for so long is 0.05 m/s x 1 s off, a good half of the gate
  double blind_s = 2.5;
  double battery_floor = 0.2;
  double fence_m = 120;  // from the take-off point
  int attempts_per_slot = 4;
  double hold_try_s = 15;  // eight swings of a cargo on its rope: a poor hold has given way by then
};

template <class Visitor>
void describe(CarrySettings& s, Visitor& visit) {
  visit("start_at_once", s.start_at_once, "begin without waiting for the operator's word");
  visit("load_platform", s.load_platform, 0.0, 100.0, "1", "number of the platform to take cargoes from");
  visit("drop_platform", s.drop_platform, 0.0, 100.0, "1", "number of the platform to bring them to");
  visit("cargoes", s.cargoes, 1.0, 100.0, "1", "how many to carry");
  visit("camera_forward_m", s.camera_forward_m, -5.0, 5.0, "m",
        "the camera ahead of the point whose position VEHICLE_STATE tells");
  visit("camera_right_m", s.camera_right_m, -5.0, 5.0, "m", "the same, to the right");
  visit("camera_down_m", s.camera_down_m, -5.0, 5.0, "m", "the same, down");
  visit("hook_forward_m", s.hook_forward_m, -5.0, 5.0, "m", "where the rope begins, ahead of that point");
  visit("hook_right_m", s.hook_right_m, -5.0, 5.0, "m", "the same, to the right");
  visit("hook_down_m", s.hook_down_m, -5.0, 5.0, "m", "the same, down");
  visit("rope_m", s.rope_m, 0.0, 20.0, "m", "from there to the hook");
  visit("altimeter_forward_m", s.altimeter_forward_m, -5.0, 5.0, "m", "the laser ahead of that point");
  visit("altimeter_right_m", s.altimeter_right_m, -5.0, 5.0, "m", "the same, to the right");
  visit("altimeter_down_m", s.altimeter_down_m, -5.0, 5.0, "m", "the same, down");
  visit("empty_lean", s.empty_lean, 0.0, 3.0, "1",
        "how far the empty hook leans in the wind, of the aircraft's own lean; raise: aims further to "
        "windward");
  visit("loaded_lean", s.loaded_lean, 0.0, 3.0, "1", "the same with a cargo");
  visit("lag_s", s.lag_s, 0.0, 3.0, "s",
        "how late the aircraft follows a commanded velocity; raise: leads a moving deck by more");
  visit("handle_over_rim_m", s.handle_over_rim_m, 0.0, 2.0, "m", "top of a cargo's handle over its rim");
  visit("rim_over_deck_m", s.rim_over_deck_m, 0.0, 2.0, "m", "height of a cargo's rim");
  visit("loaded_n", s.loaded_n, 0.1, 1000.0, "N",
        "load over the empty hook's from which a cargo hangs on it");
  visit("take_off_height_m", s.take_off_height_m, 0.5, 50.0, "m", "height at which the search begins");
  visit("search_height_m", s.search_height_m, 1.0, 50.0, "m", "height over a platform that is looked for");
  visit("inspect_height_m", s.inspect_height_m, 1.0, 50.0, "m",
        "height over a platform that was found, at which it is seen where cargoes stand");
  visit("closer_height_m", s.closer_height_m, 1.0, 50.0, "m",
        "height over each circle at which it is looked at once more when there is nothing to choose");
  visit("transit_height_m", s.transit_height_m, 1.0, 50.0, "m", "height on the way to the other platform");
  visit("approach_height_m", s.approach_height_m, 1.0, 50.0, "m",
        "height over the target at which it is aligned, and to which a failed step goes back: the clear "
        "height");
  visit("land_height_m", s.land_height_m, 0.5, 10.0, "m",
        "height over the take-off pad from which the autopilot lands by itself");
  visit("clearance_m", s.clearance_m, 0.05, 5.0, "m",
        "of the hook over the handle, or of the cargo over the deck, at which the last step begins");
  visit("aligned_m", s.aligned_m, 0.01, 2.0, "m",
        "horizontal error within which the target counts as aligned");
  visit("aligned_s", s.aligned_s, 0.0, 30.0, "s", "how long that must hold; raise: slower, steadier");
  visit("grab_m", s.grab_m, 0.005, 1.0, "m",
        "error within which the jaws are told to close; raise: sooner, worse held");
  visit("release_m", s.release_m, 0.01, 1.0, "m", "horizontal error within which a cargo is let go");
  visit("oldest_s", s.oldest_s, 0.05, 30.0, "s",
        "age of the platform's last sight beyond which nothing is grabbed, released or lowered");
  visit("blind_s", s.blind_s, 0.1, 30.0, "s", "the same, beyond which a step is given up");
  visit("battery_floor", s.battery_floor, 0.0, 1.0, "1", "share of the battery at which the mission ends");
  visit("fence_m", s.fence_m, 1.0, 1e5, "m", "distance from the take-off point at which the mission ends");
  visit("attempts_per_slot", s.attempts_per_slot, 1.0, 100.0, "1",
        "failures with one cargo, or one circle, after which it is left alone");
  visit("hold_try_s", s.hold_try_s, 0.0, 120.0, "s",
        "how long a cargo is held just over its circle before it is taken away, so that one that slips off "
        "falls "
        "onto its base; raise: slower, fewer lost");
}

}  // namespace stevedore
