// The world in flight: the same to the bit whoever looks, sensors at their rates, the eye's own motion, and
// the scripted pilot.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "sim_proc/world/pilot.hpp"
#include "sim_proc/world/world.hpp"

using namespace stevedore;
using namespace stevedore::world;

namespace {

WorldSettings settings_of(std::uint64_t seed, bool easy = false) {
  WorldSettings settings;
  settings.seed = seed;
  settings.easy = easy;
  settings.camera.given = settings.camera.rectified = {640, 480, 337, 337, 319.5, 239.5};
  return settings;
}

void run(World& world, double time_s) {
  for (int i = 0; i < std::lround(time_s / World::step_s); ++i) world.step();
}

/// Every number that a sensor said, in order.
void note(const Readings& readings, std::vector<double>& said) {
  const auto add = [&](const auto& vector) {
    said.insert(said.end(), vector.data(), vector.data() + vector.size());
  };
  if (const auto& v = readings.vehicle) {
    add(v->position_ned_m);
    add(v->velocity_ned_mps);
    add(v->ned_from_body.coeffs());
    add(v->angular_rate_body_radps);
  }
  if (const auto& g = readings.gimbal) said.insert(said.end(), {g->angles.roll_rad, g->angles.pitch_rad});
  if (const auto& a = readings.altimeter) said.push_back(a->range_m.value_or(-1));
  if (const auto& h = readings.hook) said.push_back(h->load_n);
  for (const PlatformReading& p : readings.platforms) add(p.position_ned_m);
  if (const auto& a = readings.autopilot) said.push_back(a->battery_v);
}

/// A minute under the scripted pilot; looked at between the steps or not, which must not matter.
std::vector<double> said_in_a_minute(std::uint64_t seed, bool looked_at) {
  World world(settings_of(seed));
  ScriptedPilot pilot;
  std::vector<double> said;
  for (int i = 0; i < 12000; ++i) {
    if (i % 20 == 0) world.command(pilot.fly(world.whereabouts()));
    note(world.step(), said);
    if (looked_at && i % 700 == 0) CHECK(world.truth().circles.size() == 9);
  }
  return said;
}

/// Of the camera over a circle of the platform that it is above.
double height_over_circle_m(const Truth& truth, int platform) {
  double height_m = 1e9;
  for (const CircleTruth& circle : truth.circles) {
    const Eigen::Vector3d down_m = circle.center_ned_m - truth.camera.position_ned_m;
    const bool above = circle.platform == platform && down_m.head<2>().norm() < 0.4;
    if (above) height_m = std::min(height_m, down_m.z());
  }
  return height_m;
}

}  // namespace

TEST_CASE("the same seed and commands: the same to the bit, whoever looks. Another seed: another world") {
  const std::vector<double> first = said_in_a_minute(11, false);
  CHECK(first.size() > 60 * (50 * 15 + 20 + 10));
  CHECK(first == said_in_a_minute(11, true));
  CHECK(first != said_in_a_minute(12, false));
}

TEST_CASE("sensors speak at their rates, platforms fall silent now and then") {
  World world(settings_of(3));
  std::array<int, 6> counts{};
  for (int i = 0; i < 20000; ++i) {
    const Readings& said = world.step();
    counts[0] += said.vehicle.has_value();
    counts[1] += said.gimbal.has_value();
    counts[2] += said.altimeter.has_value();
    counts[3] += said.hook.has_value();
    counts[4] += static_cast<int>(said.platforms.size());
    counts[5] += said.autopilot.has_value();
  }
  CHECK(counts[0] == 5000);
  CHECK(counts[1] == 5000);
  CHECK(counts[2] == 2000);
  CHECK(counts[3] == 1000);
  CHECK(counts[4] > 250);  // of two times 200
  CHECK(counts[4] < 400);
  CHECK(counts[5] == 200);
}

TEST_CASE("the eye moves as its velocities say, turns of body and pan-tilt together") {
  World world(settings_of(6));
  world.command({{1, 0.5, -1}, 0.3});
  run(world, 3);
  for (int i = 0; i < 100; ++i) {
    world.command_gimbal({0.2 * std::sin(0.02 * i), -0.1 * std::sin(0.03 * i)});
    const Rigid before = world.scene(0).eye.rigid;
    world.step();
    if (i < 20) continue;  // the servo has started
    const Rigid now = world.scene(0).eye.rigid;
    const Eigen::Vector3d moved_mps = (now.position_ned_m - before.position_ned_m) / World::step_s;
    CHECK((moved_mps - (before.velocity_ned_mps + now.velocity_ned_mps) / 2).norm() < 0.02);
    const Eigen::AngleAxisd turn(now.ned_from_local * before.ned_from_local.conjugate());
    const Eigen::Vector3d turned_radps = turn.angle() / World::step_s * turn.axis();
    const Eigen::Vector3d mean_radps =
        (before.angular_velocity_ned_radps + now.angular_velocity_ned_radps) / 2;
    CHECK((turned_radps - mean_radps).norm() < 0.03);  // of 1 rad/s
  }
}

TEST_CASE("circles are painted a little larger or smaller than told, exactly so in the easy world") {
  const World easy(settings_of(8, true)), hard(settings_of(8));
  const double told_m = hard.told_circle_radius_m();
  CHECK(easy.whereabouts().circles[0].radius_m == easy.told_circle_radius_m());
  CHECK(hard.whereabouts().circles[0].radius_m != told_m);
  CHECK(hard.whereabouts().circles[0].radius_m == Approx(told_m).epsilon(0.0101));
}

TEST_CASE("cargoes begin upright in circles of the first platform, one each, and other counts are refused") {
  for (int cargoes = 1; cargoes <= 4; ++cargoes) {
    WorldSettings settings = settings_of(static_cast<std::uint64_t>(cargoes));
    settings.cargoes = cargoes;
    const Truth truth = World(settings).whereabouts();
    CHECK(truth.cargoes.size() == static_cast<std::size_t>(cargoes));
    CHECK(std::count_if(truth.circles.begin(), truth.circles.end(), [](const CircleTruth& circle) {
            return circle.occupied && circle.platform == 0;
          }) == cargoes);
    for (const CargoTruth& cargo : truth.cargoes) {
      CHECK(cargo.slot >= 0);
      CHECK_FALSE(cargo.tipped);
    }
  }
  WorldSettings settings = settings_of(1);
  settings.cargoes = 5;
  CHECK_THROWS_AS(World(settings), std::invalid_argument);
  settings.cargoes = 2;
  settings.sea_state = 7;
  CHECK_THROWS_AS(World(settings), std::invalid_argument);
}

TEST_CASE("the scripted pilot searches at 12 m and comes down to 1 m over circles of both platforms") {
  for (std::uint64_t seed = 1; seed <= 4; ++seed) {
    World world(settings_of(seed));
    ScriptedPilot pilot;
    double highest_m = 0;
    std::array<double, 2> lowest_m{1e9, 1e9};
    for (int i = 0; i < 3000; ++i) {
      const Truth truth = world.whereabouts();
      const VelocityCommand command = pilot.fly(truth);
      REQUIRE(command.velocity_ned_mps.head<2>().norm() < 3.001);
      REQUIRE(command.velocity_ned_mps.z() < 1.001);
      world.command(command);
      run(world, 0.1);
      highest_m = std::max(highest_m, -truth.camera.position_ned_m.z());
      lowest_m[0] = std::min(lowest_m[0], height_over_circle_m(truth, 0));
      lowest_m[1] = std::min(lowest_m[1], height_over_circle_m(truth, 1));
    }
    INFO("seed " << seed);
    CHECK(highest_m == Approx(12).margin(0.6));
    for (const double lowest : lowest_m) {
      CHECK(lowest > 0.6);  // of 1 m: heave, and gusts
      CHECK(lowest < 1.1);
    }
  }
}
