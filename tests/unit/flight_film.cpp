#include "tools/flight_film.hpp"

#include <catch2/catch.hpp>
#include <cmath>

using namespace stevedore;

namespace {

world::WorldSettings settings(std::uint64_t seed) {
  world::WorldSettings settings;
  settings.seed = seed;
  settings.camera.given = settings.camera.rectified = {160, 120, 84, 84, 79.5, 59.5};
  return settings;
}

nlohmann::ordered_json line_of(const FilmFrame& frame) {
  return truth_of(frame, "f.png", "camera.yaml");
}

}  // namespace

TEST_CASE("a film depends on its seed alone") {
  FlightFilm a(settings(3), 10, 0), b(settings(3), 10, 0), other(settings(4), 10, 0);
  nlohmann::ordered_json last_a, last_other;
  for (int i = 0; i < 30; ++i) {
    last_a = line_of(a.next());
    CHECK(last_a == line_of(b.next()));
    last_other = line_of(other.next());
  }
  CHECK(last_a != last_other);
}

TEST_CASE("a film begins where it is asked to, at its rate, and what was flown before is the same flight") {
  FlightFilm whole(settings(3), 5, 0), late(settings(3), 5, 2);
  FilmFrame frame;
  for (int i = 0; i <= 10; ++i) {
    frame = whole.next();
    CHECK(frame.time_s == Approx(0.2 * i).margin(world::World::step_s + 1e-9));
    CHECK(frame.time_s >= 0.2 * i - 1e-9);
  }
  const FilmFrame first = late.next();
  CHECK(first.time_s == Approx(2));
  CHECK(first.truth.camera.position_ned_m == frame.truth.camera.position_ned_m);
  CHECK(first.stamp_s != first.time_s);
  CHECK(std::abs(first.stamp_s - first.time_s) < 0.03);  // six times the 5 ms that are drawn
}

TEST_CASE("a film flies from the pad to over a platform, with the camera level and the readings at hand") {
  FlightFilm film(settings(3), 2, 0);
  double highest_m = 0;
  bool over_platform = false;
  for (int i = 0; i < 80; ++i) {
    const auto line = line_of(film.next());
    highest_m = std::max(highest_m, -line.at("aircraft_ned")[2].get<double>());
    for (const char* list : {"ellipses", "hidden"})  // from 12 m they are a few of these small pixels
      for (const auto& e : line.at(list)) over_platform = over_platform || e.at("platform") < 2;
    if (i < 4) continue;
    CHECK(line.at("gravity")[2] > std::cos(0.06));  // 3.4 deg: attitude, mount and lag together
    CHECK_FALSE(line.at("vehicle").is_null());
    CHECK_FALSE(line.at("gimbal").is_null());
    CHECK_FALSE(line.at("altimeter").is_null());
    CHECK_FALSE(line.at("hook").is_null());
  }
  CHECK(highest_m == Approx(12).margin(2));
  CHECK(over_platform);
}
