#include "sim_proc/world/outline.hpp"

#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "geometry/rectify.hpp"

using namespace stevedore;
using namespace stevedore::world;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

/// Looks straight down from 3 m over the origin, the top of its image to the north.
Scene from_above() {
  Scene scene;
  scene.eye.rigid.position_ned_m = {0, 0, -3};
  scene.eye.rigid.ned_from_local = Eigen::AngleAxisd(pi / 2, Vector3d::UnitZ());
  scene.eye.lens.given = scene.eye.lens.rectified = {640, 480, 300, 300, 319.5, 239.5};
  return scene;
}

const Vector3d up(0, 0, -1);

}  // namespace

TEST_CASE("a circle seen straight from above is a circle of radius f r over h") {
  const auto outline = outline_of(from_above(), {{0.2, 0.5, 0}, up, 0.5});
  REQUIRE(outline);
  CHECK(outline->ideal.a_px == Approx(50));
  CHECK(outline->ideal.b_px == Approx(50));
  CHECK(outline->ideal.u_px == Approx(319.5 + 50));  // east is right
  CHECK(outline->ideal.v_px == Approx(239.5 - 20));  // north is up
  CHECK(outline->visible_share == 1);
}

TEST_CASE("every point of a tilted circle lies on its outline") {
  Scene scene = from_above();
  const Vector3d normal = Vector3d(0.3, -0.2, -1).normalized(), centre(0.4, -0.3, -0.2);
  const auto outline = outline_of(scene, {centre, normal, 0.5});
  REQUIRE(outline);
  const Vector3d across = normal.cross(Vector3d::UnitX()).normalized();
  for (int i = 0; i < 12; ++i) {
    const Vector3d point = centre + 0.5 * (Eigen::AngleAxisd(i * pi / 6, normal) * across);
    const Eigen::Vector2d px = scene.eye.lens.rectified.project(scene.eye.rigid.to_local(point));
    CHECK(normalized_radius_squared(outline->ideal, px) == Approx(1).epsilon(1e-9));
  }
}

TEST_CASE("with distortion the given outline follows the bent one, the ideal outline is unmoved") {
  Scene scene = from_above();
  const Circle3 circle{{0.8, 0.9, 0}, up, 0.5};
  const Ellipse straight = outline_of(scene, circle)->ideal;
  scene.eye.lens.distortion = Distortion::plumb_bob;
  scene.eye.lens.coefficients = {-0.28, 0.075, 0.0006, -0.0004, 0};
  const auto bent = outline_of(scene, circle);
  REQUIRE(bent);
  CHECK(bent->ideal.u_px == Approx(straight.u_px));
  CHECK(bent->given.a_px < straight.a_px - 1);  // a barrel lens makes the edge of the image smaller
  for (int i = 0; i < 12; ++i) {
    const Eigen::Vector2d px = distort(scene.eye.lens, point_at(straight, i * pi / 6));
    CHECK(normalized_radius_squared(bent->given, px) == Approx(1).margin(0.05));
  }
}

TEST_CASE("the visible share counts what the image's border cuts and what things hide") {
  Scene scene = from_above();
  // its centre on the left border, half a pixel left of the first column's centre
  const double at_border_m = (-0.5 - 319.5) / 100;
  CHECK(outline_of(scene, {{0, at_border_m, 0}, up, 0.5})->visible_share == Approx(0.5).margin(0.01));
  CHECK_FALSE(outline_of(scene, {{0, at_border_m - 0.51, 0}, up, 0.5}));
  // a wall at 60 degrees of its angle: a third of the circle's edge has sin > 1/2, and lies beyond it
  Deck roof;
  roof.half_size_m = {1, 1};
  roof.thickness_m = 0.001;
  roof.rigid.position_ned_m = {0, 1.25, -0.01};
  scene.decks = {roof};
  CHECK(outline_of(scene, {{0, 0, 0}, up, 0.5})->visible_share == Approx(2.0 / 3).margin(0.02));
  CHECK(outline_of(scene, {{0, 1, 0}, up, 0.5})->visible_share == 0);
}

TEST_CASE(
    "a deck does not hide the circle on it, a bucket beside the circle does not, one on its edge does") {
  Scene scene = from_above();
  scene.decks.emplace_back();
  Bucket bucket;
  scene.buckets = {bucket};
  const Circle3 circle{{0, 0, 0}, up, 0.5};
  CHECK(outline_of(scene, circle)->visible_share == 1);
  scene.buckets[0].rigid.position_ned_m = {0.5, 0, 0};
  const double share = outline_of(scene, circle)->visible_share;
  // its base alone covers a chord of 0.26 m of the edge, its rim, nearer, more
  CHECK(share < 1 - 0.26 / pi);
  CHECK(share > 0.8);
}

TEST_CASE("there is no outline of a circle that reaches behind the camera") {
  CHECK_FALSE(outline_of(from_above(), {{0, 0, -3}, up, 0.5}));
  CHECK_FALSE(outline_of(from_above(), {{0, 0, -5}, up, 0.5}));
}
