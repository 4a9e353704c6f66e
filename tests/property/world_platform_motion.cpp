// Platforms: velocities are the derivatives of places, and the courses keep to what is promised of them.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <set>
#include <stdexcept>

#include "sim_proc/world/platform_motion.hpp"

using namespace stevedore::world;

namespace {

constexpr double deg = std::numbers::pi / 180;

double rms(const Eigen::VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

}  // namespace

TEST_CASE("velocity is the derivative of position, angular velocity that of attitude") {
  constexpr double h_s = 1e-4;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const PlatformMotion motion(seed, static_cast<int>(seed % 2), static_cast<int>(seed % 5));
    for (double t_s = 0.3; t_s < 200; t_s += 7.7) {
      const Rigid before = motion.at(t_s - h_s), now = motion.at(t_s), after = motion.at(t_s + h_s);
      const Eigen::Vector3d velocity_mps = (after.position_ned_m - before.position_ned_m) / (2 * h_s);
      CHECK((velocity_mps - now.velocity_ned_mps).norm() < 1e-6);
      const Eigen::AngleAxisd turn(after.ned_from_local * before.ned_from_local.conjugate());
      const Eigen::Vector3d turning_radps = turn.angle() / (2 * h_s) * turn.axis();
      CHECK((turning_radps - now.angular_velocity_ned_radps).norm() < 1e-6);
    }
  }
}

TEST_CASE("for hours the platforms stay 15 to 30 m apart, within 60 m, off the pad, below 1.5 m/s") {
  std::set<Manner> manners;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    manners.insert(draw_formation(seed).manner);
    const PlatformMotion first(seed, 0, 0), second(seed, 1, 0);
    double nearest_m = 100, furthest_m = 0, fastest_mps = 0, least_m = 100, most_m = 0;
    for (double t_s = 0; t_s < 3 * 3600; t_s += 1.7) {
      const Rigid a = first.at(t_s), b = second.at(t_s);
      const double apart_m = (a.position_ned_m - b.position_ned_m).norm();
      nearest_m = std::min(nearest_m, apart_m), furthest_m = std::max(furthest_m, apart_m);
      for (const Rigid& rigid : {a, b}) {
        fastest_mps = std::max(fastest_mps, rigid.velocity_ned_mps.norm());
        const double from_pad_m = rigid.position_ned_m.head<2>().norm();
        least_m = std::min(least_m, from_pad_m), most_m = std::max(most_m, from_pad_m);
      }
    }
    INFO("seed " << seed);
    CHECK(nearest_m >= 15);
    CHECK(furthest_m <= 30);
    CHECK(fastest_mps <= 1.5);
    CHECK(fastest_mps > 0.5);
    CHECK(least_m > 7);  // a deck's half diagonal and the pad's: 3.5 m together
    CHECK(most_m < 60);
  }
  CHECK(manners.size() == 3);
}

TEST_CASE("heave and tilt have the rms of the sea state over an hour, and their periods") {
  const std::array<double, 5> heave_m{0, 0.05, 0.10, 0.25, 0.40}, tilt_deg{0, 0.7, 1.5, 3, 5};
  for (int sea_state = 0; sea_state <= 4; ++sea_state) {
    const PlatformMotion motion(7, 0, sea_state);
    constexpr int samples = 18000;
    Eigen::VectorXd down_m(samples), roll_rad(samples), pitch_rad(samples);
    for (int i = 0; i < samples; ++i) {
      const Rigid rigid = motion.at(0.2 * i);
      const Eigen::Matrix3d turned = rigid.ned_from_local.toRotationMatrix();
      down_m[i] = rigid.position_ned_m.z();
      pitch_rad[i] = -std::asin(turned(2, 0));
      roll_rad[i] = std::atan2(turned(2, 1), turned(2, 2));
    }
    const auto state = static_cast<std::size_t>(sea_state);
    const Eigen::VectorXd heave = down_m.array() - down_m.mean();
    CHECK(rms(heave) == Approx(heave_m[state]).epsilon(0.02).margin(1e-9));
    CHECK(rms(roll_rad) == Approx(tilt_deg[state] * deg).epsilon(0.02).margin(1e-9));
    CHECK(rms(pitch_rad) == Approx(tilt_deg[state] * deg).epsilon(0.02).margin(1e-9));
    CHECK(down_m.maxCoeff() < -0.5);  // a deck of 0.5 m stays out of the ground
    if (sea_state == 0) continue;
    int crossings = 0;
    for (int i = 1; i < samples; ++i) crossings += (heave[i] > 0) != (heave[i - 1] > 0);
    const double period_s = 2 * 0.2 * samples / crossings;
    CHECK(period_s > 5);
    CHECK(period_s < 7);
  }
  CHECK_THROWS_AS(sea_of(5), std::invalid_argument);
}

TEST_CASE("a speed profile drives, stands and comes back") {
  const SpeedProfile profile({{4, 1}, {6, 1}, {4, 0}, {5, 0}, {4, -1}, {6, -1}, {4, 0}});
  CHECK(profile.cycle_s() == 33);
  CHECK(profile.at(0).speed_mps == Approx(0).margin(1e-12));
  CHECK(profile.at(7).speed_mps == 1);
  CHECK(profile.at(10).distance_m == Approx(8));  // half of 4 s, and 6 s
  CHECK(profile.at(16).distance_m == Approx(10));
  CHECK(profile.at(16).speed_mps == 0);
  CHECK(profile.at(33).distance_m == Approx(0).margin(1e-12));
  CHECK(profile.at(33 + 7).distance_m == Approx(profile.at(7).distance_m));
  CHECK(profile.middle_m() == Approx(5));
}
