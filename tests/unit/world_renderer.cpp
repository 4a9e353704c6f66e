#include "sim_proc/world/renderer.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <vector>

#include "sim_proc/world/scenery.hpp"
#include "sim_proc/world/view.hpp"

using namespace stevedore;
using namespace stevedore::world;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

/// Straight down from 3 m, north at the top, 300 px focal length: 100 px a metre at world z = 0.
Scene from_above() {
  Scene scene;
  scene.eye.rigid.position_ned_m = {0, 0, -3};
  scene.eye.rigid.ned_from_local = Eigen::AngleAxisd(pi / 2, Vector3d::UnitZ());
  scene.eye.lens.given = scene.eye.lens.rectified = {320, 240, 300, 300, 159.5, 119.5};
  scene.eye.lens.response = {Response::Curve::linear, 1};
  scene.eye.noise_levels = 0;
  scene.eye.exposure_s = 0;
  scene.surroundings.surface.grain = 0;
  scene.aircraft.body.position_ned_m = {0, 0, 100};  // under the ground: it shades nothing
  return scene;
}

Deck plain_deck(float reflectance) {
  Deck deck;
  deck.half_size_m = {5, 5};
  deck.thickness_m = 0.01;
  deck.ground.colour = {reflectance, reflectance, reflectance};
  deck.ground.grain = 0;
  return deck;
}

Scene over_plain_deck(float reflectance) {
  Scene scene = from_above();
  scene.decks = {plain_deck(reflectance)};
  return scene;
}

/// Green level at a place on the ground.
double level_at(const cv::Mat& bgr, double north_m, double east_m) {
  return bgr.at<cv::Vec3b>(cvRound(119.5 - 100 * north_m), cvRound(159.5 + 100 * east_m))[1];
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_INF) == 0;
}

/// All kinds of things, blurred, noisy, with spray and glare.
Scene full_scene() {
  const Scenery scenery = draw_scenery({5, false, 0.5});
  std::vector<Rigid> decks(3);
  decks[1].position_ned_m = {20, 0, -0.5};
  decks[2].position_ned_m = {-20, 0, 0};
  decks[0].position_ned_m = {0, 0, -0.5};
  Scene scene = scenery.place(decks);
  for (size_t i = 0; i < scene.buckets.size(); ++i)
    scene.buckets[i].rigid.position_ned_m = {0.3 * static_cast<double>(i), 0.5, -0.5};
  scene.surroundings.spray = 0.01F;
  scene.surroundings.glare = 0.1F;
  scene.surroundings.haze = 0.05F;
  scene.eye = from_above().eye;
  scene.eye.rigid.position_ned_m.z() = -4;
  scene.eye.rigid.velocity_ned_mps = {1, 2, 0.3};
  scene.eye.exposure_s = 0.01;
  scene.eye.noise_levels = 3;
  return scene;
}

/// Deviation, in pixels, of a rising edge's slope along the middle row, and its centre.
struct EdgeShape {
  double centre_px = 0, deviation_px = 0;
};
EdgeShape edge_shape(const cv::Mat& bgr, int first, int last) {
  const auto level = [&](int u) { return static_cast<double>(bgr.at<cv::Vec3b>(120, u)[1]); };
  double total = 0, sum = 0, squares = 0;
  for (int u = first; u < last; ++u) {
    const double rise = level(u + 1) - level(u), at = u + 0.5;
    total += rise;
    sum += rise * at;
    squares += rise * at * at;
  }
  return {sum / total, std::sqrt(squares / total - std::pow(sum / total, 2))};
}

/// West of the middle dark deck, east of it a bright mark.
Scene with_upright_edge() {
  Scene scene = over_plain_deck(0.1F);
  Mark bar;
  bar.shape = Mark::Shape::bar;
  bar.center_deck_m = {0, 1};
  bar.length_m = 2;
  bar.width_m = 8;
  bar.angle_rad = pi / 2;
  bar.paint.colour = {0.7F, 0.7F, 0.7F};
  bar.paint.grain = 0;
  scene.decks[0].marks = {bar};
  return scene;
}

}  // namespace

TEST_CASE("the same scene gives the same bytes, again and with any number of threads") {
  const Scene scene = full_scene();
  Renderer one(1), two(2), five(5);
  const cv::Mat first = one.render(scene);
  CHECK(same(first, one.render(scene)));
  CHECK(same(first, two.render(scene)));
  CHECK(same(first, five.render(scene)));
  Scene other = scene;
  other.eye.noise_seed = 77;
  CHECK_FALSE(same(first, one.render(other)));
}

TEST_CASE("a renderer follows a change of lens and size") {
  Scene scene = full_scene(), wide = scene;
  wide.eye.lens.given = wide.eye.lens.rectified = {160, 120, 100, 100, 79.5, 59.5};
  Renderer renderer(1), fresh(1);
  renderer.render(scene);
  const cv::Mat picture = renderer.render(wide);
  CHECK(picture.size() == cv::Size(160, 120));
  CHECK(same(picture, fresh.render(wide)));
}

TEST_CASE("a plain deck's level is its reflectance through the camera's response") {
  Renderer renderer(1);
  Scene scene = over_plain_deck(0.5F);
  const float full = std::max({1.25F, 0.96F + 0.28F, 0.9F + 0.32F});  // a white deck's red, sun and sky
  const double green = 0.5 * (0.96 + 0.28) / static_cast<double>(full);
  CHECK(level_at(renderer.render(scene), 0, 0) == Approx(255 * green).margin(1));
  scene.eye.lens.response = {Response::Curve::srgb, 1};
  CHECK(level_at(renderer.render(scene), 0, 0) ==
        Approx(255 * (1.055 * std::pow(green, 1 / 2.4) - 0.055)).margin(1));
  scene.eye.lens.response = {Response::Curve::gamma, 1.8};
  CHECK(level_at(renderer.render(scene), 0, 0) == Approx(255 * std::pow(green, 1 / 1.8)).margin(1));
  scene.eye.gain = 0.5F;
  CHECK(level_at(renderer.render(scene), 0, 0) == Approx(255 * std::pow(green / 2, 1 / 1.8)).margin(1));
  // the sun at 60 degrees from the normal gives half
  scene.eye.gain = 1;
  scene.eye.lens.response = {Response::Curve::linear, 1};
  scene.light.to_sun_ned = {std::sin(pi / 3), 0, -std::cos(pi / 3)};
  const double slanting = 0.5 * (0.96 / 2 + 0.28) / static_cast<double>(full);
  CHECK(level_at(renderer.render(scene), 0, 0) == Approx(255 * slanting).margin(1));
}

TEST_CASE("a pole throws its shadow away from the sun, as long as it is high at 45 degrees") {
  Renderer renderer(1);
  Scene scene = over_plain_deck(0.6F);
  scene.light.to_sun_ned = Vector3d(1, 0, -1).normalized();
  const double lit = level_at(renderer.render(scene), -0.5, 0);
  Capsule pole;
  pole.to_ned_m = {0, 0, -0.8};
  pole.radius_m = 0.05;
  scene.capsules = {pole};
  const cv::Mat picture = renderer.render(scene);
  const double in_shadow = level_at(picture, -0.5, 0);
  CHECK(in_shadow / lit == Approx(0.28 / (0.28 + 0.96 * std::cos(pi / 4))).margin(0.02));
  CHECK(level_at(picture, 0.5, 0) == lit);
  CHECK(level_at(picture, -0.5, 0.1) == lit);
  CHECK(level_at(picture, -0.8, 0) == in_shadow);  // sphere at the top: its shadow is 1.41 radii long
  CHECK(level_at(picture, -0.8 - 0.045, 0) == Approx(in_shadow).margin(4));
  CHECK(level_at(picture, -0.8 - 0.12, 0) == lit);
}

TEST_CASE("the aircraft's rotor dims what it flies over, a bucket shades behind it and within it") {
  Renderer renderer(1);
  Scene scene = over_plain_deck(0.6F);
  const double lit = level_at(renderer.render(scene), 0, 0.5);
  scene.aircraft.body.position_ned_m = {0, 0, -5};
  const double dimmed = level_at(renderer.render(scene), 0, 0.5);
  CHECK(dimmed / lit == Approx((0.75 * 0.96 + 0.28) / (0.96 + 0.28)).margin(0.01));
  scene.aircraft.body.position_ned_m = {0, 0, 100};
  scene.light.to_sun_ned = Vector3d(0, 1, -1).normalized();
  Bucket bucket;
  bucket.inside.grain = bucket.outside.grain = 0;
  scene.buckets = {bucket};
  const cv::Mat picture = renderer.render(scene);
  CHECK(level_at(picture, 0, -0.35) < 0.6 * level_at(picture, 0, 0.6));
  CHECK(level_at(picture, 0.07, 0) <
        0.4 * level_at(picture, 0, 0.6));  // its floor lies deeper than it is wide
  // from the east the sun reaches the west wall's inside, near its top, not the east wall's
  CHECK(level_at(picture, 0, -0.15) > 1.5 * level_at(picture, 0, 0.145));
}

TEST_CASE("motion blur is as long as the way over the image in an exposure, and centred") {
  Renderer renderer(1);
  Scene scene = with_upright_edge();
  const EdgeShape still = edge_shape(renderer.render(scene), 130, 190);
  CHECK(still.centre_px == Approx(159.5).margin(0.02));
  CHECK(still.deviation_px == Approx(0.6).margin(0.02));  // the lens'; the edge lies between two pixels
  scene.eye.rigid.velocity_ned_mps = {0, 4, 0};
  scene.eye.exposure_s = 0.02;  // 8 cm, 8 px
  const EdgeShape moved = edge_shape(renderer.render(scene), 130, 190);
  const double way_px = std::sqrt(12 * (std::pow(moved.deviation_px, 2) - std::pow(still.deviation_px, 2)));
  CHECK(way_px == Approx(8).epsilon(0.05));
  CHECK(moved.centre_px == Approx(159.5).margin(0.03));
  scene.decks[0].rigid.velocity_ned_mps = {0, 4, 0};  // it keeps pace: nothing moves in the image
  CHECK(edge_shape(renderer.render(scene), 130, 190).deviation_px == Approx(still.deviation_px).margin(0.01));
  scene.decks[0].rigid.velocity_ned_mps = {0, 0, 0};
  scene.eye.rigid.velocity_ned_mps = {0, 0, 0};
  scene.eye.rigid.angular_velocity_ned_radps = {1, 0, 0};  // f w t = 300 px * 0.02
  const EdgeShape turned = edge_shape(renderer.render(scene), 130, 190);
  CHECK(std::sqrt(12 * (std::pow(turned.deviation_px, 2) - std::pow(still.deviation_px, 2))) ==
        Approx(6).epsilon(0.05));
}

TEST_CASE("noise is as strong as asked for at mid grey, weaker in the dark, new in each frame") {
  Renderer renderer(1);
  for (const auto& response : {Response{Response::Curve::linear, 1}, Response{Response::Curve::srgb, 1}}) {
    const bool linear = response.curve == Response::Curve::linear;
    Scene scene = over_plain_deck(linear ? 0.502F : 0.2158F);  // level 128
    scene.light.sun = {1, 1, 1};
    scene.light.sky = {0, 0, 0};
    scene.eye.lens.response = response;
    scene.eye.noise_levels = 4;
    cv::Scalar mean, deviation;
    cv::meanStdDev(renderer.render(scene), mean, deviation);
    CHECK(mean[1] == Approx(128).margin(1));
    for (int channel = 0; channel < 3; ++channel)
      CHECK(deviation[channel] == Approx(std::sqrt(16 + 1.0 / 12)).epsilon(0.03));  // and rounding
    cv::Mat channels[3];
    cv::split(renderer.render(scene), channels);
    cv::Mat difference;
    cv::subtract(channels[0], channels[2], difference, cv::noArray(), CV_32F);
    cv::meanStdDev(difference, mean, deviation);
    CHECK(deviation[0] == Approx(4 * std::sqrt(2)).epsilon(0.05));  // channels know nothing of each other
    if (!linear) continue;
    scene.decks[0].ground.colour *= 0.1F;
    cv::meanStdDev(renderer.render(scene), mean, deviation);
    CHECK(deviation[1] < 2.2);
  }
}

TEST_CASE("a strand thinner than a pixel takes as much light as its area") {
  Renderer renderer(1);
  Scene scene = over_plain_deck(0.6F);
  const double lit = level_at(renderer.render(scene), 0, 0.5);
  Strand wire;
  wire.radius_m = 0.002;  // 0.4 px wide
  wire.points_ned_m = {{-1, 0.013, -0.002}, {1, 0.013, -0.002}};
  wire.surface.colour = {0, 0, 0};
  scene.strands = {wire};
  const cv::Mat picture = renderer.render(scene);
  double missing = 0;
  for (int u = 150; u < 172; ++u) missing += lit - picture.at<cv::Vec3b>(100, u)[1];
  CHECK(missing / lit == Approx(0.4).margin(0.03));
}

TEST_CASE("worn paint shows as much ground as is worn, and textures keep the mean") {
  Renderer renderer(1);
  Scene scene = with_upright_edge();
  scene.decks[0].marks[0].width_m = 8;
  scene.decks[0].marks[0].center_deck_m = {0, 0};
  scene.decks[0].marks[0].length_m = 8;
  const double fresh = cv::mean(renderer.render(scene))[1];
  scene.decks[0].marks[0].paint.grain = 0.2F;
  CHECK(cv::mean(renderer.render(scene))[1] == Approx(fresh).epsilon(0.05));
  scene.decks[0].marks[0].paint.grain = 0;
  scene.decks[0].marks[0].paint.wear = 0.3F;
  const double bare = fresh * 0.1 / 0.7;
  CHECK((fresh - cv::mean(renderer.render(scene))[1]) / (fresh - bare) == Approx(0.3).margin(0.05));
}

TEST_CASE("only what is before the camera bounds a thing's picture") {
  const Scene scene = from_above();  // the eye is 3 m up
  const LensRays rays = rays_of(scene.eye.lens);
  const View view(scene.eye, rays);
  CHECK(view.bounds_of({{0, 0, -3.5}, {0.5, 0.5, -4}}, 2).empty());
  // from a metre north on the ground, at v = 19.5, upwards out of the image and past the eye
  const PixelRect beside = view.bounds_of({{1, -0.1, 0}, {1, 0.1, 0}, {1, -0.1, -4}, {1, 0.1, -4}}, 2);
  CHECK(beside.top == 0);
  CHECK(beside.bottom >= 20);
  CHECK(beside.bottom <= 24);
  // wide where it comes near the eye, so to both sides
  CHECK(beside.left == 0);
  CHECK(beside.right == 320);
}

TEST_CASE("a pole that goes up past the camera is drawn as far as it is in front of it") {
  Renderer renderer(1);
  Scene scene = over_plain_deck(0.6F);
  Capsule pole;
  pole.from_ned_m = {0.5, 0, 0};
  pole.to_ned_m = {0.5, 0, -4};
  pole.radius_m = 0.05;
  scene.capsules = {pole};
  scene.light.to_sun_ned = {0, 0, -1};
  const cv::Mat without = renderer.render(over_plain_deck(0.6F)), with = renderer.render(scene);
  const auto changed = [&](double north_m) {
    return std::abs(level_at(with, north_m, 0) - level_at(without, north_m, 0)) > 20;
  };
  CHECK(changed(0.5));  // its foot
  CHECK(changed(1.1));  // its upper parts, farther out up to the image's edge
  CHECK_FALSE(changed(0.4));
}
