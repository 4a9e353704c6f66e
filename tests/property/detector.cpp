#include "detector_proc/detector.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <numbers>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <random>

#include "tests/support/same_detections.hpp"
#include "tests/unit/detector_scene.hpp"

using namespace stevedore;
using std::numbers::pi;

namespace {

struct Scene {
  cv::Mat image;
  Ellipse truth;
  double contrast, noise, blur_px;
};

/// One ellipse, light on dark or dark on light, wholly within the image.
Scene random_scene(std::mt19937& random, double noise) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const double b = std::exp(between(std::log(9), std::log(60))), a = b * between(1, 2.5);
  const int size = static_cast<int>(2 * a) + 60;
  const Ellipse e =
      normalized({size / 2 + between(-5, 5), size / 2 + between(-5, 5), a, b, between(-pi, pi)});
  const bool light = between(0, 1) < 0.5;
  cv::Mat image = grey_image(size, size, light ? 60 : 200);
  paint(image, e, cv::Scalar::all(light ? 200 : 60));
  const double blur_px = between(0.4, 1);
  cv::GaussianBlur(image, image, {0, 0}, blur_px);
  if (noise > 0) add_noise(image, noise, random);
  return {image, e, 140, noise, blur_px};
}

Detection only(const cv::Mat& image, int strips = 48) {
  DetectorSettings settings;
  settings.subpixel_strips = strips;
  const auto found = Detector(settings).detect(image);
  REQUIRE(found.size() == 1);
  return found[0];
}

void check_near(const Ellipse& e, const Ellipse& expected, double margin_px) {
  CHECK(std::hypot(e.u_px - expected.u_px, e.v_px - expected.v_px) < margin_px);
  CHECK(e.a_px == Approx(expected.a_px).margin(margin_px));
  CHECK(e.b_px == Approx(expected.b_px).margin(margin_px));
  // the ends of the major axis move by a * angle, against b on a near-circle
  const double lever_px = expected.a_px - expected.b_px;
  CHECK(std::abs(std::remainder(e.alpha_rad - expected.alpha_rad, pi)) * lever_px < 2 * margin_px);
}

/// Cramer-Rao bound of the five parameters: every unit of edge length gives the place of a step of this
/// contrast under this blur and white noise of one value a pixel with variance noise^2 2 sqrt(pi) blur /
/// contrast^2.
EllipseCovariance bound_of(const Scene& scene) {
  const Ellipse& e = scene.truth;
  const double blur_px = std::sqrt(scene.blur_px * scene.blur_px + 1.0 / 12);
  const double variance =
      scene.noise * scene.noise * 2 * std::sqrt(pi) * blur_px / (scene.contrast * scene.contrast);
  EllipseCovariance information = EllipseCovariance::Zero();
  constexpr int count = 720;
  for (int k = 0; k < count; ++k) {
    const double t = 2 * pi * k / count, c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad);
    const Eigen::Vector2d major(c, s), minor(-s, c);
    const double x = e.a_px * std::cos(t), y = e.b_px * std::sin(t);
    const Eigen::Vector2d outwards = e.b_px * std::cos(t) * major + e.a_px * std::sin(t) * minor;
    const Eigen::Vector2d normal = outwards.normalized();
    Eigen::Matrix<double, 5, 1> row;
    row << normal, normal.dot(major) * std::cos(t), normal.dot(minor) * std::sin(t),
        normal.dot(x * minor - y * major);
    information += row * row.transpose() * outwards.norm() * 2 * pi / count / variance;
  }
  return information.inverse();
}

Eigen::Matrix<double, 5, 1> error_of(const Ellipse& e, const Ellipse& truth) {
  Eigen::Matrix<double, 5, 1> error;
  error << e.u_px - truth.u_px, e.v_px - truth.v_px, e.a_px - truth.a_px, e.b_px - truth.b_px,
      std::remainder(e.alpha_rad - truth.alpha_rad, pi);
  return error;
}

}  // namespace

TEST_CASE("without noise any ellipse is found once, whole, to three hundredths of a pixel") {
  std::mt19937 random(31);
  double bias_px = 0;
  constexpr int scenes = 60;
  for (int i = 0; i < scenes; ++i) {
    const Scene scene = random_scene(random, 0);
    const Detection d = only(scene.image);
    CHECK(d.kind == Kind::whole);
    check_near(d.outer.ellipse, scene.truth, 0.05);
    bias_px +=
        (d.outer.ellipse.a_px + d.outer.ellipse.b_px - scene.truth.a_px - scene.truth.b_px) / 2 / scenes;
  }
  CHECK(std::abs(bias_px) < 0.01);
}

TEST_CASE("under noise errors are within twice the Cramer-Rao bound, and the covariance is honest") {
  std::mt19937 random(32);
  double over_bound = 0, over_covariance = 0;
  constexpr int scenes = 60;
  for (int i = 0; i < scenes; ++i) {
    const Scene scene = random_scene(random, 5);
    const Detection d = only(scene.image, 0);
    const auto error = error_of(d.outer.ellipse, scene.truth);
    over_bound += error.dot(bound_of(scene).inverse() * error) / 5 / scenes;
    over_covariance += error.dot(d.outer.covariance.inverse() * error) / 5 / scenes;
  }
  CHECK(over_bound < 4);         // of squares
  CHECK(over_covariance > 0.3);  // 1 if it were exact; a factor of two of the deviation either way
  CHECK(over_covariance < 4);
}

TEST_CASE("the same frame gives the same to the bit, after any other") {
  std::mt19937 random(33);
  const Detector used;
  for (int i = 0; i < 10; ++i) {
    const Scene scene = random_scene(random, 25);
    const auto first = Detector().detect(scene.image), second = used.detect(scene.image.clone());
    check_same_to_the_bit(first, second);
  }
}

TEST_CASE("transposed, turned by a quarter, inverted and scaled in brightness it is the same ellipse") {
  std::mt19937 random(34);
  for (int i = 0; i < 30; ++i) {
    const Scene scene = random_scene(random, 1);
    const Ellipse e = only(scene.image).outer.ellipse;
    constexpr double margin_px = 0.06;  // 48 strips start elsewhere on the edge
    check_near(only(scene.image.t()).outer.ellipse,
               normalized({e.v_px, e.u_px, e.a_px, e.b_px, pi / 2 - e.alpha_rad}), margin_px);
    cv::Mat turned;
    cv::rotate(scene.image, turned, cv::ROTATE_90_CLOCKWISE);
    check_near(only(turned).outer.ellipse,
               normalized({scene.image.rows - 1 - e.v_px, e.u_px, e.a_px, e.b_px, e.alpha_rad + pi / 2}),
               margin_px);
    check_near(only(255 - scene.image).outer.ellipse, e, margin_px);
    check_near(only(scene.image * 0.5).outer.ellipse, e, margin_px);
  }
}

TEST_CASE("an ellipse of which a third is hidden is found where it is") {
  std::mt19937 random(35);
  for (int i = 0; i < 40; ++i) {
    Scene scene = random_scene(random, 3);
    const Ellipse& e = scene.truth;
    if (e.b_px < 15) continue;
    const double from = std::uniform_real_distribution<double>(0, 2 * pi)(random);
    std::vector<cv::Point> occluder;
    for (const double t : {from, from + 2 * pi / 3}) {
      const Eigen::Vector2d p = point_at({e.u_px, e.v_px, 2 * e.a_px, 2 * e.b_px, e.alpha_rad}, t);
      occluder.emplace_back(static_cast<int>(p.x()), static_cast<int>(p.y()));
    }
    const Eigen::Vector2d far =
        point_at({e.u_px, e.v_px, 4 * e.a_px, 4 * e.b_px, e.alpha_rad}, from + pi / 3);
    occluder.emplace_back(static_cast<int>(far.x()), static_cast<int>(far.y()));
    cv::fillPoly(scene.image, std::vector{occluder}, cv::Scalar::all(125));
    const auto found = Detector().detect(scene.image);
    REQUIRE(found.size() >= 1);
    check_near(found[0].outer.ellipse, e, std::max(0.3, 0.02 * e.a_px));
  }
}
