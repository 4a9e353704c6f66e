#include "pose_proc/pose.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include "tests/support/measured_circle.hpp"

using namespace stevedore;

namespace {

const Pinhole camera{640, 480, 337, 337, 319.5, 239.5};

/// A circle of radius 0.5 m, parallel to the image plane at a depth of 2 m on the optical axis.
EllipseFit overhead() {
  EllipseFit fit{{319.5, 239.5, 84.25, 84.25, 0}, EllipseCovariance::Zero()};
  fit.covariance.diagonal() << 0.01, 0.01, 0.01, 0.01, 1;
  return fit;
}

EllipseFit changed(double Ellipse::*member, double value) {
  EllipseFit fit = overhead();
  fit.ellipse.*member = value;
  return fit;
}

MarkImage mark(const EllipseFit& fit, Label label) {
  return {fit, {}, label, {}};
}

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_CASE("a circle straight ahead is where its size says") {
  for (const char* method : {"conic", "four_point"}) {
    PoseSettings settings;
    settings.method = method;
    const CirclePose pose = estimate_pose(mark(overhead(), Label::circle), camera, {}, settings);
    CAPTURE(method);
    REQUIRE_FALSE(pose.solutions.empty());
    CHECK(pose.reason == NoPose::none);
    CHECK((pose.solutions[0].circle.center_camera_m - Eigen::Vector3d(0, 0, 2)).norm() < 0.02);
    CHECK((pose.solutions[0].circle.normal_camera - Eigen::Vector3d(0, 0, -1)).norm() < 0.1);
  }
}

TEST_CASE("the label says the radius") {
  const PoseSettings settings;
  const CirclePose cargo = estimate_pose(mark(overhead(), Label::cargo), camera, {}, settings);
  REQUIRE(cargo.solutions.size() == 2);
  CHECK(cargo.radius_m == settings.cargo_radius_m);
  CHECK(cargo.solutions[0].circle.center_camera_m.z() ==
        Approx(2 * settings.cargo_radius_m / 0.5).epsilon(0.01));
  CHECK(cargo.chosen_by == ChosenBy::optical_axis);
  CHECK(cargo.solutions[0].probability + cargo.solutions[1].probability == Approx(1));
}

TEST_CASE("no radius, no pose: with a reason") {
  const CirclePose pose = estimate_pose(mark(overhead(), Label::unknown), camera, {}, {});
  CHECK(pose.solutions.empty());
  CHECK(pose.reason == NoPose::radius_unknown);
  CHECK(std::string(reason_text(pose.reason)) != "");
}

TEST_CASE(
    "both methods give nothing for what is not an ellipse, a radius that is not positive, noise without "
    "end") {
  EllipseFit endless = overhead();
  endless.covariance(3, 3) = nan_value;
  for (const EllipseFit& fit :
       {changed(&Ellipse::b_px, 0), changed(&Ellipse::b_px, -3), changed(&Ellipse::b_px, 90),
        changed(&Ellipse::b_px, 1e-9), changed(&Ellipse::u_px, nan_value),
        changed(&Ellipse::a_px, std::numeric_limits<double>::infinity()), endless}) {
    CHECK_FALSE(conic_pose(fit, camera, 0.5));
    CHECK_FALSE(four_point_pose(fit, camera, 0.5));
  }
  for (const double radius_m : {0.0, -0.5, nan_value}) {
    CHECK_FALSE(conic_pose(overhead(), camera, radius_m));
    CHECK_FALSE(four_point_pose(overhead(), camera, radius_m));
  }
}

TEST_CASE("an ellipse thinner than its own noise has no pose") {
  EllipseFit fit = changed(&Ellipse::b_px, 1);
  fit.covariance(3, 3) = 1.5;
  CHECK_FALSE(conic_pose(fit, camera, 0.5));
  const CirclePose pose = estimate_pose(mark(fit, Label::circle), camera, {}, {});
  CHECK(pose.solutions.empty());
  CHECK(pose.reason == NoPose::not_solvable);
}

TEST_CASE("gravity and the previous choice reach the decision") {
  EllipseFit fit = changed(&Ellipse::b_px, 75);  // leans by about 27 degrees one way or the other
  fit.covariance(4, 4) = 1e-4;
  const CirclePose free = estimate_pose(mark(fit, Label::circle), camera, {}, {});
  REQUIRE(free.solutions.size() == 2);
  for (std::size_t i = 0; i < 2; ++i) {
    const Eigen::Vector3d wanted = free.solutions[i].circle.normal_camera;
    const PoseContext level{Gravity{-wanted, 0}, {}};
    const CirclePose by_gravity = estimate_pose(mark(fit, Label::circle), camera, level, {});
    CHECK(by_gravity.chosen_by == ChosenBy::attitude);
    CHECK(by_gravity.solutions[0].circle.normal_camera == wanted);
    MarkImage seen_before = mark(fit, Label::circle);
    seen_before.previous = PreviousChoice{{wanted, free.solutions[1 - i].circle.normal_camera}, 0.999};
    const CirclePose by_previous = estimate_pose(seen_before, camera, {}, {});
    CHECK(by_previous.chosen_by == ChosenBy::continuity);
    CHECK(by_previous.solutions[0].circle.normal_camera == wanted);
  }
}

TEST_CASE("what is believed of radius and camera is added to every covariance, and nothing by default") {
  PoseSettings settings;
  const auto covariance = [&] {
    return estimate_pose(mark(overhead(), Label::circle), camera, {}, settings)
        .solutions[0]
        .circle.covariance_m2;
  };
  const Eigen::Matrix3d edge_alone = covariance();
  settings.radius_sigma_percent = 0.5;
  CHECK((covariance() - edge_alone)(2, 2) == Approx(0.01 * 0.01));  // half a percent of 2 m
  settings.radius_sigma_percent = 0;
  settings.principal_point_sigma_px = 3.37;
  CHECK((covariance() - edge_alone)(0, 0) == Approx(0.02 * 0.02).epsilon(0.01));
  CHECK((covariance() - edge_alone)(2, 2) == Approx(0).margin(1e-9));
}

TEST_CASE("a smaller round thing among circles loses its label, and says why") {
  MarkImage circle = mark(overhead(), Label::circle), other = circle, tyre = circle;
  other.outer.ellipse.u_px += 180;
  tyre.outer.ellipse.v_px += 150;
  tyre.outer.ellipse.a_px = tyre.outer.ellipse.b_px = 50;
  const auto poses = estimate_poses({circle, other, tyre}, camera, {}, {});
  CHECK(poses[0].label == Label::circle);
  CHECK(poses[1].label == Label::circle);
  CHECK(poses[2].label == Label::unknown);
  CHECK(poses[2].solutions.empty());
  CHECK(poses[2].reason == NoPose::another_size);
}

namespace {

/// Circles in a row on a deck that leans, as they are measured.
std::vector<MarkImage> row_on_deck(int count) {
  constexpr double sigma_px = 0.1;
  std::mt19937 random(1);
  const Circle middle = circle_at(camera, 320, 240, 4, 0.35, 0.5);
  std::vector<MarkImage> marks;
  for (int i = 0; i < count; ++i) {
    Circle circle = middle;
    circle.center_m += 4.4 / count * (i - 0.5 * (count - 1)) * middle.normal.unitOrthogonal();
    const Ellipse e = image_of(camera, circle).value();
    marks.push_back(mark(fitted(edge_points(e, sigma_px, 0, random), e, sigma_px).value(), Label::circle));
  }
  return marks;
}

/// Three circles of a deck, and one that the tracker only thinks is there.
std::vector<MarkImage> three_and_predicted(double predicted_size) {
  std::vector<MarkImage> marks = row_on_deck(4);
  MarkImage& predicted = marks[3];
  predicted.measured = false;
  Ellipse& e = predicted.outer.ellipse;
  e.a_px *= predicted_size, e.b_px *= predicted_size;
  predicted.outer.covariance.setZero();
  predicted.outer.covariance.diagonal() << 25, 25, 0.01 * e.a_px * e.a_px, 0.01 * e.b_px * e.b_px, 0.8;
  predicted.outer.covariance(2, 3) = predicted.outer.covariance(3, 2) = 0.01 * e.a_px * e.b_px;
  return marks;
}

}  // namespace

TEST_CASE("a mark that is only predicted has no say about those that are measured") {
  SECTION("what size circles have") {
    std::vector<MarkImage> marks = three_and_predicted(1.2);
    marks.erase(marks.begin(), marks.begin() + 2);
    const auto poses = estimate_poses(marks, camera, {}, {});
    CHECK(poses[0].label == Label::circle);
    CHECK(poses[0].solutions.size() == 2);
  }
  SECTION("what plane they lie on") {
    const auto poses = estimate_poses(three_and_predicted(1.0), camera, {}, {});
    auto alone = three_and_predicted(1.0);
    alone.pop_back();
    const auto without = estimate_poses(alone, camera, {}, {});
    for (std::size_t i = 0; i < 3; ++i) {
      CHECK(poses[i].deck == 0);
      CHECK(poses[i].solutions[0].circle.center_camera_m == without[i].solutions[0].circle.center_camera_m);
    }
    CHECK(poses[3].deck == -1);
    CHECK(poses[3].solutions.size() == 2);
  }
}

TEST_CASE("of very many circles those of which most is seen tell the deck") {
  std::vector<MarkImage> marks = row_on_deck(30);
  for (std::size_t i = 0; i < 6; ++i) marks[5 * i].coverage = 0.8;
  const auto poses = estimate_poses(marks, camera, {}, {});
  for (std::size_t i = 0; i < marks.size(); ++i) {
    CHECK(poses[i].deck == (i % 5 == 0 ? -1 : 0));
    CHECK(poses[i].solutions.size() == 2);
  }
}
