// Buckets: standing, riding, falling, tipping.
#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim_proc/world/cargo.hpp"
#include "sim_proc/world/tip_over.hpp"

using namespace stevedore::world;

namespace {

constexpr double step_s = 0.005, deg = std::numbers::pi / 180;
const Eigen::Vector3d up(0, 0, -1), down(0, 0, 1), none = Eigen::Vector3d::Zero();

Touchdown touch(double lean_rad, const Eigen::Vector3d& velocity_mps,
                const Eigen::Vector3d& spin_radps = none) {
  return {up, down, Eigen::Vector3d(std::sin(lean_rad), 0, -std::cos(lean_rad)), velocity_mps, spin_radps};
}

bool stands(const Touchdown& touchdown) {
  return land(Bucket{}, touchdown).stands;
}

Floor deck_at(const Rigid& rigid) {
  return {{{rigid, {2, 2}}}, false};
}

Cargo hung(const Floor& floor, const Eigen::Vector3d& base_m, const Eigen::Vector3d& velocity_mps,
           double lean_rad = 0) {
  Cargo cargo(Bucket{}, 0, {0, 0}, 0, floor);
  const Eigen::Vector3d axis(std::sin(lean_rad), 0, -std::cos(lean_rad));
  for (int i = 0; i < 2; ++i) cargo.hang(base_m + 0.15 * axis, velocity_mps, axis, step_s);
  return cargo;
}

void run(Cargo& cargo, const Floor& floor, double time_s) {
  for (int i = 0; i < std::lround(time_s / step_s); ++i) cargo.step(floor, step_s);
}

}  // namespace

TEST_CASE("set down flat it stands up to the sideways speed whose energy lifts its centre over the edge") {
  // by hand: radius 0.13 m, centre 0.15 m up; inertia about the edge 0.145^2 / 2 + 0.3^2 / 12 + 0.13^2 +
  // 0.15^2
  const double inertia_m2 = 0.0105125 + 0.0075 + 0.0169 + 0.0225, lift_m = std::hypot(0.13, 0.15) - 0.15;
  const double limit_mps = std::sqrt(2 * 9.81 * lift_m * inertia_m2) / 0.15;
  CHECK(limit_mps == Approx(1.558).epsilon(0.001));
  for (const Eigen::Vector3d& direction : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, -1, 0)}) {
    CHECK(stands(touch(0, 0.99 * limit_mps * direction)));
    const Landing landing = land(Bucket{}, touch(0, 1.01 * limit_mps * direction));
    CHECK_FALSE(landing.stands);
    CHECK((landing.falls_to - direction).norm() < 1e-9);
  }
  CHECK(stands(touch(0, {0, 0, 5})));  // straight down, flat: it would bounce or burst, not tip
}

TEST_CASE("on a sloping deck it tips more easily down the slope than up") {
  const Eigen::Vector3d gravity(std::sin(10 * deg), 0, std::cos(10 * deg));  // the deck falls towards +x
  Touchdown downhill = touch(0, {1.3, 0, 0}), uphill = touch(0, {-1.3, 0, 0});
  CHECK(stands(downhill));
  downhill.gravity_down = uphill.gravity_down = gravity;
  CHECK_FALSE(stands(downhill));
  CHECK(stands(uphill));
}

TEST_CASE("leaning it rocks back to its base, until it leans or turns too much") {
  CHECK(stands(touch(10 * deg, none)));
  CHECK(stands(touch(40 * deg, none)));  // its edge angle is atan(0.13 / 0.15) = 40.9 deg
  CHECK_FALSE(stands(touch(41.5 * deg, none)));
  CHECK(stands(touch(10 * deg, {0, 0, 1})));
  CHECK_FALSE(stands(touch(10 * deg, {0, 0, 8})));  // slapped down so hard that it goes over the other edge
  CHECK(land(Bucket{}, touch(10 * deg, {0, 0, 8})).falls_to.x() == Approx(-1));
  CHECK_FALSE(stands(touch(20 * deg, none, {0, -8, 0})));  // about west: leans more
  CHECK(stands(touch(20 * deg, none, {0, 8, 0})));
  CHECK_FALSE(stands(touch(90 * deg, none)));
  CHECK_FALSE(stands(touch(170 * deg, none)));
}

TEST_CASE("it stands on its deck and rides along through every tilt") {
  Rigid rigid;
  Floor floor = deck_at(rigid);
  Cargo cargo(Bucket{}, 0, {0.5, -1}, 0.3, floor);
  rigid.position_ned_m = {3, 4, -1};
  rigid.ned_from_local = Eigen::AngleAxisd(15 * deg, Eigen::Vector3d(1, 2, 3).normalized());
  rigid.velocity_ned_mps = {1, 0, 0.2};
  rigid.angular_velocity_ned_radps = {0.1, 0.2, 0.3};
  floor = deck_at(rigid);
  cargo.step(floor, step_s);
  CHECK((cargo.bucket().rigid.position_ned_m - rigid.to_ned({0.5, -1, 0})).norm() < 1e-12);
  CHECK((cargo.axis_ned() - rigid.ned_from_local * up).norm() < 1e-12);
  CHECK((cargo.bucket().rigid.velocity_ned_mps - rigid.velocity_at(rigid.to_ned({0.5, -1, 0}))).norm() <
        1e-12);
  CHECK((cargo.rim_center_ned_m() - rigid.to_ned({0.5, -1, -0.3})).norm() < 1e-12);
  CHECK((cargo.handle_apex_ned_m() - rigid.to_ned({0.5, -1, -0.42})).norm() < 1e-12);
  CHECK(cargo.deck() == 0);
}

TEST_CASE("let go it falls as a stone does and stands where it comes down") {
  const Floor floor = deck_at({});
  Cargo cargo = hung(floor, {0.3, 0.2, -0.8}, {0.4, 0, 0});
  cargo.let_go();
  const double time_s = std::sqrt(2 * 0.8 / 9.81);
  run(cargo, floor, time_s - 0.02);
  CHECK(cargo.state() == Cargo::State::falling);
  CHECK(cargo.bucket().rigid.velocity_ned_mps.z() == Approx(9.81 * (time_s - 0.02)).epsilon(0.02));
  run(cargo, floor, 0.05);
  CHECK(cargo.state() == Cargo::State::standing);
  CHECK(cargo.deck() == 0);
  CHECK_FALSE(cargo.tipped());
  CHECK((cargo.bucket().rigid.position_ned_m - Eigen::Vector3d(0.3 + 0.4 * time_s, 0.2, 0)).norm() < 0.005);
  CHECK((cargo.axis_ned() - up).norm() < 1e-9);
}

TEST_CASE("dropped fast sideways it tips, rolls a bit, and lies on its side") {
  const Floor floor = deck_at({});
  Cargo cargo = hung(floor, {0, 0, -0.2}, {2, 0, 0});
  cargo.let_go();
  run(cargo, floor, 4);
  CHECK(cargo.state() == Cargo::State::lying);
  CHECK(cargo.tipped());
  CHECK(cargo.axis_ned().x() > 0.99);
  CHECK(cargo.bucket().rigid.position_ned_m.z() == Approx(-0.13).margin(0.001));
  CHECK((cargo.rim_center_ned_m().z()) == Approx(-0.16).margin(0.002));
  CHECK(cargo.bucket().rigid.position_ned_m.x() > 2 * 0.2 + 0.13 + 0.4);
  CHECK(cargo.bucket().rigid.velocity_ned_mps.norm() == 0);
}

TEST_CASE("beside the deck it comes down on the ground, in water it is gone, over the edge it rolls off") {
  Rigid high;
  high.position_ned_m.z() = -1;
  Floor floor = deck_at(high);
  Cargo beside = hung(floor, {2.5, 0, -1.5}, none);
  beside.let_go();
  run(beside, floor, 2);
  CHECK(beside.deck() == -1);
  CHECK(beside.state() == Cargo::State::standing);
  CHECK(beside.bucket().rigid.position_ned_m.z() == Approx(0).margin(1e-9));

  Cargo roller = hung(floor, {1.7, 0, -1.1}, {2.5, 0, 0});
  roller.let_go();
  run(roller, floor, 3);
  CHECK(roller.state() == Cargo::State::lying);
  CHECK(roller.deck() == -1);

  floor.water = true;
  Cargo wet = hung(floor, {2.5, 0, -1.5}, none);
  wet.let_go();
  run(wet, floor, 2);
  CHECK(wet.state() == Cargo::State::sunk);
}

TEST_CASE("on top of another it topples away from it") {
  const Floor floor = deck_at({});
  std::vector<Cargo> cargoes{Cargo(Bucket{}, 0, {0, 0}, 0, floor), Cargo(Bucket{}, 0, {0.2, 0}, 0, floor),
                             Cargo(Bucket{}, 0, {1, 0}, 0, floor)};
  keep_apart(cargoes, 1, floor);
  CHECK(cargoes[1].tipped());
  CHECK(cargoes[1].axis_ned().x() > 0.9);
  keep_apart(cargoes, 2, floor);
  CHECK_FALSE(cargoes[2].tipped());
  CHECK_FALSE(cargoes[0].tipped());
}
