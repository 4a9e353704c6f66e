// The pan-tilt against the closed forms of its servo.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "sim_proc/world/gimbal.hpp"

using namespace stevedore;
using std::numbers::pi;
using world::Gimbal;

namespace {

constexpr double step_s = 0.005, deg = pi / 180;

}  // namespace

TEST_CASE("small commands are followed as by a second-order servo of 15 Hz, exactly") {
  Gimbal gimbal(step_s);
  gimbal.command({0.01, -0.02});
  const double w = 2 * pi * 15, d = 0.7, wd = w * std::sqrt(1 - d * d);
  for (int i = 1; i < 60; ++i) {
    gimbal.step();
    const double t_s = i * step_s;
    const double response =
        1 - std::exp(-d * w * t_s) * (std::cos(wd * t_s) + d * w / wd * std::sin(wd * t_s));
    CHECK(gimbal.angles().roll_rad == Approx(0.01 * response).margin(1e-12));
    CHECK(gimbal.angles().pitch_rad == Approx(-0.02 * response).margin(1e-12));
    const double rate = 0.01 * w * w / wd * std::exp(-d * w * t_s) * std::sin(wd * t_s);
    CHECK(gimbal.rates_radps().roll_rad == Approx(rate).margin(1e-12));
  }
}

TEST_CASE("at 15 Hz a swing passes at 1 / (2 damping)") {
  constexpr double fine_s = 0.0002;
  Gimbal gimbal(fine_s);
  double most_rad = 0;
  for (int i = 0; i < 10000; ++i) {
    gimbal.command({0.005 * std::sin(2 * pi * 15 * i * fine_s), 0});
    gimbal.step();
    if (i > 5000) most_rad = std::max(most_rad, std::abs(gimbal.angles().roll_rad));
  }
  CHECK(most_rad / 0.005 == Approx(1 / 1.4).epsilon(0.01));  // -2.9 dB
}

TEST_CASE("a large command is followed at 120 deg/s and stops at 30 deg") {
  Gimbal gimbal(step_s);
  gimbal.command({50 * deg, -1});
  double before_rad = 0, fastest_radps = 0;
  for (int i = 0; i < 200; ++i) {
    gimbal.step();
    fastest_radps = std::max(fastest_radps, std::abs(gimbal.angles().roll_rad - before_rad) / step_s);
    before_rad = gimbal.angles().roll_rad;
    if (i == 39) CHECK(before_rad == Approx(120 * deg * 0.2).margin(2.5 * deg));  // less the start
  }
  CHECK(fastest_radps <= 120 * deg + 1e-9);
  CHECK(fastest_radps > 119 * deg);
  CHECK(gimbal.angles().roll_rad == Approx(30 * deg).margin(1e-6));
  CHECK(gimbal.angles().pitch_rad == Approx(-30 * deg).margin(1e-6));
  CHECK(gimbal.at_limit());
  gimbal.command({0, 0});
  for (int i = 0; i < 200; ++i) gimbal.step();
  CHECK_FALSE(gimbal.at_limit());
  CHECK(gimbal.angles().roll_rad == Approx(0).margin(1e-6));
}
