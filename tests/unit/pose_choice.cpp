#include "pose_proc/solution_choice.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

using namespace stevedore;

namespace {

constexpr double deg = std::numbers::pi / 180;

/// Two metres ahead, the normal leaning by tilt to the right from straight towards the camera.
CircleSolution leaning(double tilt_deg, double sigma_deg = 0) {
  CircleSolution circle;
  circle.center_camera_m = {0, 0, 2};
  circle.normal_camera = {std::sin(tilt_deg * deg), 0, -std::cos(tilt_deg * deg)};
  circle.covariance_m2 = Eigen::Matrix3d::Identity() * 1e-4;
  const Eigen::Matrix3d across =
      Eigen::Matrix3d::Identity() - circle.normal_camera * circle.normal_camera.transpose();
  circle.normal_covariance_rad2 = std::pow(sigma_deg * deg, 2) * across;
  return circle;
}

double probability_under(const ExpectedNormal& expected, double sigma_deg) {
  const CircleSolution a = leaning(5, sigma_deg), b = leaning(-20, sigma_deg);
  const double density_a = density(expected, a.normal_camera, a.normal_covariance_rad2);
  const double density_b = density(expected, b.normal_camera, b.normal_covariance_rad2);
  return density_a / (density_a + density_b);
}

PreviousChoice believed(double first_deg, double second_deg, double probability) {
  return {{leaning(first_deg).normal_camera, leaning(second_deg).normal_camera}, probability};
}

const std::array<CircleSolution, 2> both{leaning(5), leaning(-20)};

}  // namespace

TEST_CASE("normals are expected against gravity, with the deck's and the attitude's errors") {
  PoseSettings settings;
  settings.attitude_sigma_deg = 2;
  settings.deck_tilt_sigma_deg = 6;
  const ExpectedNormal level = expected_normal(Gravity{{0, 0.6, 0.8}, 3 * deg}, settings);
  CHECK((level.normal_camera + Eigen::Vector3d(0, 0.6, 0.8)).norm() < 1e-12);
  CHECK(level.variance_rad2 == Approx((9 + 4 + 36) * deg * deg));
  const ExpectedNormal ahead = expected_normal({}, settings);
  CHECK((ahead.normal_camera + Eigen::Vector3d::UnitZ()).norm() < 1e-12);
  CHECK(ahead.variance_rad2 == Approx((100 + 36) * deg * deg));
}

TEST_CASE("the density of a normal is Gaussian about what is expected, integrates to one and has a floor") {
  const ExpectedNormal expected{leaning(0).normal_camera, std::pow(4 * deg, 2)};
  double sum = 0;
  for (double tilt = 0.05; tilt < 90; tilt += 0.1)
    sum += density(expected, leaning(tilt).normal_camera, 0.0) * 2 * std::numbers::pi * std::sin(tilt * deg) *
           0.1 * deg;
  CHECK(sum == Approx(1).epsilon(0.01));
  const CircleSolution noisy = leaning(6, 3);  // variances add: 16 + 9
  const double near = density(expected, leaning(0, 3).normal_camera, noisy.normal_covariance_rad2);
  const double far = density(expected, noisy.normal_camera, noisy.normal_covariance_rad2);
  CHECK(far / near == Approx(std::exp(-36.0 / (2 * 25))).epsilon(0.02));
  CHECK(density(expected, noisy.normal_camera, std::pow(3 * deg, 2)) == Approx(far).epsilon(0.02));
  const auto at = [&](double tilt) { return density(expected, leaning(tilt).normal_camera, 0.0); };
  CHECK(at(60) / at(80) == Approx(1).epsilon(0.01));  // neither is near: no evidence
}

TEST_CASE("noise of the normals makes the choice less sure") {
  const ExpectedNormal expected{leaning(-3).normal_camera, std::pow(4 * deg, 2)};
  CHECK(probability_under(expected, 10) < probability_under(expected, 0));
  CHECK(probability_under(expected, 10) > 0.5);
}

TEST_CASE("the previous frame decides by the likeness of the normals, as far as it was believed") {
  const auto probability = [&](const PreviousChoice& previous) {
    return probability_of({0, carried_over(both, previous, {}), 1.0 / 30});
  };
  CHECK(probability(believed(6, -19, 0.9)) == Approx(0.9).margin(0.01));
  CHECK(probability(believed(-19, 6, 0.7)) == Approx(0.3).margin(0.01));
  CHECK(probability(believed(-7, -8, 1)) == Approx(0.5).margin(0.2));  // like neither
  CHECK(carried_over(both, believed(6, -19, 0.9), {}).share > 0.95);
  CHECK(carried_over(both, believed(-7, -8, 1), {}).share < 0.2);
  PreviousChoice long_ago = believed(6, -19, 0.9);
  long_ago.elapsed_s = 5;
  CHECK(probability(long_ago) < 0.8);
  CHECK(probability(long_ago) > 0.5);
}

TEST_CASE("after the first frame evidence counts by the time gone by") {
  const double once = probability_of({1, {}, 0});
  LogOdds odds{1, Carried{0, 1}, 1.0 / 30};
  for (int i = 0; i < 45; ++i)
    odds.before->log_odds = std::log(probability_of(odds) / (1 - probability_of(odds)));
  CHECK(once == Approx(1 / (1 + std::exp(-1.0))).epsilon(1e-3));
  CHECK(probability_of(odds) == Approx(once).margin(0.01));             // 45 frames: one and a half seconds
  CHECK(probability_of({1, Carried{0, 0}, 1.0 / 30}) == Approx(once));  // nothing of it was carried over
  CHECK(probability_of({40, Carried{40, 1}, 1}) < 0.9996);              // never quite sure
}

TEST_CASE("the beam tells planes apart by their distance along it, and little when it hits something else") {
  const std::array<CircleSolution, 2> planes{leaning(15, 0.2), leaning(-15, 0.2)};
  BeamRange beam;
  beam.origin_camera_m = {0.4, 0, 0};
  const auto range_to = [&](double tilt_deg) { return 2 - 0.4 * -std::tan(tilt_deg * deg); };
  beam.range_m = range_to(15);
  CHECK(beam_log_odds(planes, beam) > 2);
  beam.range_m = range_to(-15);
  CHECK(beam_log_odds(planes, beam) < -2);
  beam.range_m = 3.5;  // the ground beside the deck
  CHECK(std::abs(beam_log_odds(planes, beam)) < 0.01);
}

TEST_CASE("what weighed most is named") {
  CHECK(chosen_by({2, {}, 0}, true) == ChosenBy::attitude);
  CHECK(chosen_by({2, {}, 0}, false) == ChosenBy::optical_axis);
  CHECK(chosen_by({2, Carried{1, 1}, 1.0 / 30}, true) == ChosenBy::continuity);
  CHECK(chosen_by({200, Carried{1, 1}, 1.0 / 30}, true) == ChosenBy::attitude);
}
