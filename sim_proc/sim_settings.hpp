// What can be set about the world on the bus: one struct for the room.
#pragma once

#include <cstdint>
#include <string>

#include "runtime/frame_output.hpp"

namespace stevedore {

struct SimSettings {
  std::int64_t seed = 1;
  int sea_state = 2;
  int cargoes = 4;
  bool easy = false;
  double rate_hz = 15;
  double seconds = 0;
  bool truth = true;
  std::string pilot = "scripted";
  int render_threads = 2;
  FrameTransport frames;
};

template <class Visitor>
void describe(SimSettings& s, Visitor& visit) {
  visit("seed", s.seed, 0.0, 4294967295.0, "1", "everything is drawn from it: layout, light, motion, errors");
  visit("sea_state", s.sea_state, 0.0, 4.0, "1", "raise: platforms heave, roll and pitch more; 0: not at all");
  visit("cargoes", s.cargoes, 1.0, 4.0, "1", "buckets on the first platform");
  visit("easy", s.easy, "clean, calm and exact: for a first look; no figure of merit may use it");
  visit("rate_hz", s.rate_hz, 1.0, 100.0, "Hz", "frames a second of the camera; raise: more work for all");
  visit("seconds", s.seconds, 0.0, 1e6, "s", "the world ends after this time; 0: it goes on");
  visit("truth", s.truth, "publish TRUTH with each frame, for evaluation; nothing that decides hears it");
  visit.choice("pilot", s.pilot, {"scripted", "none"},
               "scripted: search, descents and transits without end; none: the aircraft stays where it is");
  visit("render_threads", s.render_threads, 1.0, 16.0, "threads",
        "threads that draw one frame; raise: frames come sooner, and keep more cores busy");
  describe(s.frames, visit);
}

}  // namespace stevedore
