// The picture and the truth are two computations of one thing: edges found in pictures, by a way that knows
// nothing of either, lie on the outlines.
#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "geometry/rectify.hpp"
#include "sim_proc/world/dice.hpp"
#include "sim_proc/world/outline.hpp"
#include "sim_proc/world/renderer.hpp"

using namespace stevedore;
using namespace stevedore::world;
using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

namespace {

/// Green channel, bilinear.
double level_at(const cv::Mat& bgr, const Vector2d& px) {
  const int u = static_cast<int>(std::floor(px.x())), v = static_cast<int>(std::floor(px.y()));
  const double p = px.x() - u, q = px.y() - v;
  const auto at = [&](int x, int y) { return static_cast<double>(bgr.at<cv::Vec3f>(y, x)[1]); };
  return (1 - q) * ((1 - p) * at(u, v) + p * at(u + 1, v)) +
         q * ((1 - p) * at(u, v + 1) + p * at(u + 1, v + 1));
}

constexpr double reach_px = 4;

/// Signed distance, along a direction, from a point to the edge that lies across it: where a step from one
/// end's level to the other's has the area that the profile has.
double edge_distance_px(const cv::Mat& bgr, const Vector2d& point, const Vector2d& direction) {
  constexpr int steps = 120;
  const double here = level_at(bgr, point - reach_px * direction),
               there = level_at(bgr, point + reach_px * direction);
  double area = 0;
  for (int i = 0; i < steps; ++i) {
    const double s = -reach_px + 2 * reach_px * (i + 0.5) / steps;
    area += (level_at(bgr, point + s * direction) - there) / (here - there) * 2 * reach_px / steps;
  }
  return area - reach_px;
}

struct Deviation {
  double mean_px = 0, worst_px = 0;
  int points = 0;
};

/// Blurring a bent edge moves it inwards by half of the blur's variance times the curvature. Ours: a Gaussian
/// that makes reading between pixels exact, the pixel (1/12 px^2) and the bilinear reading (1/6 px^2).
constexpr double smoothing_px = 1, variance_px2 = smoothing_px * smoothing_px + 1.0 / 12 + 1.0 / 6;

/// Of the circle through three points (Menger), positive where they turn right.
double curvature_of(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  const Vector2d p = b - a, q = c - b;
  return 2 * (p.x() * q.y() - p.y() * q.x()) / (p.norm() * q.norm() * (c - a).norm());
}

/// Of the edges in the picture from the outline, outwards, where the outline is well inside the picture.
Deviation deviation_of(const cv::Mat& sharp, const CameraModel& lens, const Ellipse& ideal) {
  Deviation out;
  cv::Mat bgr;
  sharp.convertTo(bgr, CV_32F);
  cv::GaussianBlur(bgr, bgr, {}, smoothing_px);
  constexpr int points = 90;
  for (int i = 0; i < points; ++i) {
    const auto outline = [&](double angle) { return distort(lens, point_at(ideal, angle)); };
    const double angle = 2 * pi * i / points;
    const Vector2d at = outline(angle), along = outline(angle + 1e-4) - outline(angle - 1e-4);
    const Vector2d outwards = Vector2d(along.y(), -along.x()).normalized();
    const double margin = reach_px + 2;
    if (at.x() < margin || at.y() < margin || at.x() > bgr.cols - margin || at.y() > bgr.rows - margin)
      continue;
    const double bend = curvature_of(outline(angle - 0.02), at, outline(angle + 0.02));
    const double distance = edge_distance_px(bgr, at, outwards) + variance_px2 * bend / 2;
    out.mean_px += distance;
    out.worst_px = std::max(out.worst_px, std::abs(distance));
    ++out.points;
  }
  out.mean_px /= std::max(1, out.points);
  return out;
}

/// Even light, no lens blur, no noise, an open shutter of no length, levels proportional to light.
Scene plain_scene(Distortion distortion) {
  Scene scene;
  scene.light.sun = {0, 0, 0};
  scene.light.sky = {1, 1, 1};
  scene.surroundings.surface.grain = 0;
  scene.aircraft.rotor_cover = 0;
  scene.eye.exposure_s = 0;
  scene.eye.blur_sigma_px = 0;
  scene.eye.noise_levels = 0;
  CameraModel& lens = scene.eye.lens;
  lens.given = {640, 480, 337, 336.5, 321.3, 238.2};
  lens.rectified = {640, 480, 337, 337, 319.5, 239.5};
  lens.response = {Response::Curve::linear, 1};
  lens.distortion = distortion;
  if (distortion == Distortion::plumb_bob) lens.coefficients = {-0.28, 0.075, 0.0006, -0.0004, 0};
  if (distortion == Distortion::equidistant) lens.coefficients = {-0.02, 0.004, -0.001, 0.0002};
  if (distortion == Distortion::none) lens.rectified = lens.given;
  return scene;
}

Eigen::Quaterniond tilted(Dice& dice, double most_rad) {
  const double way = dice.uniform(-pi, pi);
  return Eigen::AngleAxisd(dice.uniform(-pi, pi), Vector3d::UnitZ()) *
         Eigen::AngleAxisd(dice.uniform(0, most_rad), Vector3d(std::cos(way), std::sin(way), 0));
}

/// A deck with one mark, the camera over it from that height, somewhere aside and tilted.
Scene scene_of(const Mark& mark, Distortion distortion, double height_m, Dice& dice) {
  Scene scene = plain_scene(distortion);
  Deck deck;
  deck.half_size_m = {3, 3};
  deck.ground.colour = {0.02F, 0.02F, 0.02F};  // the full range: rounding to levels is the finder's noise
  deck.ground.grain = 0;
  deck.marks = {mark};
  deck.rigid.position_ned_m = {dice.uniform(-50, 50), dice.uniform(-50, 50), -0.7};
  deck.rigid.ned_from_local = tilted(dice, 0.15);
  scene.decks = {deck};
  const double aside = 0.45 * height_m;
  scene.eye.rigid.position_ned_m =
      deck.rigid.to_ned({dice.uniform(-aside, aside), dice.uniform(-aside, aside), -height_m});
  scene.eye.rigid.ned_from_local = tilted(dice, 0.3);
  return scene;
}

Mark painted(Mark::Shape shape, Dice& dice) {
  Mark mark;
  mark.shape = shape;
  mark.radius_m = 0.5;
  mark.width_m = 0.25;
  mark.center_deck_m = {dice.uniform(-1, 1), dice.uniform(-1, 1)};
  mark.paint.colour = {0.98F, 0.98F, 0.98F};
  mark.paint.grain = 0;
  return mark;
}

std::optional<Outline> outline_of_mark(const Scene& scene) {
  const Deck& deck = scene.decks[0];
  const Vector2d at = deck.marks[0].center_deck_m;
  return outline_of(scene, {deck.rigid.to_ned({at.x(), at.y(), 0}),
                            deck.rigid.ned_from_local * -Vector3d::UnitZ(), deck.marks[0].radius_m});
}

}  // namespace

TEST_CASE("painted edges lie on the outline to 0.02 px at every height, tilt and lens") {
  Renderer renderer(2);
  Dice dice(1, "painted edges");
  int outlines = 0;
  double worst_px = 0, worst_mean_px = 0;
  for (const Distortion distortion : {Distortion::none, Distortion::plumb_bob, Distortion::equidistant})
    for (int i = 0; i < 24; ++i) {
      const double height_m = 1.5 * std::pow(8, i / 23.0);  // to 12 m
      // from higher up a ring's inner edge comes within reach
      const bool ring = i % 2 && height_m < 4;
      const Mark mark = painted(ring ? Mark::Shape::ring : Mark::Shape::disc, dice);
      const Scene scene = scene_of(mark, distortion, height_m, dice);
      const auto outline = outline_of_mark(scene);
      if (!outline || outline->ideal.b_px < 10) continue;
      const Deviation deviation = deviation_of(renderer.render(scene), scene.eye.lens, outline->ideal);
      if (deviation.points < 20) continue;
      ++outlines;
      INFO("height " << height_m << " m, lens " << static_cast<int>(distortion) << ", b "
                     << outline->ideal.b_px << " px");
      CHECK(std::abs(deviation.mean_px) < 0.01);
      CHECK(deviation.worst_px < 0.02);
      worst_px = std::max(worst_px, deviation.worst_px);
      worst_mean_px = std::max(worst_mean_px, std::abs(deviation.mean_px));
    }
  WARN(outlines << " outlines, worst point " << worst_px << " px, worst mean " << worst_mean_px << " px");
  REQUIRE(outlines > 50);
}

TEST_CASE("a bucket's rim lies on its outline") {
  Renderer renderer(2);
  Dice dice(2, "rims");
  int outlines = 0;
  double worst_mean_px = 0;
  for (int i = 0; i < 60; ++i) {
    const double height_m = dice.uniform(1.2, 2.5);
    const Mark disc = painted(Mark::Shape::disc, dice);
    Scene scene = scene_of(disc, Distortion::none, height_m, dice);
    scene.decks[0].marks.clear();
    scene.light.sun = {1, 1, 1};  // from right above: no shadows, and no sky to be hidden at its foot
    scene.light.sky = {0, 0, 0};
    scene.light.to_sun_ned = scene.decks[0].rigid.ned_from_local * -Vector3d::UnitZ();
    Bucket bucket;
    bucket.rigid = scene.decks[0].rigid;
    bucket.rigid.position_ned_m =
        scene.decks[0].rigid.to_ned({dice.uniform(-0.3, 0.3), dice.uniform(-0.3, 0.3), 0});
    bucket.wall_m = 0.05;    // wide enough for an edge of its own
    bucket.handle_rad = pi;  // it hangs down inside
    bucket.outside.colour = {0.98F, 0.98F, 0.98F};
    bucket.outside.grain = 0;
    bucket.inside = bucket.outside;
    scene.buckets = {bucket};
    // no farther aside than the wall leans: the rim is the outermost there is to see all around
    const double aside = 0.06 * scene.decks[0].rigid.to_local(scene.eye.rigid.position_ned_m).z();
    const double up = dice.uniform(1.2, 2.5), y = dice.uniform(-aside, aside),
                 x = dice.uniform(-aside, aside);
    const Vector3d over(x, y, -up);
    scene.eye.rigid.position_ned_m = bucket.rigid.to_ned(over);
    const Vector3d axis = bucket.rigid.ned_from_local * -Vector3d::UnitZ();
    const auto outline =
        outline_of(scene, {bucket.rigid.to_ned({0, 0, -bucket.height_m}), axis, bucket.rim_radius_m});
    if (!outline) continue;
    const Deviation deviation = deviation_of(renderer.render(scene), scene.eye.lens, outline->ideal);
    if (deviation.points < 60) continue;
    ++outlines;
    CHECK(std::abs(deviation.mean_px) < 0.02);
    CHECK(deviation.worst_px < 0.25);  // steps of a sixteenth, and the wire at its hinges
    worst_mean_px = std::max(worst_mean_px, std::abs(deviation.mean_px));
  }
  WARN(outlines << " rims, worst mean " << worst_mean_px << " px");
  REQUIRE(outlines > 8);
}
