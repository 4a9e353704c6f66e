// A mark that is about where it is expected: what profiles across it settle, and what they leave to a search
// of the neighbourhood.
#include "detector_proc/expected_mark.hpp"

#include <catch2/catch.hpp>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "detector_proc/detector.hpp"
#include "tests/unit/detector_scene.hpp"

using namespace stevedore;

namespace {

constexpr double ring_ratio = 0.8;

Ellipse scaled(Ellipse e, double by) {
  e.a_px *= by, e.b_px *= by;
  return e;
}

/// As motion and another view leave it from one frame to the next.
Detection expected_of(const Ellipse& e, bool ring) {
  Detection d;
  d.outer.ellipse = {e.u_px + 0.15 * e.b_px, e.v_px - 0.1 * e.b_px, 1.06 * e.a_px, 1.06 * e.b_px,
                     e.alpha_rad + 0.03};
  if (ring) d.inner = EllipseFit{scaled(d.outer.ellipse, ring_ratio), EllipseCovariance::Zero()};
  d.label = Label::circle;
  return d;
}

double furthest_px(const Ellipse& a, const Ellipse& b) {
  double furthest = 0;
  for (int k = 0; k < 16; ++k) {
    const double t = std::numbers::pi * k / 8;
    const double radius = std::sqrt(normalized_radius_squared(b, point_at(a, t)));
    furthest = std::max(furthest, std::abs(radius - 1) * b.a_px);
  }
  return furthest;
}

}  // namespace

TEST_CASE("an expected mark is found by profiles alone: either contrast, ring or disc, small or large") {
  std::mt19937 random(5);
  for (const double size_px : {12.0, 30.0, 75.0}) {
    for (const bool ring : {false, true}) {
      for (const int paint_level : {20, 215}) {
        const Ellipse e{161.3, 118.7, 1.3 * size_px, size_px, 0.4};
        cv::Mat image = grey_image(320, 240, 120);
        paint(image, e, cv::Scalar::all(paint_level));
        if (ring) paint(image, scaled(e, ring_ratio), cv::Scalar::all(120));
        add_noise(image, 4, random);
        const auto found = find_expected(image, expected_of(e, ring), {}, {});
        INFO("size " << size_px << ", ring " << ring << ", paint " << paint_level);
        REQUIRE(found);
        CHECK(furthest_px(found->outer.ellipse, e) < 0.25);  // 3 deviations of the smallest one's ends
        CHECK(found->outer.covariance(0, 0) < 0.01);
        CHECK(found->label == Label::circle);
        CHECK(found->inner.has_value() == ring);
        if (ring) CHECK(furthest_px(found->inner->ellipse, scaled(e, ring_ratio)) < 0.25);
        CHECK(found->occupied != true);
        if (size_px > 20) CHECK(found->occupied == false);  // a rim in a smaller one is lost in the noise
      }
    }
  }
}

TEST_CASE("an expected mark in colour is as in grey, and cut by the border it is partial") {
  const Ellipse e{4, 118, 60, 52, 0.3};
  cv::Mat image(240, 320, CV_8UC3, cv::Scalar(70, 90, 80));
  paint(image, e, cv::Scalar(210, 225, 230));
  const auto found = find_expected(image, expected_of(e, false), {}, {});
  REQUIRE(found);
  CHECK(furthest_px(found->outer.ellipse, e) < 1);  // on the side that is out of view
  CHECK(found->kind == Kind::partial);
}

TEST_CASE("a mark of which half is hidden is found where it is expected") {
  const Ellipse e{160, 120, 60, 52, 0.3};
  cv::Mat image = grey_image(320, 240, 60);
  paint(image, e, cv::Scalar::all(200));
  for (int k = 0; k < 11; ++k)  // planks over half of it
    cv::line(image, {20 + 24 * k, 0}, {60 + 24 * k, 112}, cv::Scalar::all(k % 2 ? 20 : 235), 12);
  const auto found = Detector().detect_near(image, expected_of(e, false));
  REQUIRE(found);
  CHECK(furthest_px(found->outer.ellipse, e) < 1.5);
}

TEST_CASE("what colour alone shows is not on profiles of light, but in its neighbourhood") {
  const Ellipse e{160, 120, 60, 52, 0.3};
  cv::Mat image(240, 320, CV_8UC3, cv::Scalar(70, 90, 80));
  paint(image, e, cv::Scalar(60, 60, 145));  // luminance 85, as the ground's
  CHECK_FALSE(find_expected(image, expected_of(e, false), {}, {}));
  const auto found = Detector().detect_near(image, expected_of(e, false));
  REQUIRE(found);
  CHECK(furthest_px(found->outer.ellipse, e) < 0.5);
}

TEST_CASE("a circle full of texture, or of noise of any strength, is not told to be empty") {
  const Ellipse e{160, 120, 60, 52, 0.3};
  std::mt19937 random(11);
  for (const double noise : {30.0, 60.0, 120.0}) {
    cv::Mat image = grey_image(320, 240, 60), texture = grey_image(320, 240, 200), inside;
    paint(image, e, cv::Scalar::all(200));
    add_noise(texture, noise, random);
    inside = grey_image(320, 240, 0);
    paint(inside, scaled(e, 0.8), cv::Scalar::all(255));
    texture.copyTo(image, inside > 254);
    for (int k = 0; k < 6; ++k)
      cv::line(image, {120 + 16 * k, 90}, {110 + 16 * k, 150}, cv::Scalar::all(0), 3);
    const auto found = Detector().detect_near(image, expected_of(e, false));
    if (found) CHECK(found->occupied != false);
  }
}

TEST_CASE("what is not there is not found where it is expected") {
  const Ellipse e{160, 120, 60, 52, 0.3};
  cv::Mat nothing = grey_image(320, 240, 60);
  std::mt19937 random(7);
  for (const double noise : {0.0, 5.0, 40.0}) {
    add_noise(nothing, noise, random);
    CHECK_FALSE(Detector().detect_near(nothing, expected_of(e, true)));
  }
  for (const cv::Size size : {cv::Size(1, 1), cv::Size(3, 200), cv::Size(40, 9)})
    CHECK_FALSE(Detector().detect_near(cv::Mat(size, CV_8UC3, cv::Scalar::all(90)), expected_of(e, true)));
}

TEST_CASE("a circle further off than its prediction may be is another") {
  const Ellipse e{160, 120, 40, 36, 0.3};
  cv::Mat image = grey_image(320, 240, 60);
  paint(image, e, cv::Scalar::all(200));
  Detection expected = expected_of(e, false);
  expected.outer.ellipse.u_px = e.u_px + 0.7 * e.b_px;
  CHECK_FALSE(Detector().detect_near(image, expected));
}
