#include "tools/flight_film.hpp"

#include <algorithm>
#include <cmath>

#include "tools/still_truth.hpp"

namespace stevedore {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Eigen::Vector3d& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

Json json_of(const Eigen::Quaterniond& q) {
  return Json::array({q.w(), q.x(), q.y(), q.z()});
}

Json json_of(const world::Rigid& platform) {
  return {{"position_ned", json_of(platform.position_ned_m)},
          {"velocity_ned", json_of(platform.velocity_ned_mps)},
          {"ned_from_platform", json_of(platform.ned_from_local)},
          {"angular_velocity_ned", json_of(platform.angular_velocity_ned_radps)}};
}

/// Of the camera over the plane of the platform whose circles are nearest.
double height_over_nearest(const world::Truth& truth) {
  const world::CircleTruth* nearest = nullptr;
  const auto range = [&truth](const world::CircleTruth& circle) {
    return (circle.center_ned_m - truth.camera.position_ned_m).norm();
  };
  for (const auto& circle : truth.circles) {
    if (circle.platform < 2 && (!nearest || range(circle) < range(*nearest))) nearest = &circle;
  }
  return nearest->normal_ned.dot(truth.camera.position_ned_m - nearest->center_ned_m);
}

Still still_of(world::Scene scene, const world::Truth& truth, int sea_state) {
  Still still;
  still.scene = std::move(scene);
  still.sea_state = sea_state;
  still.height_m = height_over_nearest(truth);
  for (const auto& circle : truth.circles)
    still.circles.push_back(
        {circle.platform, circle.slot, circle.occupied, circle.center_ned_m, circle.normal_ned});
  still.circle_radius_m = truth.circles.front().radius_m;
  for (const world::Bucket& bucket : still.scene.buckets) {
    const auto cargo = std::find_if(truth.cargoes.begin(), truth.cargoes.end(),
                                    [&bucket](const auto& c) { return c.index == bucket.index; });
    still.cargoes.push_back({cargo->index, cargo->platform, cargo->slot});
  }
  return still;
}

Json json_of(const world::VehicleReading& reading) {
  return {{"time", reading.time_s},
          {"position_ned", json_of(reading.position_ned_m)},
          {"velocity_ned", json_of(reading.velocity_ned_mps)},
          {"ned_from_body", json_of(reading.ned_from_body)},
          {"angular_rate_body", json_of(reading.angular_rate_body_radps)},
          {"position_sigma", reading.position_sigma_m},
          {"velocity_sigma", reading.velocity_sigma_mps},
          {"attitude_sigma", reading.attitude_sigma_rad}};
}

Json json_of(const world::GimbalReading& reading) {
  return {{"time", reading.time_s}, {"roll", reading.angles.roll_rad}, {"pitch", reading.angles.pitch_rad}};
}

Json json_of(const world::AltimeterReading& reading) {
  return {{"time", reading.time_s},
          {"range", reading.range_m ? Json(*reading.range_m) : Json(nullptr)},
          {"sigma", reading.sigma_m}};
}

Json json_of(const world::HookReading& reading) {
  return {{"time", reading.time_s}, {"load", reading.load_n}, {"closed", reading.closed}};
}

template <class Reading>
Json json_of(const std::optional<Reading>& reading) {
  return reading ? json_of(*reading) : Json(nullptr);
}

}  // namespace

FlightFilm::FlightFilm(const world::WorldSettings& settings, double rate_hz, double start_s)
    : sea_state_(settings.sea_state),
      rate_hz_(rate_hz),
      start_s_(start_s),
      world_(settings),
      gimbal_(GimbalSettings{}, settings.camera.mount) {}

void FlightFilm::step() {
  const world::Readings& readings = world_.step();
  if (readings.altimeter) newest_.altimeter = readings.altimeter;
  if (readings.hook) newest_.hook = readings.hook;
  if (readings.gimbal) {
    newest_.gimbal = readings.gimbal;
    gimbal_.measured({readings.gimbal->time_s, readings.gimbal->angles, readings.gimbal->at_limit});
  }
  if (!readings.vehicle) return;
  newest_.vehicle = readings.vehicle;  // 50 Hz: the pace of gimbal and pilot too
  const auto& vehicle = *readings.vehicle;
  world_.command_gimbal(
      gimbal_.follow({vehicle.time_s, vehicle.ned_from_body, vehicle.angular_rate_body_radps}).command);
  world_.command(pilot_.fly(world_.whereabouts()));
}

FilmFrame FlightFilm::next() {
  constexpr double rounding_s = 1e-9;  // of the world's time
  const double due_s = start_s_ + static_cast<double>(frame_) / rate_hz_;
  do step();
  while (world_.time_s() < due_s - rounding_s);
  FilmFrame frame;
  frame.truth = world_.whereabouts();
  frame.still = still_of(world_.scene(frame_++), frame.truth, sea_state_);
  frame.time_s = world_.time_s();
  frame.stamp_s = world_.stamp_s();
  frame.vehicle = newest_.vehicle;
  frame.gimbal = newest_.gimbal;
  frame.altimeter = newest_.altimeter;
  frame.hook = newest_.hook;
  return frame;
}

Json truth_of(const FilmFrame& frame, const std::string& image, const std::string& camera_file) {
  Json line = truth_of(frame.still, image, camera_file);
  line["time"] = frame.time_s;
  line["stamp"] = frame.stamp_s;
  line["vehicle"] = json_of(frame.vehicle);
  line["gimbal"] = json_of(frame.gimbal);
  line["altimeter"] = json_of(frame.altimeter);
  line["hook"] = json_of(frame.hook);
  line["aircraft_ned"] = json_of(frame.truth.aircraft.position_ned_m);
  line["velocity_ned"] = json_of(frame.truth.aircraft.velocity_ned_mps);
  line["ned_from_body"] = json_of(frame.truth.aircraft.ned_from_local);
  line["camera_ned"] = json_of(frame.truth.camera.position_ned_m);
  line["ned_from_camera"] = json_of(frame.truth.camera.ned_from_local);
  line["hook_ned"] = json_of(frame.truth.hook_ned_m);
  line["platforms"] = Json::array();
  for (std::size_t i = 0; i < 2; ++i) line["platforms"].push_back(json_of(frame.still.scene.decks[i].rigid));
  return line;
}

}  // namespace stevedore
