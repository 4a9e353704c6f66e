#include "pose_proc/pose.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>

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

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

}  // namespace

TEST_CASE("a circle straight ahead is where its size says") {
  for (const char* method : {"conic", "four_point"}) {
    PoseSettings settings;
    settings.method = method;
    const CirclePose pose = estimate_pose(overhead(), Label::circle, camera, {}, {}, settings);
    CAPTURE(method);
    REQUIRE_FALSE(pose.solutions.empty());
    CHECK(pose.reason == NoPose::none);
    CHECK((pose.solutions[0].circle.center_camera_m - Eigen::Vector3d(0, 0, 2)).norm() < 1e-6);
    CHECK((pose.solutions[0].circle.normal_camera - Eigen::Vector3d(0, 0, -1)).norm() < 1e-6);
  }
}

TEST_CASE("the label says the radius") {
  const PoseSettings settings;
  const CirclePose cargo = estimate_pose(overhead(), Label::cargo, camera, {}, {}, settings);
  REQUIRE(cargo.solutions.size() == 2);
  CHECK(cargo.radius_m == settings.cargo_radius_m);
  CHECK(cargo.solutions[0].circle.center_camera_m.z() == Approx(2 * settings.cargo_radius_m / 0.5));
  CHECK(cargo.chosen_by == ChosenBy::optical_axis);
  CHECK(cargo.solutions[0].probability + cargo.solutions[1].probability == Approx(1));
}

TEST_CASE("no radius, no pose: with a reason") {
  const CirclePose pose = estimate_pose(overhead(), Label::unknown, camera, {}, {}, {});
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
  const CirclePose pose = estimate_pose(fit, Label::circle, camera, {}, {}, {});
  CHECK(pose.solutions.empty());
  CHECK(pose.reason == NoPose::not_solvable);
}

TEST_CASE("gravity and the previous choice reach the decision") {
  EllipseFit fit = changed(&Ellipse::b_px, 75);  // leans by about 27 degrees one way or the other
  fit.covariance(4, 4) = 1e-4;
  const CirclePose free = estimate_pose(fit, Label::circle, camera, {}, {}, {});
  REQUIRE(free.solutions.size() == 2);
  for (const PoseSolution& wanted : free.solutions) {
    const Gravity gravity{-wanted.circle.normal_camera, 0};
    const CirclePose by_gravity = estimate_pose(fit, Label::circle, camera, gravity, {}, {});
    CHECK(by_gravity.chosen_by == ChosenBy::attitude);
    CHECK(by_gravity.solutions[0].circle.normal_camera == wanted.circle.normal_camera);
    const PreviousChoice previous{wanted.circle.normal_camera, 1};
    const CirclePose by_previous = estimate_pose(fit, Label::circle, camera, {}, previous, {});
    CHECK(by_previous.chosen_by == ChosenBy::continuity);
    CHECK(by_previous.solutions[0].circle.normal_camera == wanted.circle.normal_camera);
  }
}
