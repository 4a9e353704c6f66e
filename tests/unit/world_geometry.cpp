// The world as a whole against cases that a pencil solves: when things are stamped, where they sit on the
// aircraft, and where the pan-tilt makes the camera look.
#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "sim_proc/world/gravity.hpp"
#include "sim_proc/world/told_and_true.hpp"
#include "sim_proc/world/world.hpp"

using namespace stevedore;
using namespace stevedore::world;
using Eigen::Vector3d;

namespace {

constexpr double deg = std::numbers::pi / 180;

CameraModel told_camera() {
  CameraModel camera;
  camera.given = camera.rectified = {640, 480, 337, 337, 319.5, 239.5};
  return camera;
}

WorldSettings settings_of(std::uint64_t seed, bool easy) {
  WorldSettings settings;
  settings.seed = seed;
  settings.easy = easy;
  settings.camera = told_camera();
  return settings;
}

/// The newest of everything said in the time.
Readings run(World& world, double time_s, const VelocityCommand& command) {
  Readings newest;
  for (int i = 0; i < std::lround(time_s / World::step_s); ++i) {
    world.command(command);
    const Readings& readings = world.step();
    if (readings.vehicle) newest.vehicle = readings.vehicle;
    if (readings.gimbal) newest.gimbal = readings.gimbal;
    if (readings.altimeter) newest.altimeter = readings.altimeter;
  }
  return newest;
}

/// Calm and exact, level over the middle of the pad at about 3 m.
void hover(World& world) {
  run(world, 4, {{0, 0, -1}, 0});
  run(world, 8, {{0, 0, 0}, 0});
}

double heading_rad(const Rigid& body) {
  const Vector3d ahead = body.ned_from_local * Vector3d::UnitX();
  return std::atan2(ahead.y(), ahead.x());
}

/// Forward, right, down of a level aircraft to north, east, down.
Vector3d turned(double heading, const Vector3d& level) {
  return {std::cos(heading) * level.x() - std::sin(heading) * level.y(),
          std::sin(heading) * level.x() + std::cos(heading) * level.y(), level.z()};
}

}  // namespace

TEST_CASE("readings carry the time of their step, pictures a stamp that is late by the seed's constant") {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const double late_s = draw_true_self(seed, {}, told_camera(), {}).stamp_late_s;
    CHECK(std::abs(late_s) <= 0.01);  // twice the 5 ms
    CHECK(late_s != 0);
    World world(settings_of(seed, false)), exact(settings_of(seed, true));
    for (int i = 1; i <= 200; ++i) {
      const Readings& readings = world.step();
      exact.step();
      const double now_s = i * 0.005;
      CHECK(world.time_s() == Approx(now_s));
      CHECK(world.stamp_s() - world.time_s() == Approx(late_s).margin(1e-12));
      CHECK(exact.stamp_s() == exact.time_s());
      CHECK(readings.vehicle.has_value() == (i % 4 == 0));
      CHECK(readings.altimeter.has_value() == (i % 10 == 0));
      if (readings.vehicle) CHECK(readings.vehicle->time_s == Approx(now_s));
      if (readings.gimbal) CHECK(readings.gimbal->time_s == Approx(now_s));
      if (readings.altimeter) CHECK(readings.altimeter->time_s == Approx(now_s));
      if (readings.hook) CHECK(readings.hook->time_s == Approx(now_s));
    }
  }
}

TEST_CASE("camera and rope sit where the lever arms of the seed put them, turned with the heading") {
  for (const bool easy : {true, false}) {
    World world(settings_of(2, easy));
    world.step();
    const LeverArms arms = easy ? LeverArms{} : draw_true_self(2, {}, told_camera(), {}).arms;
    const Truth truth = world.whereabouts();  // it stands on the pad, level
    const double heading = heading_rad(truth.aircraft);
    const Vector3d at_m = truth.aircraft.position_ned_m;
    CHECK((truth.camera.position_ned_m - at_m - turned(heading, arms.camera_body_m)).norm() < 1e-9);
    CHECK((truth.camera.position_ned_m - at_m).head<2>().norm() == Approx(0.8).margin(0.05));
    // the rope's first point is its anchor
    CHECK(
        (world.scene(0).strands.end()[-2].points_ned_m[0] - at_m - turned(heading, arms.hook_body_m)).norm() <
        1e-9);
    CHECK(world.told_lever_arms().camera_body_m == Vector3d(0.8, 0, 0.25));  // it is told so, whatever is
  }
}

TEST_CASE("turning on the spot moves the camera sideways at its lever arm times the rate") {
  World world(settings_of(1, true));
  hover(world);
  run(world, 3, {{0, 0, 0}, 0.5});
  const Rigid eye = world.scene(0).eye.rigid;
  const double heading = heading_rad(world.whereabouts().aircraft);
  CHECK((eye.velocity_ned_mps - turned(heading, {0, 0.8 * 0.5, 0})).norm() < 1e-3);
  CHECK((eye.angular_velocity_ned_radps - Vector3d(0, 0, 0.5)).norm() < 1e-3);
}

TEST_CASE("the pan-tilt's angles turn the optical axis as its two joints do, roll outside of pitch") {
  World world(settings_of(1, true));
  hover(world);
  for (const GimbalAngles angles :
       {GimbalAngles{0, 0}, {20 * deg, 0}, {0, 20 * deg}, {-25 * deg, 10 * deg}, {15 * deg, -28 * deg}}) {
    world.command_gimbal(angles);
    const Readings newest = run(world, 1, {{0, 0, 0}, 0});
    const double roll = angles.roll_rad, pitch = angles.pitch_rad;
    REQUIRE(newest.gimbal);
    CHECK(newest.gimbal->angles.roll_rad == Approx(roll).margin(1e-6));
    CHECK(newest.gimbal->angles.pitch_rad == Approx(pitch).margin(1e-6));
    const Truth truth = world.whereabouts();
    const Vector3d axis(std::sin(pitch), -std::sin(roll) * std::cos(pitch), std::cos(roll) * std::cos(pitch));
    const Vector3d looks = truth.camera.ned_from_local * Vector3d::UnitZ();
    CHECK((looks - turned(heading_rad(truth.aircraft), axis)).norm() < 1e-4);
    CHECK(truth.off_level_rad == Approx(std::acos(std::cos(roll) * std::cos(pitch))).margin(1e-4));
  }
}

TEST_CASE("from a hover the pad's circle is where a pinhole and the lever arm put it") {
  World world(settings_of(1, true));
  hover(world);
  run(world, 2, {{0.2, -0.1, 0}, 0});
  run(world, 8, {{0, 0, 0}, 0});
  const Truth truth = world.truth();
  const auto& pad = truth.circles.back();
  REQUIRE(pad.platform == 2);
  REQUIRE(pad.outline);
  const Vector3d to_pad_m =
      turned(-heading_rad(truth.aircraft), pad.center_ned_m - truth.aircraft.position_ned_m) -
      Vector3d(0.8, 0, 0.25);  // from the camera: forward, right, down
  const double depth_m = to_pad_m.z();
  CHECK(depth_m > 2);
  CHECK(pad.outline->u_px == Approx(319.5 + 337 * to_pad_m.y() / depth_m).margin(0.01));
  CHECK(pad.outline->v_px == Approx(239.5 - 337 * to_pad_m.x() / depth_m).margin(0.01));
  CHECK(pad.outline->a_px == Approx(337 * 0.5 / depth_m).margin(0.01));
  CHECK(pad.outline->b_px == Approx(337 * 0.5 / depth_m).margin(0.01));
}

TEST_CASE(
    "the laser measures from its own place, longer by the lean when the aircraft leans against the air") {
  World world(settings_of(1, true));
  hover(world);
  const Truth above_pad = world.whereabouts();
  const Readings still = run(world, 0.1, {{0, 0, 0}, 0});
  REQUIRE(still.altimeter);
  REQUIRE(still.altimeter->range_m);
  const double pad_z_m = above_pad.circles.back().center_ned_m.z();
  CHECK(*still.altimeter->range_m ==
        Approx(pad_z_m - above_pad.aircraft.position_ned_m.z() - 0.25).margin(1e-3));

  run(world, 1, {{0, 0, -1}, 0});
  const Readings flying = run(world, 10, {{-1.5, 0, 0}, 0});  // away from the pad, drag and lean settled
  const Rigid body = world.whereabouts().aircraft;
  const double lean_rad = std::atan(0.15 * 1.5 / gravity_mps2);  // drag of 0.15 / s
  CHECK(std::acos((body.ned_from_local * Vector3d::UnitZ()).z()) == Approx(lean_rad).epsilon(0.01));
  const double height_m = -(body.to_ned({-0.5, 0, 0.25})).z();
  REQUIRE(flying.altimeter);
  REQUIRE(flying.altimeter->range_m);
  CHECK(*flying.altimeter->range_m == Approx(height_m / std::cos(lean_rad)).margin(1e-3));
}
