// A flight of the scripted pilot, frame by frame, in lock step: the sequences that `scenes --film` makes.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "gimbal_proc/gimbal.hpp"
#include "sim_proc/world/pilot.hpp"
#include "sim_proc/world/world.hpp"
#include "tools/stills.hpp"

namespace stevedore {

/// One frame of the flight: what is to see, and what the aircraft knew when it was taken.
struct FilmFrame {
  Still still;
  double time_s = 0;                             ///< of the world, at mid-exposure
  double stamp_s = 0;                            ///< as the camera's driver says
  world::Truth truth;                            ///< without outlines
  std::optional<world::VehicleReading> vehicle;  ///< newest readings; nothing: none yet
  std::optional<world::GimbalReading> gimbal;
  std::optional<world::AltimeterReading> altimeter;
  std::optional<world::HookReading> hook;
};

class FlightFilm {
 public:
  /// settings.camera is the told one. Frames before start_s are flown, not filmed.
  FlightFilm(const world::WorldSettings& settings, double rate_hz, double start_s);

  /// The next frame; its number counts from 0 at start_s. A tick falls on the step that reaches it.
  FilmFrame next();

 private:
  void step();

  const int sea_state_;
  const double rate_hz_, start_s_;
  world::World world_;
  world::ScriptedPilot pilot_;
  Gimbal gimbal_;
  world::Readings newest_;
  std::int64_t frame_ = 0;
};

/// A line of truth.jsonl: that of a still (tools/still_truth.hpp) and, besides, time and stamp (s), the
/// sensors' newest readings (vehicle, gimbal, altimeter, hook; null: none), and what is true of aircraft,
/// camera, hook and the two platforms (NED, m, m/s, rad/s; quaternions w, x, y, z). A circle keeps its
/// platform and slot from line to line: that is what identities are held against.
nlohmann::ordered_json truth_of(const FilmFrame& frame, const std::string& image,
                                const std::string& camera_file);

}  // namespace stevedore
