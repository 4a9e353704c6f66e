#include "gimbal_proc/gimbal.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

using namespace stevedore;

namespace {

using Eigen::AngleAxisd, Eigen::Vector3d;

constexpr double deg = std::numbers::pi / 180;
constexpr double period_s = 0.02;

Eigen::Quaterniond attitude(double roll_rad, double pitch_rad, double yaw_rad) {
  return AngleAxisd(yaw_rad, Vector3d::UnitZ()) * AngleAxisd(pitch_rad, Vector3d::UnitY()) *
         AngleAxisd(roll_rad, Vector3d::UnitX());
}

AttitudeReading still(double time_s, double roll_deg, double pitch_deg) {
  return {time_s, attitude(roll_deg * deg, pitch_deg * deg, 1), Vector3d::Zero()};
}

/// A pan-tilt of second order, 15 Hz, damping 0.7, with its own stops.
class PanTilt {
 public:
  explicit PanTilt(const GimbalAngles& start = {}) : angles(start) {}
  void move(const GimbalAngles& command, double time_s) {
    constexpr double step_s = 1e-4, w = 2 * std::numbers::pi * 15, damping = 0.7;
    for (double t = 0; t < time_s; t += step_s) {
      const auto joint = [&](double wanted, double& angle, double& rate) {
        rate += (w * w * (wanted - angle) - 2 * damping * w * rate) * step_s;
        angle += rate * step_s;
      };
      joint(command.roll_rad, angles.roll_rad, roll_rate_);
      joint(command.pitch_rad, angles.pitch_rad, pitch_rate_);
    }
  }
  GimbalAngles angles;

 private:
  double roll_rate_ = 0, pitch_rate_ = 0;
};

/// Runs a gimbal for a while with a pan-tilt that stands at its command of the step before.
GimbalStep settled(Gimbal& gimbal, double& time_s, double roll_deg, double pitch_deg, int steps = 100) {
  GimbalStep step = gimbal.follow(still(time_s, roll_deg, pitch_deg));
  for (int i = 0; i < steps; ++i) {
    gimbal.measured({time_s, step.command, false});
    time_s += period_s;
    step = gimbal.follow(still(time_s, roll_deg, pitch_deg));
  }
  return step;
}

}  // namespace

TEST_CASE("leveling angles put the optical axis along gravity, whatever attitude and mount") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> tilt(-60 * deg, 60 * deg), mount_tilt(-5 * deg, 5 * deg);
  for (int i = 0; i < 200; ++i) {
    const auto ned_from_body = attitude(tilt(random), tilt(random), 3 * tilt(random));
    const CameraMount mount{mount_tilt(random), mount_tilt(random), mount_tilt(random)};
    const Vector3d gravity_body = ned_from_body.conjugate() * Vector3d::UnitZ();
    const GimbalAngles angles = leveling_angles(gravity_body, mount);
    CHECK((gravity_in_camera(ned_from_body, angles, mount) - Vector3d::UnitZ()).norm() < 1e-9);
    CHECK(std::abs(angles.roll_rad) < 70 * deg);  // and not the other way round
  }
}

TEST_CASE("without a mount's error they are minus the aircraft's roll and pitch") {
  const Vector3d gravity_body = attitude(12 * deg, -20 * deg, 2).conjugate() * Vector3d::UnitZ();
  const GimbalAngles angles = leveling_angles(gravity_body, {});
  CHECK(angles.roll_rad == Approx(-12 * deg));
  CHECK(angles.pitch_rad == Approx(20 * deg));
}

TEST_CASE("commands keep the limits and the rate") {
  Gimbal gimbal(GimbalSettings{}, {});
  gimbal.measured({10, {}, false});
  GimbalAngles last = gimbal.follow(still(10, 0, 0)).command;
  for (int i = 1; i <= 60; ++i) {
    const GimbalAngles command = gimbal.follow(still(10 + i * period_s, 45, -17)).command;
    CHECK(std::abs(command.roll_rad - last.roll_rad) <= 120 * deg * period_s + 1e-9);
    CHECK(std::abs(command.pitch_rad - last.pitch_rad) <= 120 * deg * period_s + 1e-9);
    last = command;
  }
  CHECK(last.roll_rad == Approx(-30 * deg));
  CHECK(last.pitch_rad == Approx(17 * deg).epsilon(1e-2));  // the rest of it is still being smoothed
}

TEST_CASE("a restarted process starts from where the pan-tilt stands") {
  Gimbal gimbal(GimbalSettings{}, {});
  gimbal.measured({10, {8 * deg, 0}, false});
  CHECK(gimbal.follow(still(10.01, 0, 0)).command.roll_rad == Approx((8 - 120 * period_s) * deg));
}

TEST_CASE("on a rolling aircraft the lead keeps the camera level, without it the pan-tilt lags") {
  // 10 deg at 0.5 Hz: up to 31 deg/s, of which 25 ms are 0.8 deg
  const auto worst_deg = [](double lag_s) {
    GimbalSettings settings;
    settings.lag_s = lag_s;
    Gimbal gimbal(settings, {});
    PanTilt pan_tilt;
    double worst_rad = 0;
    for (int i = 0; i < 500; ++i) {
      const double t = i * period_s, w = std::numbers::pi;
      const double roll = 10 * deg * std::sin(w * t), rate = 10 * deg * w * std::cos(w * t);
      gimbal.measured({t, pan_tilt.angles, false});
      const GimbalStep step = gimbal.follow({t, attitude(roll, 0, 0), {rate, 0, 0}});
      if (t > 1) worst_rad = std::max(worst_rad, step.level.off_level_rad.value());
      pan_tilt.move(step.command, period_s);
    }
    return worst_rad / deg;
  };
  CHECK(worst_deg(0) > 0.6);
  CHECK(worst_deg(GimbalSettings{}.lag_s) < 0.2);
}

TEST_CASE("noise of the attitude does not shake the camera") {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, 0.5 * deg);
  Gimbal gimbal(GimbalSettings{}, {});
  double squares = 0;
  constexpr int steps = 2000;
  for (int i = 0; i < steps; ++i) {
    const double pitch_rad = noise(random), roll_rad = noise(random);
    const auto seen = attitude(roll_rad, pitch_rad, 0);
    const GimbalAngles command = gimbal.follow({i * period_s, seen, Vector3d::Zero()}).command;
    if (i >= 100) squares += command.roll_rad * command.roll_rad;
  }
  CHECK(std::sqrt(squares / (steps - 100)) < 0.15 * deg);
}

TEST_CASE("how level the camera is, is told from the measured angles at their own time") {
  Gimbal gimbal(GimbalSettings{}, {});
  gimbal.measured({10, {-5 * deg, 2 * deg}, false});
  CHECK(gimbal.follow(still(10.01, 5, 1)).level.off_level_rad.value() == Approx(3 * deg).epsilon(1e-6));

  // rolling at 20 deg/s, level when it was measured 15 ms ago
  Gimbal rolling(GimbalSettings{}, {});
  rolling.measured({10, {-5 * deg, 0}, false});
  const AttitudeReading now{10.015, attitude(5.3 * deg, 0, 0), {20 * deg, 0, 0}};
  CHECK(rolling.follow(now).level.off_level_rad.value() < 1e-6);
}

TEST_CASE("the mount that is told is held level, not the platform") {
  const CameraMount mount{2 * deg, 0, 0};
  Gimbal gimbal(GimbalSettings{}, mount);
  double t = 10;
  const GimbalStep step = settled(gimbal, t, 0, 0);
  CHECK(step.command.roll_rad == Approx(-2 * deg).epsilon(1e-3));
  CHECK(step.level.off_level_rad.value() < 0.01 * deg);
}

TEST_CASE("a pan-tilt that does not follow is stuck, after its time and no earlier") {
  Gimbal gimbal(GimbalSettings{}, {});
  double t = 10;
  CHECK(settled(gimbal, t, 0, 0).level.status == GimbalStatus::ok);
  const double moved_s = t;
  double stuck_s = 0;
  for (int i = 0; i < 60; ++i, t += period_s) {
    gimbal.measured({t, {}, false});  // stays where it was
    const bool stuck = gimbal.follow(still(t, 8, 0)).level.status == GimbalStatus::stuck;
    if (stuck && stuck_s == 0) stuck_s = t;
  }
  CHECK(stuck_s - moved_s > 0.5);
  CHECK(stuck_s - moved_s < 0.8);
  gimbal.measured({t, {-8 * deg, 0}, false});
  CHECK(gimbal.follow(still(t, 8, 0)).level.status == GimbalStatus::ok);
}

TEST_CASE("a pan-tilt that follows a fast roll is not stuck") {
  Gimbal gimbal(GimbalSettings{}, {});
  PanTilt pan_tilt;
  for (int i = 0; i < 500; ++i) {
    const double t = i * period_s, w = 2 * std::numbers::pi * 0.5;  // up to 63 deg/s
    gimbal.measured({t, pan_tilt.angles, false});
    const GimbalStep step = gimbal.follow(
        {t, attitude(20 * deg * std::sin(w * t), 0, 0), {20 * deg * w * std::cos(w * t), 0, 0}});
    CHECK(step.level.status == GimbalStatus::ok);
    pan_tilt.move(step.command, period_s);
  }
}

TEST_CASE("an aircraft that leans further than the joints reach is at the limit") {
  Gimbal gimbal(GimbalSettings{}, {});
  double t = 10;
  const GimbalStep step = settled(gimbal, t, 35, 0);
  CHECK(step.level.status == GimbalStatus::at_limit);
  CHECK(step.level.off_level_rad.value() == Approx(5 * deg).epsilon(1e-3));
  gimbal.measured({t, {-25 * deg, 0}, true});  // its own stop comes first
  CHECK(gimbal.follow(still(t + period_s, 26, 0)).level.status == GimbalStatus::at_limit);
}

TEST_CASE("a silent pan-tilt is late, on the clock of the attitude") {
  Gimbal never_heard(GimbalSettings{}, {});
  CHECK(never_heard.follow(still(10, 0, 0)).level.status == GimbalStatus::ok);
  CameraLevel level;
  for (double t = 10.02; t < 10.3; t += period_s) level = never_heard.follow(still(t, 0, 0)).level;
  CHECK(level.status == GimbalStatus::late);
  CHECK_FALSE(level.off_level_rad);

  Gimbal gimbal(GimbalSettings{}, {});
  double t = 10;
  settled(gimbal, t, 0, 0);
  for (const double until = t + 0.19; t < until; t += period_s) level = gimbal.follow(still(t, 0, 0)).level;
  CHECK(level.status == GimbalStatus::ok);
  for (const double until = t + 0.1; t < until; t += period_s) level = gimbal.follow(still(t, 0, 0)).level;
  CHECK(level.status == GimbalStatus::late);
  gimbal.measured({t, {}, false});
  CHECK(gimbal.follow(still(t, 0, 0)).level.status == GimbalStatus::ok);
}

TEST_CASE("time that goes back, or a gap, starts anew from what is seen") {
  Gimbal gimbal(GimbalSettings{}, {});
  double t = 1000;
  settled(gimbal, t, 10, 0);
  gimbal.measured({5, {}, false});
  CHECK(gimbal.follow(still(5, 0, 0)).level.off_level_rad.value() < 1e-6);  // nothing of the old attitude
  gimbal.measured({8, {-10 * deg, 0}, false});
  CHECK(gimbal.follow(still(8, 10, 0)).level.off_level_rad.value() < 1e-6);
}

TEST_CASE("a rate that no body has spoils its own step only") {
  Gimbal gimbal(GimbalSettings{}, {});
  double t = 1000;
  settled(gimbal, t, 10, 5);
  AttitudeReading absurd = still(t += period_s, 10, 5);
  absurd.rate_body_radps = Vector3d::Constant(1e300);
  gimbal.follow(absurd);
  const GimbalStep after = settled(gimbal, t += period_s, 10, 5, 3);
  CHECK(after.command.roll_rad == Approx(-10 * deg).margin(1e-6));
  CHECK(after.command.pitch_rad == Approx(-5 * deg).margin(1e-6));
}
