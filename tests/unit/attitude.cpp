#include "geometry/attitude.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace stevedore;

namespace {

constexpr double deg = std::numbers::pi / 180;

Eigen::Quaterniond attitude(double roll_deg, double pitch_deg, double yaw_deg) {
  using Eigen::AngleAxisd, Eigen::Vector3d;
  return AngleAxisd(yaw_deg * deg, Vector3d::UnitZ()) * AngleAxisd(pitch_deg * deg, Vector3d::UnitY()) *
         AngleAxisd(roll_deg * deg, Vector3d::UnitX());
}

void check_near(const Eigen::Vector3d& actual, const Eigen::Vector3d& expected) {
  CAPTURE(actual.transpose(), expected.transpose());
  CHECK((actual - expected).norm() < 1e-12);
}

}  // namespace

TEST_CASE("a level aircraft with its gimbal at zero looks straight down, whatever its heading") {
  for (const double yaw : {0, 50, -170})
    check_near(gravity_in_camera(attitude(0, 0, yaw), {}, {}), {0, 0, 1});
}

TEST_CASE("nose up, down appears towards the bottom of the image, which looks backward") {
  check_near(gravity_in_camera(attitude(0, 10, 33), {}, {}), {0, std::sin(10 * deg), std::cos(10 * deg)});
}

TEST_CASE("right wing down, down appears towards the right of the image") {
  check_near(gravity_in_camera(attitude(10, 0, 33), {}, {}), {std::sin(10 * deg), 0, std::cos(10 * deg)});
}

TEST_CASE("a gimbal at minus the aircraft's roll and pitch holds the camera level") {
  check_near(gravity_in_camera(attitude(17, -23, 140), {-17 * deg, 23 * deg}, {}), {0, 0, 1});
}

TEST_CASE("a camera mounted nose up on a level platform sees gravity as from a nose-up aircraft") {
  const CameraMount mount{0, 4 * deg, 0};
  check_near(gravity_in_camera(attitude(0, 0, 0), {}, mount), {0, std::sin(4 * deg), std::cos(4 * deg)});
}

TEST_CASE("camera axes on the body of a level aircraft: right, backward, down") {
  const Eigen::Matrix3d body = body_from_camera({}, {});
  check_near(body * Eigen::Vector3d::UnitX(), {0, 1, 0});
  check_near(body * Eigen::Vector3d::UnitY(), {-1, 0, 0});
  check_near(body * Eigen::Vector3d::UnitZ(), {0, 0, 1});
}

TEST_CASE("the level frame is the camera's, turned by the least angle that puts z along gravity") {
  const Eigen::Vector3d gravity = Eigen::Vector3d(0.2, -0.1, 0.9).normalized();
  const Eigen::Matrix3d level = level_from_camera(gravity);
  check_near(level * gravity, {0, 0, 1});
  CHECK((level * level.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-12);
  CHECK(Eigen::AngleAxisd(level).angle() == Approx(std::acos(gravity.z())));
  CHECK(level_from_camera(Eigen::Vector3d::UnitZ()).isIdentity(1e-12));
}
