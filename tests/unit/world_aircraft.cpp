// The aircraft's answers to commands, wind and ground, against closed forms.
#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "sim_proc/world/aircraft.hpp"

using namespace stevedore::world;

namespace {

constexpr double step_s = 0.005, deg = std::numbers::pi / 180;

Aircraft flying(const Air& air = {}) {
  Aircraft aircraft({0, 0}, 0, {}, step_s);
  aircraft.command({{0, 0, -1}, 0});
  for (int i = 0; i < 1000; ++i) aircraft.step(air, {});
  aircraft.command({});
  for (int i = 0; i < 2000; ++i) aircraft.step(air, {});
  return aircraft;
}

void fly(Aircraft& aircraft, const VelocityCommand& command, double time_s, const Air& air = {},
         const Floor& floor = {}) {
  aircraft.command(command);
  for (int i = 0; i < std::lround(time_s / step_s); ++i) aircraft.step(air, floor);
}

/// Step response of w^2 / (s^2 + 2 d w s + w^2).
double second_order(double t_s, double w, double d) {
  if (t_s < 0) return 0;
  const double wd = w * std::sqrt(1 - d * d);
  return 1 - std::exp(-d * w * t_s) * (std::cos(wd * t_s) + d * w / wd * std::sin(wd * t_s));
}

double tilt_rad(const Aircraft& aircraft) {
  return std::acos((aircraft.body().ned_from_local * Eigen::Vector3d::UnitZ()).z());
}

}  // namespace

TEST_CASE("velocity follows a step as a second-order system of 2.5 rad/s and damping 0.7, 0.1 s late") {
  for (const Eigen::Vector3d& direction :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, -1, 0), Eigen::Vector3d(0, 0, -1)}) {
    Aircraft aircraft = flying();
    aircraft.command({0.5 * direction, 0});
    for (int i = 1; i < 800; ++i) {
      aircraft.step({}, {});
      const double expected_mps = 0.5 * second_order(i * step_s - 0.1, 2.5, 0.7);
      REQUIRE(aircraft.body().velocity_ned_mps.dot(direction) == Approx(expected_mps).margin(0.006));
    }
  }
}

TEST_CASE("position is the integral of velocity, attitude turns at the angular velocity") {
  Aircraft aircraft = flying();
  aircraft.command({{2, -1, -0.5}, 0.6});
  for (int i = 0; i < 400; ++i) {
    const Rigid before = aircraft.body();
    aircraft.step({}, {});
    const Rigid& now = aircraft.body();
    REQUIRE((before.position_ned_m + step_s * now.velocity_ned_mps - now.position_ned_m).norm() < 1e-12);
    const Eigen::AngleAxisd turn(now.ned_from_local * before.ned_from_local.conjugate());
    REQUIRE((turn.angle() / step_s * turn.axis() - now.angular_velocity_ned_radps).norm() < 1e-4);
  }
  CHECK(aircraft.body().angular_velocity_ned_radps.z() == Approx(0.6).margin(0.02));
}

TEST_CASE("acceleration is limited to 3 m/s2, and the tilt is what it takes") {
  Aircraft aircraft = flying();
  aircraft.command({{5, 5, 0}, 0});
  double most_mps2 = 0, most_rad = 0;
  for (int i = 0; i < 600; ++i) {
    const Eigen::Vector3d before_mps = aircraft.body().velocity_ned_mps;
    aircraft.step({}, {});
    most_mps2 = std::max(most_mps2, (aircraft.body().velocity_ned_mps - before_mps).norm() / step_s);
    most_rad = std::max(most_rad, tilt_rad(aircraft));
  }
  CHECK(most_mps2 == Approx(3).epsilon(0.001));
  CHECK(most_rad > std::atan(3 / 9.81));
  CHECK(most_rad < std::atan((3 + 0.15 * 7) / 9.81));  // and the drag of its own speed
  CHECK(aircraft.body().velocity_ned_mps.x() == Approx(5).margin(0.1));
}

TEST_CASE("it leans into the mean wind to hover, and gusts push it") {
  Air air{{0, 5, 0}, {0, 0, 0}};
  Aircraft aircraft = flying(air);
  CHECK(tilt_rad(aircraft) == Approx(std::atan(0.15 * 5 / 9.81)).margin(0.01 * deg));
  const Eigen::Vector3d down_ned = aircraft.body().ned_from_local * Eigen::Vector3d::UnitZ();
  CHECK(down_ned.y() > 0);  // thrust against the wind: its up axis points west, whence the air comes
  CHECK(aircraft.body().velocity_ned_mps.norm() < 1e-6);
  air.gust_ned_mps = {1, 0, 0};
  fly(aircraft, {}, 10, air);
  CHECK(aircraft.body().velocity_ned_mps.x() == Approx(2 * 0.7 / 2.5 * 0.15).margin(1e-3));
}

TEST_CASE("it stands until told to climb, lands by itself, and a climb ends the landing") {
  Aircraft aircraft({3, -2}, 0.5, {}, step_s);
  fly(aircraft, {{1, 1, 0.5}, 0.4}, 3, {{5, 0, 0}, {1, 1, 1}});
  CHECK(aircraft.landed());
  CHECK((aircraft.body().position_ned_m - Eigen::Vector3d(3, -2, -Aircraft::skids_down_m)).norm() < 1e-12);
  CHECK(tilt_rad(aircraft) < 1e-9);

  fly(aircraft, {{0, 0, -1}, 0}, 6);
  CHECK_FALSE(aircraft.landed());
  CHECK(aircraft.body().position_ned_m.z() < -3);
  aircraft.land();
  fly(aircraft, {{1, 0, 0}, 0}, 4);  // no longer listened to
  CHECK(aircraft.body().velocity_ned_mps.x() == Approx(0).margin(1e-9));
  CHECK(aircraft.body().velocity_ned_mps.z() == Approx(Aircraft::landing_mps).margin(0.03));
  fly(aircraft, {{0, 0, -1}, 0}, 2);
  CHECK(aircraft.body().velocity_ned_mps.z() < -0.9);
  aircraft.land();
  fly(aircraft, {}, 15);
  CHECK(aircraft.landed());
  CHECK(aircraft.body().position_ned_m.z() == Approx(-Aircraft::skids_down_m));
  CHECK(aircraft.body().velocity_ned_mps.norm() == 0);
}

TEST_CASE("on a moving deck it rides along") {
  Floor floor;
  floor.decks.push_back({Rigid{}, {2, 2}});
  Rigid& deck = floor.decks[0].rigid;
  deck.position_ned_m.z() = -1;
  deck.velocity_ned_mps = {1, 0, 0};
  Aircraft aircraft({0.3, 0}, 0, {0, deck}, step_s);
  for (int i = 0; i < 1000; ++i) {
    deck.position_ned_m.x() += step_s;
    aircraft.step({}, floor);
  }
  CHECK(aircraft.landed());
  CHECK((aircraft.body().position_ned_m - Eigen::Vector3d(5.3, 0, -1 - Aircraft::skids_down_m)).norm() <
        1e-9);
}

TEST_CASE("the battery lasts 25 minutes of flight") {
  Aircraft aircraft = flying();
  const double before = aircraft.battery_share();
  fly(aircraft, {}, 150);
  CHECK(before - aircraft.battery_share() == Approx(0.1).epsilon(0.001));
}
