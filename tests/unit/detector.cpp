#include "detector_proc/detector.hpp"
#include "detector_proc/colour_planes.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "detector_proc/colour_planes.hpp"
#include "detector_proc/conic_sums.hpp"
#include "detector_proc/edge_thresholds.hpp"
#include "detector_proc/gradient_field.hpp"
#include "geometry/camera_model.hpp"
#include "tests/unit/detector_scene.hpp"

using namespace stevedore;
using std::numbers::pi;

namespace {

cv::Mat disc_scene(const Ellipse& e) {
  cv::Mat image = grey_image(320, 240, 60);
  paint(image, e, cv::Scalar::all(220));
  return image;
}

EdgePoint edge_point_at(const Ellipse& e, double t) {
  const Eigen::Vector2d p = point_at(e, t), ahead = point_at(e, t + 1e-4) - p;
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(ahead.x() / ahead.norm()),
          static_cast<float>(ahead.y() / ahead.norm())};
}

ConicSums sums_over(const Ellipse& e, double from, double to, const FitFrame& frame) {
  ConicSums sums;
  for (double t = from; t < to; t += 0.02) sums.add(edge_point_at(e, t), frame, 1, 3);
  return sums;
}

void check_near(const Ellipse& e, const Ellipse& expected, double margin) {
  CHECK(e.u_px == Approx(expected.u_px).margin(margin));
  CHECK(e.v_px == Approx(expected.v_px).margin(margin));
  CHECK(e.a_px == Approx(expected.a_px).margin(margin));
  CHECK(e.b_px == Approx(expected.b_px).margin(margin));
  CHECK(std::abs(std::remainder(e.alpha_rad - expected.alpha_rad, pi)) * (e.a_px - e.b_px) < 2 * margin);
}

}  // namespace

TEST_CASE("gradient: a sharp step of n levels reads 48 n, in its direction, up to the border") {
  for (const bool transposed : {false, true}) {
    cv::Mat image = grey_image(40, 30, 50);
    image.colRange(20, 40).setTo(150);
    if (transposed) image = image.t();
    GradientField field;
    compute_gradient(image, field);
    const auto at = [&](int along, int across) {
      return transposed ? field.gradient.at<cv::Vec2s>(across, along)
                        : field.gradient.at<cv::Vec2s>(along, across);
    };
    for (const int along : {0, 1, 15, 29}) {
      CHECK(std::max(at(along, 19)[transposed ? 1 : 0], at(along, 20)[transposed ? 1 : 0]) == 4800);
      CHECK(at(along, 19)[transposed ? 0 : 1] == 0);
      CHECK(at(along, 10) == cv::Vec2s(0, 0));
    }
  }
}

TEST_CASE("gradient: every pixel as the formula has it, whatever the width leaves over for vectors") {
  std::mt19937 random(21);
  for (const cv::Size size :
       {cv::Size(1, 1), cv::Size(3, 2), cv::Size(7, 9), cv::Size(8, 8), cv::Size(37, 11)}) {
    cv::Mat image = grey_image(size.width, size.height, 128);
    add_noise(image, 60, random);
    GradientField field;
    compute_gradient(image, field);
    const cv::Mat across = (cv::Mat_<double>(5, 1) << 1, 4, 6, 4, 1),
                  along = (cv::Mat_<double>(5, 1) << -1, -2, 0, 2, 1);
    cv::Mat expected;
    cv::sepFilter2D(image, expected, CV_16S, along, across, {-1, -1}, 0, cv::BORDER_REPLICATE);
    for (int v = 0; v < size.height; ++v) {
      for (int u = 0; u < size.width; ++u)
        CHECK(field.gradient.at<cv::Vec2s>(v, u)[0] == expected.at<short>(v, u));
    }
  }
}

TEST_CASE(
    "opponent colours: every pixel as the formulas have it, whatever the width leaves over for vectors") {
  cv::Mat image(7, 83, CV_8UC3);
  cv::RNG(3).fill(image, cv::RNG::UNIFORM, 0, 256);
  const auto opponent = [](std::size_t which, double blue, double green, double red) {
    return which == 0 ? 128 + (red - green) / 2 : 128 + (2 * blue - green - red) / 4;
  };
  std::array<cv::Mat, Opponents::count> halved;
  compute_halved_opponents(image, halved);
  for (std::size_t which = 0; which < Opponents::count; ++which) {
    cv::Mat plane;
    compute_opponent(image, which, plane);
    REQUIRE(plane.size() == image.size());
    for (int v = 0; v < image.rows; ++v)
      for (int u = 0; u < image.cols; ++u) {
        const auto& p = image.at<cv::Vec3b>(v, u);
        REQUIRE(plane.at<uchar>(v, u) == std::floor(opponent(which, p[0], p[1], p[2])));
      }
    REQUIRE(halved[which].size() == cv::Size(41, 3));
    for (int v = 0; v < 3; ++v)
      for (int u = 0; u < 41; ++u) {
        const cv::Scalar mean = cv::mean(image(cv::Rect(2 * u, 2 * v, 2, 2)));
        REQUIRE(std::abs(halved[which].at<uchar>(v, u) - opponent(which, mean[0], mean[1], mean[2])) <= 0.5);
      }
  }
}

TEST_CASE("thresholds rise with the noise, not with the edges") {
  GradientField field;
  const cv::Mat clean = disc_scene({160, 120, 60, 35, 0.5});
  compute_gradient(clean, field);
  const EdgeThresholds quiet = edge_thresholds(field);
  cv::Mat noisy = clean.clone();
  std::mt19937 random(22);
  add_noise(noisy, 15, random);
  compute_gradient(noisy, field);
  CHECK(edge_thresholds(field).start > 5 * quiet.start);
  CHECK(quiet.start < 10 * GradientField::step_response);
}

TEST_CASE("conic sums: an ellipse from all of its points, from an arc, and from two arcs added") {
  const FitFrame frame{320, 240, 320};
  for (const Ellipse& e :
       {Ellipse{100, 90, 50, 30, 0.7}, Ellipse{500, 400, 12, 9, -1.2}, Ellipse{320, 240, 200, 199, 0}}) {
    check_near(sums_over(e, 0, 2 * pi, frame).solve(frame).value(), e, 0.02);
    check_near(sums_over(e, 0.5, 2.5, frame).solve(frame).value(), e, 0.1);
    ConicSums two = sums_over(e, 0, 0.6, frame);
    two.add(sums_over(e, 3, 3.6, frame));
    check_near(two.solve(frame).value(), e, 0.1);
  }
  CHECK_FALSE(ConicSums().solve(frame));
}

TEST_CASE("a disc is one whole circle with nothing in it, to a hundredth of a pixel") {
  const Ellipse e{160.3, 119.8, 60, 35, 0.5};
  const auto found = Detector().detect(disc_scene(e));
  REQUIRE(found.size() == 1);
  const Detection& d = found[0];
  CHECK(d.kind == Kind::whole);
  CHECK(d.label == Label::circle);
  CHECK(d.occupied == false);
  CHECK_FALSE(d.inner);
  CHECK(d.coverage > 0.97);
  CHECK(d.error < 0.02);
  check_near(d.outer.ellipse, e, 0.02);
}

TEST_CASE("a ring is one mark: its outer edge, with the inner one beside it") {
  for (const int width : {5, 9, 18, 28}) {
    for (const int paint_level : {220, 10}) {
      INFO(width << " px wide, level " << paint_level);
      const Ellipse outer{160, 120, 80, 60, -0.4}, inner{160, 120, 80.0 - width, 60 - 0.75 * width, -0.4};
      cv::Mat image = grey_image(320, 240, 110);
      paint(image, outer, cv::Scalar::all(paint_level));
      paint(image, inner, cv::Scalar::all(110));
      const auto found = Detector().detect(image);
      REQUIRE(found.size() == 1);
      check_near(found[0].outer.ellipse, outer, 0.1);
      REQUIRE(found[0].inner);
      check_near(found[0].inner->ellipse, inner, 0.1);
      CHECK(found[0].label == Label::circle);
      CHECK(found[0].occupied == false);
    }
  }
}

TEST_CASE("a bucket in a ring is a cargo, and the ring is occupied") {
  cv::Mat image = grey_image(320, 240, 60);
  paint(image, {160, 120, 80, 70, 0}, cv::Scalar::all(220));
  paint(image, {160, 120, 64, 56, 0}, cv::Scalar::all(60));
  paint(image, {170, 115, 25, 22, 0}, cv::Scalar::all(160));
  const auto found = Detector().detect(image);
  REQUIRE(found.size() == 2);
  CHECK(found[0].label == Label::circle);
  CHECK(found[0].inner);
  CHECK(found[0].occupied == true);
  CHECK(found[1].label == Label::cargo);
  CHECK_FALSE(found[1].occupied);
  check_near(found[1].outer.ellipse, {170, 115, 25, 22, 0}, 0.1);
}

TEST_CASE("a camera's focal length tells a rim's outer edge from its inner one") {
  // 80 px of 320: four radii below the camera, a rim 0.6 nearer: 0.32 * 4 / 3.4 of the circle
  const Ellipse rim{175, 118, 30.1, 30.1, 0};
  cv::Mat image = grey_image(320, 240, 60);
  paint(image, {160, 120, 80, 80, 0}, cv::Scalar::all(220));
  paint(image, {160, 120, 64, 64, 0}, cv::Scalar::all(60));
  paint(image, rim, cv::Scalar::all(240));
  paint(image, {175, 118, 27, 27, 0}, cv::Scalar::all(20));
  Optics optics;
  optics.focal_px = 320;
  optics.width_px = 320;
  const auto found = Detector({}, optics).detect(image);
  const auto cargo =
      std::find_if(found.begin(), found.end(), [](const Detection& d) { return d.label == Label::cargo; });
  REQUIRE(cargo != found.end());
  check_near(cargo->outer.ellipse, rim, 1);
  CHECK(found[0].occupied == true);
}

TEST_CASE("a cargo's other edges are the cargo, and no marks of their own") {
  // a dull rim around what is bright: the arcs find its inner edge, the search for rims the outer one
  cv::Mat image(240, 320, CV_8UC3, cv::Scalar::all(60));
  paint(image, {160, 120, 80, 80, 0}, cv::Scalar::all(220));
  paint(image, {160, 120, 64, 64, 0}, cv::Scalar::all(60));
  paint(image, {175, 118, 30.1, 30.1, 0}, cv::Scalar(40, 60, 60));
  paint(image, {175, 118, 27, 27, 0}, cv::Scalar(10, 20, 200));
  paint(image, {183, 127, 14, 14, 0}, cv::Scalar(200, 200, 200));  // its bottom, seen from the side
  cv::GaussianBlur(image, image, {}, 0.8);
  Optics optics;
  optics.focal_px = 320;
  optics.width_px = 320;
  const auto found = Detector({}, optics).detect(image);
  REQUIRE(found.size() == 2);
  CHECK(found[0].label == Label::circle);
  CHECK(found[1].label == Label::cargo);
}

TEST_CASE("where a rim is cut by the border what only the search finds is known to half a radius") {
  Optics optics;
  optics.focal_px = 320;
  optics.width_px = 320;
  const auto deviation_px = [&](int rows) {
    cv::Mat image(240, 320, CV_8UC3, cv::Scalar::all(60));
    paint(image, {160, 120, 80, 80, 0}, cv::Scalar::all(220));
    paint(image, {160, 120, 64, 64, 0}, cv::Scalar::all(60));
    paint(image, {165, 155, 30.1, 30.1, 0}, cv::Scalar(40, 60, 60));
    paint(image, {165, 155, 27, 27, 0}, cv::Scalar(10, 20, 200));
    cv::GaussianBlur(image, image, {}, 0.8);
    const auto found = Detector({}, optics).detect(image.rowRange(0, rows).clone());
    const auto cargo =
        std::find_if(found.begin(), found.end(), [](const Detection& d) { return d.label == Label::cargo; });
    REQUIRE(cargo != found.end());
    return std::sqrt(cargo->outer.covariance(0, 0));
  };
  CHECK(deviation_px(240) < 1);
  CHECK(deviation_px(163) > 0.3 * 30.1);
}

TEST_CASE("an ellipse in a circle that no parallel circle looks like is no cargo") {
  cv::Mat image = disc_scene({160, 120, 80, 75, 0});
  paint(image, {160, 120, 40, 16, 0.5}, cv::Scalar::all(60));
  const auto found = Detector().detect(image);
  REQUIRE(found.size() == 2);
  CHECK(found[0].label == Label::circle);
  CHECK(found[0].occupied == false);
  CHECK(found[1].label == Label::unknown);
}

TEST_CASE("a line across a circle is no cargo") {
  cv::Mat image = disc_scene({160, 120, 80, 70, 0});
  cv::line(image, {130, 120}, {190, 120}, cv::Scalar::all(40), 9);
  const auto found = Detector().detect(image);
  REQUIRE(found.size() == 1);
  CHECK(found[0].label == Label::circle);
  CHECK(found[0].occupied == false);
}

TEST_CASE(
    "a ring painted in a circle, of the ground's colour or the paint's, is no cargo, though as large as a "
    "rim") {
  const cv::Scalar ground(70, 90, 80), white(220, 225, 230), blue(190, 80, 40);
  Optics camera;  // as above: a rim would be 0.38 of the circle
  camera.focal_px = 320;
  camera.width_px = 320;
  for (const Optics& optics : {Optics(), camera}) {
    for (const bool disc : {true, false}) {
      for (const cv::Scalar& stroke : {ground, blue}) {
        cv::Mat image(240, 320, CV_8UC3, ground);
        paint(image, {160, 120, 80, 76, 0.3}, white);
        if (!disc) paint(image, {160, 120, 64, 61, 0.3}, ground);
        paint(image, {160, 120, 30.1, 28.6, 0.3}, stroke == ground && !disc ? white : stroke);
        paint(image, {160, 120, 24, 22.8, 0.3}, disc ? white : ground);
        const auto found = Detector({}, optics).detect(image);
        INFO((disc ? "disc" : "ring") << ", stroke " << stroke[0] << ", focal length " << optics.focal_px);
        REQUIRE(!found.empty());
        CHECK(found[0].label == Label::circle);
        CHECK(found[0].occupied == false);
        for (const Detection& d : found) CHECK(d.label != Label::cargo);
      }
    }
  }
}

TEST_CASE("a stripe that goes through a painted ring is no cargo, whatever its width") {
  const cv::Scalar ground(80, 75, 70), orange(60, 120, 200), white(215, 220, 220);
  Optics camera;  // as above
  camera.focal_px = 320;
  camera.width_px = 320;
  for (const int width_px : {12, 24, 36}) {
    cv::Mat image(240, 320, CV_8UC3, ground);
    paint(image, {160, 120, 80, 76, 0.3}, orange);
    paint(image, {160, 120, 62, 59, 0.3}, ground);
    paint(image, {160, 120, 30.1, 28.6, 0.3}, orange);
    paint(image, {160, 120, 24, 22.8, 0.3}, ground);
    cv::line(image, {60, 200}, {260, 40}, white, width_px, cv::LINE_AA);
    cv::GaussianBlur(image, image, {}, 0.8);
    const auto found = Detector({}, camera).detect(image);
    INFO(width_px);
    REQUIRE(!found.empty());
    CHECK(found[0].label == Label::circle);
    CHECK_FALSE(found[0].occupied == true);
    for (const Detection& d : found) CHECK(d.label != Label::cargo);
  }
}

TEST_CASE("a cargo off the middle of a disc, half in shadow, with its handle, is seen") {
  cv::Mat image(240, 320, CV_8UC3, cv::Scalar(70, 90, 80));
  paint(image, {160, 120, 80, 76, 0}, cv::Scalar(40, 170, 220));
  const Ellipse rim{190, 110, 28, 26.6, 0};
  paint(image, rim, cv::Scalar(150, 60, 40));
  paint(image, {190, 110, 24, 22.8, 0}, cv::Scalar(70, 30, 20));
  paint(image, {184, 104, 14, 13, 0}, cv::Scalar(120, 50, 30));
  cv::line(image, {163, 112}, {217, 108}, cv::Scalar::all(200), 2);
  const auto found = Detector().detect(image);
  REQUIRE(found.size() >= 2);
  CHECK(found[0].label == Label::circle);
  CHECK(found[0].occupied == true);
  const auto cargo =
      std::find_if(found.begin(), found.end(), [](const Detection& d) { return d.label == Label::cargo; });
  REQUIRE(cargo != found.end());
  CHECK(std::hypot(cargo->outer.ellipse.u_px - rim.u_px, cargo->outer.ellipse.v_px - rim.v_px) < 3);
  CHECK(cargo->outer.ellipse.a_px == Approx(rim.a_px).epsilon(0.2));
}

TEST_CASE("of a circle of which a third is out of view there is no telling that it is empty") {
  cv::Mat image(240, 320, CV_8UC3, cv::Scalar(70, 90, 80));
  paint(image, {22, 120, 80, 76, 0}, cv::Scalar(40, 170, 220));
  const auto found = Detector().detect(image);
  REQUIRE(found.size() == 1);
  CHECK_FALSE(found[0].occupied);
}

TEST_CASE("what is too little of an ellipse by itself is found beside one of its size") {
  const auto count_with_sibling = [](double a, double b) {
    cv::Mat image = disc_scene({100, 120, a, b, 0.3});
    // three pieces of worn paint, together a quarter of the edge
    cv::Mat worn = grey_image(320, 240, 60);
    paint(worn, {220, 120, 40, 36, 0.3}, cv::Scalar::all(220));
    for (const double from : {0.4, 2.5, 4.6}) {
      std::vector<cv::Point> sector{{220, 120}};
      for (double t = from; t <= from + 0.6; t += 0.05)
        sector.emplace_back(220 + static_cast<int>(60 * std::cos(t)),
                            120 + static_cast<int>(60 * std::sin(t)));
      cv::Mat mask = grey_image(320, 240, 0);
      cv::fillPoly(mask, std::vector{sector}, cv::Scalar::all(255));
      worn.copyTo(image, mask);
    }
    return Detector().detect(image);
  };
  const auto alone = count_with_sibling(60, 25);
  REQUIRE(alone.size() == 1);
  const auto found = count_with_sibling(40, 36);
  REQUIRE(found.size() == 2);
  const Detection& worn = found[found[0].outer.ellipse.u_px > 160 ? 0 : 1];
  check_near(worn.outer.ellipse, {220, 120, 40, 36, 0.3}, 1);
  CHECK(worn.coverage < 0.6);
}

TEST_CASE("an ellipse cut by the border is found, as partial, and says what it does not know") {
  const Ellipse e{20, 120, 70, 50, 0.2};
  const auto found = Detector().detect(disc_scene(e));
  REQUIRE(found.size() == 1);
  CHECK(found[0].kind == Kind::partial);
  CHECK(found[0].coverage < 0.8);
  check_near(found[0].outer.ellipse, e, 0.2);
  const auto whole = Detector().detect(disc_scene({160, 120, 70, 50, 0.2}));
  REQUIRE(whole.size() == 1);
  CHECK(found[0].outer.covariance(2, 2) > 2 * whole[0].outer.covariance(2, 2));
}

TEST_CASE("an ellipse hidden in part is found") {
  for (const int first_column : {150, 170, 190}) {
    cv::Mat image = disc_scene({160, 120, 70, 50, 0});
    cv::rectangle(image, cv::Rect(first_column, 50, 150, 140), cv::Scalar::all(120), cv::FILLED);
    const auto found = Detector().detect(image);
    REQUIRE(found.size() == 1);
    CHECK(found[0].kind == Kind::partial);
    check_near(found[0].outer.ellipse, {160, 120, 70, 50, 0}, 1);
  }
}

TEST_CASE("polygons and lines are no ellipses") {
  cv::Mat image = grey_image(320, 240, 60);
  cv::rectangle(image, cv::Rect(20, 20, 80, 60), cv::Scalar::all(220), cv::FILLED);
  cv::fillPoly(image, std::vector<std::vector<cv::Point>>{{{200, 30}, {290, 90}, {180, 120}}},
               cv::Scalar::all(200));
  cv::line(image, {10, 200}, {310, 160}, cv::Scalar::all(255), 3);
  CHECK(Detector().detect(image).empty());
}

TEST_CASE("the camera's response sets the edge right: levels of a gamma lie outwards on bright paint") {
  // coverage of pixels in light, as levels of an sRGB camera
  const Ellipse e{160.3, 119.8, 60, 35, 0.5};
  cv::Mat light = grey_image(320, 240, 0), image = light.clone();
  paint(light, e, cv::Scalar::all(255));
  const auto curve = linear_light({Response::Curve::srgb, 1});
  for (int v = 0; v < image.rows; ++v) {
    for (int u = 0; u < image.cols; ++u) {
      const float share = static_cast<float>(light.at<uchar>(v, u)) / 255;
      const auto level = std::lower_bound(curve.begin(), curve.end(), share * curve[200]);
      image.at<uchar>(v, u) = static_cast<uchar>(level - curve.begin());
    }
  }
  const auto as_levels = Detector().detect(image), as_light = Detector({}, Optics{curve, 0, 0}).detect(image);
  REQUIRE(as_levels.size() == 1);
  REQUIRE(as_light.size() == 1);
  CHECK(as_levels[0].outer.ellipse.b_px > e.b_px + 0.1);
  check_near(as_light[0].outer.ellipse, e, 0.03);
}

TEST_CASE("a grey image and the same in colour give the same") {
  const cv::Mat grey = disc_scene({160, 120, 60, 35, 0.5});
  cv::Mat color;
  cv::cvtColor(grey, color, cv::COLOR_GRAY2BGR);
  const auto a = Detector().detect(grey), b = Detector().detect(color);
  REQUIRE(a.size() == 1);
  REQUIRE(b.size() == 1);
  CHECK(a[0].outer.ellipse.a_px == Approx(b[0].outer.ellipse.a_px).margin(1e-4));
}

TEST_CASE("thin rings as light as their ground are found by their colour, and where they are") {
  std::mt19937 random(5);
  const cv::Scalar grey = cv::Scalar::all(128), red(56, 95, 220), blue(255, 105, 125);  // luminance 128
  for (const cv::Scalar& colour : {red, blue}) {
    cv::Mat image(480, 640, CV_8UC3, grey);
    const Ellipse first{120.3, 300.8, 15.7, 15.4, 0.4}, second{170.6, 310.2, 15.6, 15.3, 0.4};
    for (const Ellipse& e : {first, second}) {
      paint(image, e, colour);
      paint(image, {e.u_px, e.v_px, 0.74 * e.a_px, 0.74 * e.b_px, e.alpha_rad}, grey);
    }
    cv::GaussianBlur(image, image, {0, 0}, 0.7);
    add_noise(image, 3, random);
    const auto found = Detector().detect(image);
    INFO("blue " << colour[0]);
    REQUIRE(found.size() == 2);
    for (const Detection& d : found) {
      const Ellipse& e = d.outer.ellipse;
      const Ellipse& truth = e.u_px < 145 ? first : second;
      CHECK(d.label == Label::circle);
      CHECK(std::hypot(e.u_px - truth.u_px, e.v_px - truth.v_px) < 0.3);
      CHECK(e.b_px == Approx(truth.b_px).margin(0.3));
    }
  }
}

TEST_CASE("a region search tells that a circle is empty, and leaves what stands in it to whole frames") {
  const Ellipse circle{160, 120, 80, 76, 0};
  cv::Mat image(240, 320, CV_8UC3, cv::Scalar(70, 90, 80));
  paint(image, circle, cv::Scalar(220, 225, 230));
  const Detector detector;
  Detection expected;
  expected.outer.ellipse = {164, 118, 82, 78, 0};
  expected.label = Label::circle;
  const auto empty = detector.detect_near(image, expected);
  REQUIRE(empty);
  CHECK(empty->occupied == false);
  paint(image, {180, 110, 28, 26.6, 0}, cv::Scalar(150, 60, 40));
  const auto occupied = detector.detect_near(image, expected);
  REQUIRE(occupied);
  CHECK(occupied->occupied != false);
}

TEST_CASE("frames with nothing to see give nothing") {
  const Detector detector;
  CHECK(detector.detect({}).empty());
  for (const int type : {CV_8UC1, CV_8UC3}) {
    for (const cv::Size size :
         {cv::Size(1, 1), cv::Size(1, 300), cv::Size(300, 1), cv::Size(4, 4), cv::Size(1, 3000)}) {
      CHECK(detector.detect(cv::Mat(size, type, cv::Scalar::all(128))).empty());
    }
    CHECK(detector.detect(cv::Mat(480, 640, type, cv::Scalar::all(255))).empty());
    CHECK(detector.detect(cv::Mat(480, 640, type, cv::Scalar::all(0))).empty());
  }
}

TEST_CASE("noise gives nothing") {
  std::mt19937 random(3);
  for (const double sigma : {2, 12, 60}) {
    cv::Mat image = grey_image(640, 480, 128);
    add_noise(image, sigma, random);
    CHECK(Detector().detect(image).empty());
  }
}

TEST_CASE("a frame of 48 megapixels, with a circle of half its height") {
  cv::Mat image = grey_image(8000, 6000, 60);
  cv::circle(image, {4000, 3000}, 1500, cv::Scalar::all(220), cv::FILLED, cv::LINE_AA);
  const auto found = Detector().detect(image);
  REQUIRE(found.size() == 1);
  CHECK(found[0].outer.ellipse.a_px == Approx(1500).margin(1));
}

TEST_CASE("part of a larger image is an image: rows need not follow each other in memory") {
  const Ellipse e{160, 120, 60, 35, 0.5};
  const cv::Mat whole = disc_scene(e);
  const auto found = Detector().detect(whole(cv::Rect(40, 30, 240, 180)));
  REQUIRE(found.size() == 1);
  check_near(found[0].outer.ellipse, {120, 90, 60, 35, 0.5}, 0.02);
}

TEST_CASE("the detector writes into no image that it was given") {
  const Detector detector{DetectorSettings{}};
  const cv::Mat grey = disc_scene({160, 120, 50, 30, 0.4}), before = grey.clone();
  cv::Mat colour(grey.size(), CV_8UC3, cv::Scalar(10, 200, 90));
  (void)detector.detect(grey);
  (void)detector.detect(colour);
  CHECK(cv::countNonZero(grey != before) == 0);
}
