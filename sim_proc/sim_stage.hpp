// The world on the bus, in place of camera, aircraft, sensors and autopilot: GIMBAL_COMMAND and MISSION in;
// FRAME, VEHICLE_STATE, GIMBAL_STATE, ALTIMETER, HOOK_STATE, PLATFORM_STATE, AUTOPILOT_STATUS and TRUTH out.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "geometry/camera_model.hpp"
#include "runtime/bus.hpp"
#include "runtime/condition.hpp"
#include "runtime/frame_output.hpp"
#include "sim_proc/guided_pilot.hpp"
#include "sim_proc/render_thread.hpp"
#include "sim_proc/world/pilot.hpp"
#include "sim_proc/world/world.hpp"

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
  visit("sea_state", s.sea_state, 0.0, 4.0, "1",
        "raise: platforms heave, roll and pitch more; 0: not at all");
  visit("cargoes", s.cargoes, 1.0, 4.0, "1", "buckets on the first platform");
  visit("easy", s.easy, "clean, calm and exact: for a first look; no figure of merit may use it");
  visit("rate_hz", s.rate_hz, 1.0, 100.0, "Hz", "frames a second of the camera; raise: more work for all");
  visit("seconds", s.seconds, 0.0, 1e6, "s", "the world ends after this time; 0: it goes on");
  visit("truth", s.truth, "publish TRUTH with each frame, for evaluation; nothing that decides hears it");
  visit.choice(
      "pilot", s.pilot, {"scripted", "mission", "none"},
      "scripted: search, descents and transits without end; mission: flies to the set-points of MISSION; "
      "none: the aircraft stays where it is");
  visit("render_threads", s.render_threads, 1.0, 16.0, "threads",
        "threads that draw one frame; raise: frames come sooner, and keep more cores busy");
  describe(s.frames, visit);
}

class SimStage {
 public:
  /// told: the camera as the pipeline knows it. The world begins with the first work().
  SimStage(const SimSettings& settings, const CameraModel& told, std::string ring_name, Bus& bus);

  /// Brings the world up to now (us, CLOCK_MONOTONIC), publishes what fell due and a picture that is drawn.
  /// Never waits: a picture for which the one before is still being drawn is dropped and counted.
  Condition work(std::int64_t now_utime);

  /// Waits for the picture that is being drawn, and publishes it: for lock step, where no picture is dropped.
  Condition finish_drawing();

 private:
  void step();
  void fly();
  void expose();
  void send(const Picture& picture);
  void publish(const world::Readings& readings);
  [[nodiscard]] Condition condition() const;
  [[nodiscard]] bool has_ended() const;
  /// Of a time of the world.
  [[nodiscard]] std::int64_t utime_of(double time_s) const;

  const SimSettings settings_;
  Bus& bus_;
  world::World world_;
  world::ScriptedPilot scripted_;
  GuidedPilot guided_;
  bool lands_ = false;
  RenderThread renderer_;
  FrameOutput output_;
  std::optional<std::int64_t> start_utime_;  ///< of the world's time 0
  std::int64_t steps_ = 0;
  std::int64_t ticks_ = 0;              ///< of the camera; the next frame's number
  std::int64_t drops_ = 0;              ///< ticks without a frame
  std::optional<std::string> refusal_;  ///< of the newest frame
};

}  // namespace stevedore
