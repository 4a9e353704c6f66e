// Rope, jaws, and what hangs on them: periods, tensions, and the gate at its edges.
#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim_proc/world/sling.hpp"

using namespace stevedore::world;

namespace {

constexpr Load bucket{0.8, 0.15};
constexpr double step_s = 0.005, pi = std::numbers::pi;
const Eigen::Vector3d calm = Eigen::Vector3d::Zero();

/// Whether the jaws close at this miss, held for so long.
bool closes(const HookMiss& miss, double time_s = 0.3) {
  Grip grip;
  for (int i = 0; i < std::lround(time_s / step_s); ++i) {
    if (grip.step(0, miss, step_s)) return true;
  }
  return false;
}

/// A bucket at the middle of a deck, and a hook that hangs so far from its handle.
struct Scene1 {
  Floor floor;
  std::vector<Cargo> cargoes;
  Eigen::Vector3d anchor_m;
  Sling sling;

  explicit Scene1(const Eigen::Vector3d& miss_m = {0, 0, 0}, std::uint64_t seed = 1)
      : floor{{{Rigid{}, {2, 2}}}, false},
        cargoes{Cargo(Bucket{}, 0, {0, 0}, 0, floor)},
        anchor_m(cargoes[0].handle_apex_ned_m() + miss_m - Eigen::Vector3d(0, 0, 0.8)),
        sling(seed, anchor_m, 0.8) {}

  void run(double time_s, const Eigen::Vector3d& anchor_velocity_mps = {0, 0, 0}) {
    for (int i = 0; i < std::lround(time_s / step_s); ++i) {
      anchor_m += anchor_velocity_mps * step_s;
      sling.step(anchor_m, calm, floor, cargoes, step_s);
      for (Cargo& cargo : cargoes) cargo.step(floor, step_s);
    }
  }
};

}  // namespace

TEST_CASE("a rope of 0.8 m swings with the period of a pendulum and calms down slowly") {
  Rope rope({0, 0, -3}, bucket);
  rope.carry({0.8 * std::sin(0.1), 0, -3 + 0.8 * std::cos(0.1)}, calm, bucket);
  double before_m = 1, last_s = 0, most_m = 0;
  std::vector<double> periods_s;
  for (int i = 1; i < 4000; ++i) {
    rope.step({0, 0, -3}, calm, step_s);
    const double x_m = rope.weight_ned_m().x();
    if (before_m < 0 && x_m >= 0) {
      const double now_s = (i - x_m / (x_m - before_m)) * step_s;
      if (last_s > 0) periods_s.push_back(now_s - last_s);
      last_s = now_s;
    }
    before_m = x_m;
    if (i > 3600) most_m = std::max(most_m, std::abs(x_m));
    CHECK((rope.weight_ned_m() - Eigen::Vector3d(0, 0, -3)).norm() == Approx(0.8));
  }
  const double period_s = 2 * pi * std::sqrt(0.8 / 9.81);
  REQUIRE(periods_s.size() > 8);
  for (const double each_s : periods_s) CHECK(each_s == Approx(period_s).epsilon(0.01));
  CHECK(most_m < 0.04);
  CHECK(most_m > 0.004);
}

TEST_CASE("the rope pulls with weight, with more when lifted, with nothing when slack, and wind leans it") {
  Rope rope({0, 0, -3}, bucket);
  for (int i = 0; i < 200; ++i) rope.step({0, 0, -3}, calm, step_s);
  CHECK(rope.pull_mps2() == Approx(9.81));
  double down_m = -3, speed_mps = 0;
  for (int i = 0; i < 100; ++i) {
    speed_mps += 2 * step_s, down_m -= speed_mps * step_s;
    rope.step({0, 0, down_m}, calm, step_s);
  }
  CHECK(rope.pull_mps2() == Approx(9.81 + 2 + 0.15).epsilon(0.002));
  rope.step(rope.weight_ned_m() + Eigen::Vector3d(0, 0, -0.5), calm, step_s);
  CHECK(rope.pull_mps2() == 0);
  Rope windy({0, 0, -3}, bucket);
  for (int i = 0; i < 20000; ++i) windy.step({0, 0, -3}, {5, 0, 0}, step_s);
  CHECK(windy.weight_ned_m().x() / 0.8 == Approx(std::sin(std::atan(0.15 * 5 / 9.81))).epsilon(0.01));
}

TEST_CASE("the jaws close within the gate, at its very edges and no further") {
  CHECK(closes({0, 0, 0}));
  CHECK(closes({0.0799, 0, 0}));
  CHECK_FALSE(closes({0.0801, 0, 0}));
  CHECK(closes({0, 0.0599, 0}));
  CHECK_FALSE(closes({0, 0.0601, 0}));
  CHECK(closes({0, -0.0599, 0}));
  CHECK_FALSE(closes({0, -0.0601, 0}));
  CHECK(closes({0, 0, 0.299}));
  CHECK_FALSE(closes({0, 0, 0.301}));
  CHECK(closes({0.079, 0.059, 0.29}));
  CHECK_FALSE(closes({0, 0, 0}, 0.295));
}

TEST_CASE("the gate must hold on end and for one handle, and the instant that it closes in counts") {
  Grip grip;
  const HookMiss good{0.02, 0, 0}, bad{0.2, 0, 0}, poor{0.072, 0, 0};
  for (int i = 0; i < 59; ++i) CHECK_FALSE(grip.step(0, good, step_s));
  CHECK_FALSE(grip.step(0, bad, step_s));
  for (int i = 0; i < 59; ++i) CHECK_FALSE(grip.step(0, i == 30 ? poor : good, step_s));
  CHECK(grip.step(0, poor, step_s) == Approx(0.9));
  for (int i = 0; i < 59; ++i) CHECK_FALSE(grip.step(1, good, step_s));
  CHECK_FALSE(grip.step(2, good, step_s));
  CHECK(Grip::chance_to_slip(0.79) == 0);
  CHECK(Grip::chance_to_slip(0.9) == Approx(0.25));
  CHECK(Grip::chance_to_slip(1) == Approx(0.5));
}

TEST_CASE("told to close at a handle it takes the bucket, lifts it, carries its weight, and lets it go") {
  Scene1 scene({0.03, -0.02, 0.03});
  scene.run(2);
  CHECK_FALSE(scene.sling.closed());
  scene.sling.command(true);
  scene.run(0.29);
  CHECK_FALSE(scene.sling.closed());
  scene.run(0.02);
  CHECK(scene.sling.closed());
  CHECK(scene.sling.carried() == 0);
  CHECK(scene.sling.load_n() == 0);  // still standing
  CHECK(scene.cargoes[0].deck() == 0);
  scene.run(6, {0, 0, -0.5});
  CHECK(scene.cargoes[0].state() == Cargo::State::hanging);
  CHECK(scene.cargoes[0].deck() == -1);
  CHECK(scene.sling.load_n() == Approx(1.5 * 9.81).epsilon(0.02));
  // 0.8 m of rope, 0.12 m of handle, 0.30 m of bucket
  const double hangs_m = scene.cargoes[0].bucket().rigid.position_ned_m.z() - scene.anchor_m.z();
  CHECK(hangs_m == Approx(1.22).epsilon(0.002));
  scene.run(20);  // calms down
  scene.run(5, {0, 0, 0.5});
  scene.run(2, {0, 0, 0.3});
  CHECK(scene.cargoes[0].state() == Cargo::State::standing);
  CHECK(scene.sling.load_n() == 0);  // the deck has it
  CHECK(scene.sling.closed());
  CHECK(scene.sling.carried() == 0);
  scene.sling.command(false);
  scene.run(0.5, {0, 0, -0.5});
  CHECK_FALSE(scene.sling.closed());
  CHECK(scene.cargoes[0].state() == Cargo::State::standing);
  CHECK(scene.cargoes[0].bucket().rigid.position_ned_m.norm() < 0.05);
}

TEST_CASE("taken from above, the bucket is drawn up to the hook without a jump") {
  Scene1 scene({0.04, 0, -0.05});
  scene.sling.command(true);
  Eigen::Vector3d before_m = scene.cargoes[0].handle_apex_ned_m();
  for (int i = 0; i < 400; ++i) {
    scene.run(step_s);
    CHECK((scene.cargoes[0].handle_apex_ned_m() - before_m).norm() < 0.01);
    before_m = scene.cargoes[0].handle_apex_ned_m();
  }
  CHECK(scene.sling.load_n() > 10);
  CHECK((scene.anchor_m - before_m).norm() == Approx(0.8).epsilon(0.001));
}

TEST_CASE("lifted askew a bucket drags until the hook is over it, and neither tips nor sinks in") {
  Scene1 scene({0, 0, 0.03});
  scene.sling.command(true);
  scene.run(0.4);
  REQUIRE(scene.sling.carried() == 0);
  scene.run(1, {0.3, 0, 0});  // the rope leans by 20 deg
  for (int i = 0; i < 400; ++i) {
    scene.run(step_s, {0, 0, -0.2});
    CHECK(scene.cargoes[0].clearance_m(scene.floor) > -0.01);
  }
  CHECK(scene.sling.carried() == 0);
  CHECK_FALSE(scene.cargoes[0].tipped());
}

TEST_CASE("set down upon another the bucket is toppled and out of the hook") {
  Scene1 scene({0, 0, 0.03});
  scene.sling.command(true);
  scene.run(0.4);
  scene.run(1, {0, 0, -0.5});
  REQUIRE(scene.sling.carried() == 0);
  scene.cargoes[0].topple(scene.floor, {1, 0, 0});
  scene.run(0.1);
  CHECK(scene.sling.carried() == -1);
  CHECK(scene.sling.closed());
  CHECK(scene.cargoes[0].state() == Cargo::State::lying);
}

TEST_CASE("never told to close, or out of reach, it takes nothing") {
  Scene1 idle;
  idle.run(3);
  CHECK(idle.sling.carried() == -1);
  Scene1 far({0.09, 0, 0});
  far.sling.command(true);
  far.run(3);
  CHECK(far.sling.carried() == -1);
  CHECK_FALSE(far.sling.closed());
}

TEST_CASE("a bucket that swings too hard is thrown off, and the jaws stay closed on nothing") {
  Scene1 scene;
  scene.sling.command(true);
  scene.run(0.4);
  scene.run(4, {0, 0, -1});
  REQUIRE(scene.sling.carried() == 0);
  scene.run(0.3, {9, 0, 0});
  scene.run(1);
  CHECK(scene.sling.carried() == -1);
  CHECK(scene.sling.closed());
  CHECK(scene.sling.load_n() == 0);
}

TEST_CASE("badly taken ones slip off in flight, well taken ones don't") {
  int good = 0, bad = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    for (const bool poor : {false, true}) {
      Scene1 scene({poor ? 0.078 : 0.03, 0, 0}, seed);
      scene.sling.command(true);
      scene.run(0.4);
      REQUIRE(scene.sling.carried() == 0);
      scene.run(20, {0, 0, -0.3});
      (poor ? bad : good) += scene.sling.carried() == -1;
    }
  }
  CHECK(good == 0);
  CHECK(bad == Approx(60 * 0.5 * 0.175 / 0.2).margin(12));  // 3 sigma
}

TEST_CASE("an empty hook that is let down lies on the deck and goes with it") {
  Scene1 scene({1, 0, 0});
  scene.floor.decks[0].rigid.velocity_ned_mps = {0.5, 0, 0};
  scene.run(1, {0, 0, 0.6});
  CHECK(scene.sling.hook_ned_m().z() == Approx(0).margin(1e-9));
  CHECK(scene.sling.load_n() == 0);
}
