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

DetectorSettings paper_settings() {
  DetectorSettings s;
  s.method = "paper";
  return s;
}

struct Scene {
  cv::Mat image;
  Ellipse truth;
};

/// One ellipse, light on dark or dark on light, wholly within the image, with a camera's noise.
Scene random_scene(std::mt19937& random) {
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  const double b = std::exp(between(std::log(5), std::log(60))), a = b * between(1, 2.5);
  const int size = static_cast<int>(2 * a) + 60;
  const Ellipse e =
      normalized({size / 2 + between(-5, 5), size / 2 + between(-5, 5), a, b, between(-pi, pi)});
  const bool light = between(0, 1) < 0.5;
  cv::Mat image = grey_image(size, size, light ? 60 : 200);
  paint(image, e, cv::Scalar::all(light ? 200 : 60));
  add_noise(image, 3, random);
  return {image, e};
}

Detection only(const cv::Mat& image) {
  const auto found = Detector(paper_settings()).detect(image);
  REQUIRE(found.size() == 1);
  return found[0];
}

double angle_between(double x, double y) {
  return std::abs(std::remainder(x - y, pi));
}

void check_near(const Ellipse& e, const Ellipse& expected, double margin_px) {
  CHECK(std::hypot(e.u_px - expected.u_px, e.v_px - expected.v_px) < margin_px);
  CHECK(e.a_px == Approx(expected.a_px).margin(margin_px));
  CHECK(e.b_px == Approx(expected.b_px).margin(margin_px));
  // the ends of the major axis move by a * angle, against b on a near-circle
  const double lever_px = expected.a_px - expected.b_px;
  CHECK(angle_between(e.alpha_rad, expected.alpha_rad) * lever_px < 2 * margin_px);
}

}  // namespace

TEST_CASE("any ellipse is found once, whole, to a fraction of a pixel, with an honest covariance") {
  std::mt19937 random(11);
  double squared_errors = 0;
  constexpr int scenes = 100;
  for (int i = 0; i < scenes; ++i) {
    const Scene scene = random_scene(random);
    const Detection d = only(scene.image);
    CHECK(d.kind == Kind::whole);
    CHECK(d.coverage > 0.95);
    const Ellipse& e = d.outer.ellipse;
    check_near(e, scene.truth, 0.6);
    Eigen::Matrix<double, 5, 1> error;
    error << e.u_px - scene.truth.u_px, e.v_px - scene.truth.v_px, e.a_px - scene.truth.a_px,
        e.b_px - scene.truth.b_px, std::remainder(e.alpha_rad - scene.truth.alpha_rad, pi);
    squared_errors += error.dot(d.outer.covariance.inverse() * error);
  }
  // Five parameters: 5 if the covariance were exact. Contour pixels are no independent measurements, so a
  // factor of two either way.
  CHECK(squared_errors / scenes > 2.5);
  CHECK(squared_errors / scenes < 10);
}

TEST_CASE("the same frame gives the same to the bit") {
  std::mt19937 random(12);
  for (int i = 0; i < 10; ++i) {
    Scene scene = random_scene(random);
    add_noise(scene.image, 25, random);
    const Detector detector(paper_settings());
    const auto first = detector.detect(scene.image), second = detector.detect(scene.image.clone());
    check_same_to_the_bit(first, second);
  }
}

// At a tie between two pixels Canny takes the upper or left one, so up to half a pixel of a short edge may
// move.
TEST_CASE("a transposed frame gives the transposed ellipse") {
  std::mt19937 random(13);
  for (int i = 0; i < 50; ++i) {
    const Scene scene = random_scene(random);
    const Ellipse e = only(scene.image).outer.ellipse;
    check_near(only(scene.image.t()).outer.ellipse,
               normalized({e.v_px, e.u_px, e.a_px, e.b_px, pi / 2 - e.alpha_rad}), 0.4);
  }
}

TEST_CASE("a frame turned by a quarter gives the ellipse turned by a quarter") {
  std::mt19937 random(14);
  for (int i = 0; i < 50; ++i) {
    const Scene scene = random_scene(random);
    const Ellipse e = only(scene.image).outer.ellipse;
    cv::Mat turned;
    cv::rotate(scene.image, turned, cv::ROTATE_90_CLOCKWISE);
    const double last_row = scene.image.rows - 1;
    check_near(only(turned).outer.ellipse,
               normalized({last_row - e.v_px, e.u_px, e.a_px, e.b_px, e.alpha_rad + pi / 2}), 0.4);
  }
}

TEST_CASE("a circle is as large anywhere on the pixel grid") {
  std::mt19937 random(15);
  std::uniform_real_distribution<double> offset(-0.5, 0.5);
  for (int i = 0; i < 40; ++i) {
    cv::Mat image = grey_image(120, 120, 60);
    const Ellipse e{60 + offset(random), 60 + offset(random), 30, 30, 0};
    paint(image, e, cv::Scalar::all(200));
    const Ellipse found = only(image).outer.ellipse;
    CHECK((found.a_px + found.b_px) / 2 == Approx(30).margin(0.2));
    CHECK(std::hypot(found.u_px - e.u_px, found.v_px - e.v_px) < 0.15);
  }
}
