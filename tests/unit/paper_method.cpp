#include "detector_proc/detector.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "detector_proc/affine_moments.hpp"
#include "detector_proc/ellipse_fit.hpp"
#include "tests/unit/detector_scene.hpp"

using namespace stevedore;
using std::numbers::pi;

namespace {

DetectorSettings paper_settings() {
  DetectorSettings s;
  s.method = "paper";
  return s;
}

using Polygon = std::vector<cv::Point2f>;

AffineMoments moments_of(const Polygon& polygon) {
  const auto moments = affine_moments(cv::moments(polygon));
  REQUIRE(moments);
  return *moments;
}

Polygon polygon_of(const Ellipse& e, int corners) {
  Polygon polygon;
  for (int i = 0; i < corners; ++i) {
    const Eigen::Vector2d p = point_at(e, 2 * pi * i / corners);
    polygon.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  return polygon;
}

cv::Mat disc_scene(const Ellipse& e) {
  cv::Mat image = grey_image(320, 240, 60);
  paint(image, e, cv::Scalar::all(220));
  return image;
}

DetectorSettings only_color(const ColorRange& range) {
  DetectorSettings s = paper_settings();
  s.canny_low = s.canny_high = 2000;  // above any gradient of the scene
  s.colors = {range};
  return s;
}

}  // namespace

TEST_CASE("affine moments of ellipses are those of eq. (3), whatever their shape") {
  for (const Ellipse& e :
       {Ellipse{0, 0, 50, 50, 0}, Ellipse{30, -10, 90, 20, 0.7}, Ellipse{5, 5, 4, 3, -1}}) {
    const AffineMoments m = moments_of(polygon_of(e, 2000));
    CHECK(m.i1 == Approx(ellipse_i1).epsilon(1e-4));
    CHECK(m.i2 == Approx(0).margin(1e-12));
    CHECK(m.i3 == Approx(0).margin(1e-9));
  }
}

TEST_CASE("affine moments of a square and a triangle, under any affine map") {
  const Polygon square{{0, 0}, {10, 0}, {10, 10}, {0, 10}}, parallelogram{{0, 0}, {30, 5}, {37, 25}, {7, 20}};
  for (const auto& p : {square, parallelogram}) {
    CHECK(moments_of(p).i1 == Approx(1.0 / 144));
    CHECK(moments_of(p).i3 == Approx(0).margin(1e-9));
  }
  const Polygon triangle{{0, 0}, {30, 5}, {7, 20}};
  CHECK(moments_of(triangle).i1 == Approx(1.0 / 108));
  CHECK(std::abs(moments_of(triangle).i2) > 1e-7);
  CHECK(std::abs(moments_of(triangle).i3) > 1e-5);
  // Every triangle is an affine image of every other: a wrong factor in eq. (1) tells them apart.
  for (const Polygon& other : {Polygon{{0, 0}, {10, 0}, {0, 10}}, Polygon{{-5, 3}, {50, -20}, {11, 40}}}) {
    CHECK(moments_of(other).i2 == Approx(moments_of(triangle).i2));
    CHECK(moments_of(other).i3 == Approx(moments_of(triangle).i3));
  }
  CHECK_FALSE(affine_moments(cv::moments(Polygon{{0, 0}, {10, 0}, {20, 0}})));
}

TEST_CASE("alpha of a RotatedRect is the direction of its long side") {
  const cv::RotatedRect wide({0, 0}, {40, 10}, 30), tall({0, 0}, {10, 40}, 30);
  CHECK(ellipse_from_rotated_rect(wide).alpha_rad == Approx(pi / 6));
  CHECK(ellipse_from_rotated_rect(tall).alpha_rad == Approx(pi / 6 - pi / 2));
  CHECK(ellipse_from_rotated_rect(tall).a_px == 20);
  CHECK(ellipse_from_rotated_rect(tall).b_px == 5);
}

TEST_CASE("a fit finds the alpha that the ellipse was drawn with") {
  for (double alpha = -1.5; alpha < 1.5; alpha += 0.25) {
    const Ellipse e{200, 150, 100, 40, alpha};
    const auto fit = fit_ellipse(pixels_of(e));
    REQUIRE(fit);
    CHECK(fit->alpha_rad == Approx(alpha).margin(0.005));
    CHECK(fit->a_px == Approx(e.a_px).margin(0.1));
    CHECK(fit->b_px == Approx(e.b_px).margin(0.1));
    CHECK(algebraic_error(*fit, pixels_of(e)) < 0.02);
    Ellipse turned = e;
    turned.alpha_rad += 0.3;
    CHECK(algebraic_error(turned, pixels_of(e)) > 0.2);
  }
}

TEST_CASE("five points or points on a line give no ellipse") {
  const std::vector<cv::Point> line{{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}, {5, 5}, {6, 6}, {7, 7}};
  CHECK_FALSE(fit_ellipse({line.begin(), line.begin() + 5}));
  const auto fit = fit_ellipse(line);
  CHECK((!fit || fit->b_px < 1 || fit->a_px > 1000));
}

TEST_CASE("distance to an ellipse, inside negative") {
  const Ellipse e{10, 20, 30, 15, 0};
  CHECK(distance_px(e, {42, 20}) == Approx(2).epsilon(0.05));
  CHECK(distance_px(e, {10, 33}) == Approx(-2).epsilon(0.1));
  CHECK(distance_px({0, 0, 5, 5, 0}, {0, 7}) == Approx(2));
}

TEST_CASE("coverage is the share of the perimeter that has points") {
  const Ellipse e{200, 150, 100, 40, 0.4};
  CHECK(coverage(e, pixels_of(e), 1.5) == Approx(1));
  CHECK(coverage(e, pixels_of(e, 0.5), 1.5) == Approx(0.5).margin(0.03));
  Ellipse larger = e;
  larger.b_px += 10;
  CHECK(coverage(larger, pixels_of(e), 1.5) < 0.3);
}

TEST_CASE("half an ellipse says less about the whole: covariance") {
  const Ellipse e{200, 150, 100, 60, 0};
  const auto whole = fit_covariance(e, pixels_of(e), 3), half = fit_covariance(e, pixels_of(e, 0.5), 3);
  CHECK(half(1, 1) > 8 * whole(1, 1));  // the lower half is seen: v and b trade against each other
  CHECK(half(0, 0) > 1.5 * whole(0, 0));
  // A circle has no direction: all that is known of alpha is that it is within half a turn.
  const Ellipse circle{200, 150, 50, 50, 0};
  CHECK(fit_covariance(circle, pixels_of(circle), 3)(4, 4) == Approx(pi * pi / 12).epsilon(0.01));
}

TEST_CASE("a disc is one whole circle with nothing in it") {
  const Ellipse e{160.3, 119.8, 60, 35, 0.5};
  const auto found = Detector(paper_settings()).detect(disc_scene(e));
  REQUIRE(found.size() == 1);
  const Detection& d = found[0];
  CHECK(d.kind == Kind::whole);
  CHECK(d.label == Label::circle);
  CHECK(d.occupied == false);
  CHECK_FALSE(d.inner);
  CHECK(d.coverage == Approx(1));
  CHECK(d.error < 0.03);
  CHECK(d.outer.ellipse.u_px == Approx(e.u_px).margin(0.15));
  CHECK(d.outer.ellipse.v_px == Approx(e.v_px).margin(0.15));
  CHECK(d.outer.ellipse.a_px == Approx(e.a_px).margin(0.25));
  CHECK(d.outer.ellipse.b_px == Approx(e.b_px).margin(0.25));
  CHECK(d.outer.ellipse.alpha_rad == Approx(e.alpha_rad).margin(0.01));
}

TEST_CASE("a ring is one mark: its outer edge, with the inner one beside it") {
  const Ellipse outer{160, 120, 80, 60, -0.4}, inner{160, 120, 62, 46.5, -0.4};
  for (const int paint_level : {220, 10}) {
    cv::Mat image = grey_image(320, 240, 110);
    paint(image, outer, cv::Scalar::all(paint_level));
    paint(image, inner, cv::Scalar::all(110));
    const auto found = Detector(paper_settings()).detect(image);
    REQUIRE(found.size() == 1);
    CHECK(found[0].outer.ellipse.a_px == Approx(80).margin(0.3));
    REQUIRE(found[0].inner);
    CHECK(found[0].inner->ellipse.a_px == Approx(62).margin(0.3));
    CHECK(found[0].label == Label::circle);
    CHECK(found[0].occupied == false);
  }
}

TEST_CASE("a bucket in a ring is a cargo, and the ring is occupied") {
  cv::Mat image = grey_image(320, 240, 60);
  paint(image, {160, 120, 80, 70, 0}, cv::Scalar::all(220));
  paint(image, {160, 120, 64, 56, 0}, cv::Scalar::all(60));
  paint(image, {170, 115, 25, 22, 0}, cv::Scalar::all(160));
  const auto found = Detector(paper_settings()).detect(image);
  REQUIRE(found.size() == 2);
  CHECK(found[0].label == Label::circle);
  CHECK(found[0].inner);
  CHECK(found[0].occupied == true);
  CHECK(found[1].label == Label::cargo);
  CHECK_FALSE(found[1].occupied);
  CHECK(found[1].outer.ellipse.a_px == Approx(25).margin(0.4));
}

TEST_CASE("something in a circle that is no ellipse: can't tell") {
  cv::Mat image = disc_scene({160, 120, 80, 70, 0});
  cv::line(image, {130, 120}, {190, 120}, cv::Scalar::all(40), 9);
  const auto found = Detector(paper_settings()).detect(image);
  REQUIRE(found.size() == 1);
  CHECK(found[0].label == Label::circle);
  CHECK_FALSE(found[0].occupied);
}

TEST_CASE("an ellipse cut by the border is found through its hull, as partial") {
  const Ellipse e{20, 120, 70, 50, 0.2};
  const auto found = Detector(paper_settings()).detect(disc_scene(e));
  REQUIRE(found.size() == 1);
  CHECK(found[0].kind == Kind::partial);
  CHECK(found[0].coverage < 0.8);
  CHECK(found[0].outer.ellipse.u_px == Approx(e.u_px).margin(2));
  CHECK(found[0].outer.ellipse.a_px == Approx(e.a_px).margin(2));
  DetectorSettings no_hull = paper_settings();
  no_hull.use_hull = false;
  CHECK(Detector(no_hull).detect(disc_scene(e)).empty());
}

TEST_CASE("an ellipse hidden in part is found through its hull") {
  cv::Mat image = disc_scene({160, 120, 70, 50, 0});
  cv::rectangle(image, cv::Rect(190, 60, 100, 120), cv::Scalar::all(60), cv::FILLED);
  const auto found = Detector(paper_settings()).detect(image);
  const auto near = std::find_if(found.begin(), found.end(), [](const Detection& d) {
    return d.kind == Kind::partial && std::abs(d.outer.ellipse.u_px - 160) < 3 &&
           std::abs(d.outer.ellipse.a_px - 70) < 4;
  });
  CHECK(near != found.end());
}

TEST_CASE("polygons and lines are no ellipses") {
  cv::Mat image = grey_image(320, 240, 60);
  cv::rectangle(image, cv::Rect(20, 20, 80, 60), cv::Scalar::all(220), cv::FILLED);
  cv::fillPoly(image, std::vector<std::vector<cv::Point>>{{{200, 30}, {290, 90}, {180, 120}}},
               cv::Scalar::all(200));
  cv::line(image, {10, 200}, {310, 160}, cv::Scalar::all(255), 3);
  CHECK(Detector(paper_settings()).detect(image).empty());
}

TEST_CASE("a square is no whole ellipse: the AMI gate") {
  cv::Mat image = grey_image(320, 240, 60);
  cv::rectangle(image, cv::Rect(100, 60, 120, 120), cv::Scalar::all(220), cv::FILLED);
  DetectorSettings s = paper_settings();  // the gate alone
  s.max_error = 1;
  s.min_coverage_whole = s.min_coverage_partial = 0;
  const auto whole = [](const Detection& d) { return d.kind == Kind::whole; };
  const auto found = Detector(s).detect(image);
  CHECK(std::none_of(found.begin(), found.end(), whole));
  s.ami_i1_tolerance = 1e-3;
  const auto more = Detector(s).detect(image);
  CHECK(std::any_of(more.begin(), more.end(), whole));
}

TEST_CASE("what fits its contour worse than both error limits is left out") {
  const cv::Mat scene = disc_scene({160, 120, 60, 35, 0.5});  // its error is 0.01: 0.2 px of rounding
  DetectorSettings s = paper_settings();
  s.max_error = 0.001;
  s.max_error_px = 0.001;
  CHECK(Detector(s).detect(scene).empty());
  s.max_error_px = 0.5;
  CHECK(Detector(s).detect(scene).size() == 1);
  s.max_error = 0.1;
  s.max_error_px = 0;
  CHECK(Detector(s).detect(scene).size() == 1);
}

TEST_CASE("flatter than max_aspect is left out") {
  const cv::Mat flat = disc_scene({160, 120, 120, 18, 0.1});
  CHECK(Detector(paper_settings()).detect(flat).empty());
  DetectorSettings any_aspect = paper_settings();
  any_aspect.max_aspect = 10;
  CHECK(Detector(any_aspect).detect(flat).size() == 1);
}

TEST_CASE("paint of the ground's brightness is found by its colour") {
  // Red (0, 0, 200) and grey 60 are both 60 once grey: 0.299 * 200.
  cv::Mat image(240, 320, CV_8UC3, cv::Scalar::all(60));
  const Ellipse e{150.4, 110.7, 60, 40, 0.3};
  paint(image, e, cv::Scalar(0, 0, 200));
  CHECK(Detector(paper_settings()).detect(image).empty());
  DetectorSettings s = paper_settings();
  s.colors = {{.hue_low_deg = 340, .hue_high_deg = 20, .saturation_low = 100, .value_low = 50}};
  const auto found = Detector(s).detect(image);
  REQUIRE(found.size() == 1);
  CHECK(found[0].kind == Kind::whole);
  CHECK(found[0].outer.ellipse.u_px == Approx(e.u_px).margin(0.2));
  // saturation passes half of it where the paint covers less than half a pixel: up to 0.4 px large
  CHECK(found[0].outer.ellipse.a_px == Approx(e.a_px).margin(0.6));
}

TEST_CASE("on grey frames a colour range acts on the level, if it takes grey at all") {
  const Ellipse e{160.3, 120.2, 60, 35, 0.5};
  const auto bright = Detector(only_color({.value_low = 140})).detect(disc_scene(e));
  REQUIRE(bright.size() == 1);
  CHECK(Detector(only_color({.saturation_low = 50})).detect(disc_scene(e)).empty());
  // 140 is half way between disc and ground: neither the region's nor the hole's bias is left
  const auto dark = Detector(only_color({.value_high = 139})).detect(disc_scene(e));
  REQUIRE(dark.size() == 1);
  for (const auto& d : {bright[0], dark[0]}) {
    CHECK(d.outer.ellipse.a_px == Approx(e.a_px).margin(0.15));
    CHECK(d.outer.ellipse.b_px == Approx(e.b_px).margin(0.15));
  }
}

TEST_CASE("edge and colour of one disc are one detection") {
  DetectorSettings s = paper_settings();
  s.colors = {{.value_low = 140}, {.value_low = 150}};
  CHECK(Detector(s).detect(disc_scene({160, 120, 60, 35, 0.5})).size() == 1);
}

TEST_CASE("a grey image and the same in colour give the same") {
  const cv::Mat grey = disc_scene({160, 120, 60, 35, 0.5});
  cv::Mat color;
  cv::cvtColor(grey, color, cv::COLOR_GRAY2BGR);
  const auto a = Detector(paper_settings()).detect(grey), b = Detector(paper_settings()).detect(color);
  REQUIRE(a.size() == 1);
  REQUIRE(b.size() == 1);
  CHECK(a[0].outer.ellipse.a_px == b[0].outer.ellipse.a_px);
}

TEST_CASE("frames with nothing to see give nothing") {
  const Detector detector(paper_settings());
  CHECK(detector.detect({}).empty());
  for (const int type : {CV_8UC1, CV_8UC3}) {
    for (const cv::Size size : {cv::Size(1, 1), cv::Size(1, 300), cv::Size(300, 1), cv::Size(4, 4)}) {
      CHECK(detector.detect(cv::Mat(size, type, cv::Scalar::all(128))).empty());
    }
    CHECK(detector.detect(cv::Mat(480, 640, type, cv::Scalar::all(255))).empty());
    CHECK(detector.detect(cv::Mat(480, 640, type, cv::Scalar::all(0))).empty());
  }
}

TEST_CASE("noise gives nothing that is called a circle") {
  std::mt19937 random(3);
  cv::Mat image = grey_image(640, 480, 128);
  add_noise(image, 12, random);
  const auto found = Detector(paper_settings()).detect(image);
  CHECK(
      std::none_of(found.begin(), found.end(), [](const Detection& d) { return d.label == Label::circle; }));
  add_noise(image, 60, random);  // far beyond any camera: anything may be found, and nothing breaks
  for (const Detection& d : Detector(paper_settings()).detect(image)) CHECK(is_valid(d.outer.ellipse));
}

TEST_CASE("a frame of 48 megapixels, with a circle of half its height") {
  cv::Mat image = grey_image(8000, 6000, 60);
  cv::circle(image, {4000, 3000}, 1500, cv::Scalar::all(220), cv::FILLED, cv::LINE_AA);
  const auto found = Detector(paper_settings()).detect(image);
  REQUIRE(found.size() == 1);
  CHECK(found[0].outer.ellipse.a_px == Approx(1500).margin(1));
}

TEST_CASE("part of a larger image is an image: rows need not follow each other in memory") {
  const Ellipse e{160, 120, 60, 35, 0.5};
  const cv::Mat whole = disc_scene(e);
  const auto found = Detector(paper_settings()).detect(whole(cv::Rect(40, 30, 240, 180)));
  REQUIRE(found.size() == 1);
  CHECK(found[0].outer.ellipse.u_px == Approx(120).margin(0.2));
}
