#include "sim_proc/world/ray.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace stevedore::world;
using Eigen::Vector3d;
using What = Hit::What;
using std::numbers::pi;

namespace {

const Vector3d down(0, 0, 1);

Scene with_deck() {
  Scene scene;
  scene.decks.emplace_back();
  scene.decks[0].rigid.position_ned_m = {5, 0, -1};
  return scene;
}

std::optional<Hit> towards(const Scene& scene, const Vector3d& from, const Vector3d& to) {
  return first_hit(scene, from, (to - from).normalized());
}

}  // namespace

TEST_CASE("a ray down meets the surroundings at its height, a ray up meets nothing") {
  const auto hit = first_hit({}, {1, 2, -7}, down);
  REQUIRE(hit);
  CHECK(hit->what == What::surroundings);
  CHECK(hit->index == -1);
  CHECK(hit->range_m == Approx(7));
  CHECK_FALSE(first_hit({}, {1, 2, -7}, {0, 0, -1}));
  CHECK_FALSE(first_hit({}, {1, 2, -7}, {1, 0, 0}));
}

TEST_CASE("a deck is met on its upper side inside its edges, and on its side from outside") {
  Scene scene = with_deck();
  CHECK(first_hit(scene, {6.99, 1.99, -4}, down)->range_m == Approx(3));
  CHECK(first_hit(scene, {6.99, 1.99, -4}, down)->what == What::deck);
  CHECK(first_hit(scene, {7.01, 0, -4}, down)->what == What::surroundings);
  CHECK(first_hit(scene, {0, 0, -0.75}, {1, 0, 0})->range_m == Approx(3));
  // rolled by 30 degrees about the axis through its middle, 1 m aside it is 1 m times tan 30 lower
  scene.decks[0].rigid.ned_from_local = Eigen::AngleAxisd(pi / 6, Vector3d::UnitX());
  CHECK(first_hit(scene, {5, 1, -4}, down)->range_m == Approx(3 + std::tan(pi / 6)));
}

TEST_CASE("a bucket is open: its floor, inside and outside, rim and handle are met where they are") {
  Scene scene = with_deck();
  Bucket bucket;
  bucket.rigid.position_ned_m = {5, 0, -1};
  bucket.handle_rad = pi / 2;  // fallen towards +x, clear of the middle
  scene.buckets = {bucket};
  CHECK(first_hit(scene, {5, 0, -4}, down)->what == What::bucket);
  CHECK(first_hit(scene, {5, 0, -4}, down)->range_m == Approx(3 - bucket.wall_m));
  CHECK(first_hit(scene, {5 - 0.158, 0, -4}, down)->range_m == Approx(3 - 0.30));
  CHECK(first_hit(scene, {5 - 0.17, 0, -4}, down)->what == What::deck);
  // level, at half height, where the radius is the mean of base and rim
  CHECK(first_hit(scene, {0, 0, -1.15}, {1, 0, 0})->range_m == Approx(5 - 0.145));
  // over the near rim to the far wall's inside, 0.1 m below the rim
  const double inside_m = 0.16 - 0.1 * 0.03 / 0.3 - bucket.wall_m;
  const Vector3d from(5 - 1, 0, -2), to(5 + inside_m, 0, -1.2);
  CHECK(towards(scene, from, to)->range_m == Approx((to - from).norm()));
  // the fallen handle's apex
  CHECK(first_hit(scene, {5 + 0.12, 0, -4}, down)->range_m == Approx(2.7 - 0.002));
  scene.buckets[0].handle_rad = 0;
  CHECK(first_hit(scene, {5, 0, -4}, down)->range_m == Approx(3 - 0.30 - 0.12 - 0.002).margin(1e-4));
}

TEST_CASE("tyre, capsule and strand are met where they are, the nearest first") {
  Scene scene = with_deck();
  Tyre tyre;
  tyre.rigid.position_ned_m = {5, 1, -1};
  scene.tyres = {tyre};
  CHECK(first_hit(scene, {5 + 0.21, 1, -4}, down)->range_m == Approx(3 - 0.18).margin(1e-4));
  CHECK(first_hit(scene, {5, 1, -4}, down)->what == What::deck);  // through its hole
  CHECK(first_hit(scene, {5.31, 1, -4}, down)->what == What::deck);
  CHECK(first_hit(scene, {5, 0, -1.09}, {0, 1, 0})->range_m == Approx(0.7).margin(1e-4));
  Capsule person;
  person.from_ned_m = {5, 1, -1};
  person.to_ned_m = {5, 1, -2.5};
  person.radius_m = 0.2;
  scene.capsules = {person};
  CHECK(first_hit(scene, {5, 1, -4}, down)->range_m == Approx(1.3));
  CHECK(first_hit(scene, {4, 1, -2}, {1, 0, 0})->range_m == Approx(0.8));
  CHECK(first_hit(scene, {5, 1, -4}, down)->what == What::capsule);
  Strand rope;
  rope.points_ned_m = {{4, 0.9, -3}, {6, 0.9, -3}, {6, 1.1, -3}};
  rope.radius_m = 0.01;
  scene.strands = {rope};
  CHECK(first_hit(scene, {5, 0.9, -4}, down)->what == What::strand);
  CHECK(first_hit(scene, {5, 0.9, -4}, down)->range_m == Approx(0.99));
  CHECK(first_hit(scene, {5, 0.92, -4}, down)->what == What::capsule);
}
