// Sensors: their errors are as large as they claim, and wander as they should. Also what is told wrongly.
#include <Eigen/Dense>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "sim_proc/world/sensors.hpp"
#include "sim_proc/world/told_and_true.hpp"

using namespace stevedore;
using namespace stevedore::world;

namespace {

constexpr double deg = std::numbers::pi / 180;

double rms(const std::vector<double>& values) {
  return std::sqrt(
      Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<long>(values.size())).squaredNorm() /
      static_cast<double>(values.size()));
}

Rigid some_body() {
  Rigid body;
  body.position_ned_m = {10, -20, -5};
  body.velocity_ned_mps = {1, 2, -0.5};
  body.ned_from_local = Eigen::AngleAxisd(0.4, Eigen::Vector3d(1, 2, 3).normalized());
  body.angular_velocity_ned_radps = {0.1, -0.2, 0.3};
  return body;
}

Eigen::Vector3d turn_between(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) {
  const Eigen::AngleAxisd turn(from.conjugate() * to);
  return turn.angle() * turn.axis();
}

}  // namespace

TEST_CASE("the vehicle's errors have the size that is claimed, over many flights") {
  const Rigid body = some_body();
  std::vector<double> position_m, velocity_mps, attitude_rad;
  double claimed_rad = 0;
  for (std::uint64_t seed = 0; seed < 3000; ++seed) {
    VehicleSensor sensor(seed, 1);
    const VehicleReading reading = sensor.read(0, body);
    const Eigen::Vector3d turn_rad = turn_between(body.ned_from_local, reading.ned_from_body);
    for (int axis = 0; axis < 3; ++axis) {
      position_m.push_back(reading.position_ned_m[axis] - body.position_ned_m[axis]);
      velocity_mps.push_back(reading.velocity_ned_mps[axis] - body.velocity_ned_mps[axis]);
      attitude_rad.push_back(turn_rad[axis]);
    }
    CHECK(reading.position_sigma_m == 1.5);
    CHECK(reading.velocity_sigma_mps == 0.1);
    claimed_rad = reading.attitude_sigma_rad;
  }
  CHECK(rms(position_m) == Approx(1.5).epsilon(0.03));
  CHECK(rms(velocity_mps) == Approx(0.1).epsilon(0.03));
  CHECK(claimed_rad == Approx(std::hypot(0.5, 0.5) * deg));
  CHECK(rms(attitude_rad) == Approx(claimed_rad).epsilon(0.03));
}

TEST_CASE("position and attitude wander: little from one reading to the next, all of it in time") {
  const Rigid body = some_body();
  std::vector<double> next_m, later_m, mean_rad;
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    VehicleSensor sensor(seed, 1);
    const Eigen::Vector3d first_m = sensor.read(0, body).position_ned_m;
    const Eigen::Vector3d second_m = sensor.read(0.02, body).position_ned_m;
    Eigen::Vector3d sum_rad = Eigen::Vector3d::Zero();
    for (int i = 0; i < 500; ++i)
      sum_rad += turn_between(body.ned_from_local, sensor.read(0, body).ned_from_body);
    for (int i = 0; i < 14500; ++i) sensor.read(0, body);  // 300 s in all
    const Eigen::Vector3d last_m = sensor.read(300, body).position_ned_m;
    for (int axis = 0; axis < 3; ++axis) {
      next_m.push_back(second_m[axis] - first_m[axis]);
      later_m.push_back(last_m[axis] - first_m[axis]);
      mean_rad.push_back(sum_rad[axis] / 500);
    }
  }
  CHECK(rms(next_m) == Approx(1.5 * std::sqrt(2 * 0.02 / 300)).epsilon(0.1));
  CHECK(rms(later_m) == Approx(1.5 * std::sqrt(2 * (1 - std::exp(-1)))).epsilon(0.1));
  CHECK(rms(mean_rad) == Approx(0.5 * deg).epsilon(0.15));  // the noise averages out, the bias stays
}

TEST_CASE("without errors every sensor says what is") {
  const Rigid body = some_body();
  const VehicleReading vehicle = VehicleSensor(1, 0).read(3, body);
  CHECK(vehicle.time_s == 3);
  CHECK((vehicle.position_ned_m - body.position_ned_m).norm() == 0);
  CHECK(turn_between(body.ned_from_local, vehicle.ned_from_body).norm() < 1e-9);
  CHECK((body.ned_from_local * vehicle.angular_rate_body_radps - body.angular_velocity_ned_radps).norm() <
        1e-12);
  const GimbalReading gimbal = GimbalEncoders(1, 0).read(3, {0.1, -0.2}, true);
  CHECK(gimbal.angles.roll_rad == 0.1);
  CHECK(gimbal.angles.pitch_rad == -0.2);
  CHECK(gimbal.at_limit);
  Altimeter laser(1, 0);
  for (int i = 0; i < 1000; ++i) CHECK(laser.read(3, 4.5, true).range_m == 4.5);
  CHECK_FALSE(laser.read(3, 25.0, false).range_m);
  CHECK_FALSE(laser.read(3, std::nullopt, false).range_m);
  CHECK(LoadCell(1, 0).read(3, 14.7, true).load_n == 14.7);
  PlatformSensor platform(1, 1, 0);
  for (int i = 0; i < 1000; ++i) {
    const auto reading = platform.read(i * 0.5, body);
    REQUIRE(reading);
    CHECK(reading->platform == 1);
    CHECK((reading->position_ned_m - body.position_ned_m).norm() == 0);
  }
  CHECK(AutopilotSensor(1, 0).read(3, true, 0.5).battery_v == Approx(23.1));
}

TEST_CASE("the laser is 3 cm off, drops out now and then for some readings, and often over water") {
  Altimeter dry(1, 1), wet(2, 1);
  std::vector<double> off_m;
  int dry_lost = 0, wet_lost = 0, runs = 0;
  bool before = true;
  constexpr int readings = 50000;
  for (int i = 0; i < readings; ++i) {
    const AltimeterReading reading = dry.read(0, 5.0, false);
    CHECK(reading.sigma_m == 0.03);
    if (reading.range_m) off_m.push_back(*reading.range_m - 5);
    dry_lost += !reading.range_m;
    runs += before && !reading.range_m;
    before = reading.range_m.has_value();
    wet_lost += !wet.read(0, 5.0, true).range_m;
  }
  CHECK(rms(off_m) == Approx(0.03).epsilon(0.02));
  const double lost = 0.01 / (0.01 + 0.3);  // of a chain that begins at 0.01 and ends at 0.3
  CHECK(dry_lost == Approx(lost * readings).epsilon(0.15));
  CHECK(dry_lost / static_cast<double>(runs) == Approx(1 / 0.3).epsilon(0.15));
  CHECK(wet_lost == Approx((lost + 0.15 * (1 - lost)) * readings).epsilon(0.1));
}

TEST_CASE("a platform is metres off, and silent for seconds now and then") {
  const Rigid deck = some_body();
  std::vector<double> off_m;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    PlatformSensor sensor(seed, 0, 1);
    const auto reading = sensor.read(0, deck);
    if (reading) off_m.push_back(reading->position_ned_m.x() - deck.position_ned_m.x());
  }
  CHECK(rms(off_m) == Approx(std::hypot(2.5, 0.3)).epsilon(0.05));
  PlatformSensor sensor(5, 0, 1);
  double longest_s = 0, heard_s = 0;
  int heard = 0;
  for (int i = 0; i < 20000; ++i) {
    if (!sensor.read(i * 0.5, deck)) continue;
    longest_s = std::max(longest_s, i * 0.5 - heard_s);
    heard_s = i * 0.5;
    ++heard;
  }
  CHECK(longest_s > 6);
  CHECK(longest_s < 20);
  CHECK(heard > 20000 * 0.7);
  CHECK(heard < 20000 * 0.9);
}

TEST_CASE("what is told differs from what is by the stated draws, never by more than twice") {
  CameraModel told;
  told.given = told.rectified = {640, 480, 337, 337, 319.5, 239.5};
  const LeverArms told_arms;
  std::vector<double> focal, u_px, mount_rad, arm_m, circle, stamp_s;
  for (std::uint64_t seed = 0; seed < 4000; ++seed) {
    const TrueSelf self = draw_true_self(seed, {}, told, told_arms);
    focal.push_back(self.camera.given.fx_px / 337 - 1);
    CHECK(self.camera.given.fx_px == self.camera.given.fy_px);
    u_px.push_back(self.camera.given.cx_px - 319.5);
    CHECK(self.camera.rectified.cx_px == self.camera.given.cx_px);
    mount_rad.push_back(self.camera.mount.pitch_rad);
    arm_m.push_back(self.arms.camera_body_m.x() - told_arms.camera_body_m.x());
    CHECK(std::abs(arm_m.back()) < 0.0401);
    circle.push_back(self.circle_scale - 1);
    stamp_s.push_back(self.stamp_late_s);
  }
  const double cut = 0.9594;  // rms of a normal draw whose tails are put at 2 sigma
  CHECK(rms(focal) == Approx(cut * 0.003).epsilon(0.04));
  CHECK(rms(u_px) == Approx(cut * 2).epsilon(0.04));
  CHECK(rms(mount_rad) == Approx(cut * 0.5 * deg).epsilon(0.04));
  CHECK(rms(arm_m) == Approx(cut * 0.02).epsilon(0.04));
  CHECK(rms(circle) == Approx(cut * 0.005).epsilon(0.04));
  CHECK(rms(stamp_s) == Approx(cut * 0.005).epsilon(0.04));
}
