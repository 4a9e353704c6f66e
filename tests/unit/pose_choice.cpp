#include <Eigen/Geometry>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "pose_proc/solution_choice.hpp"

using namespace stevedore;

namespace {

constexpr double deg = std::numbers::pi / 180;

/// Two metres ahead, the normal leaning by tilt to the right from straight towards the camera.
CircleSolution leaning(double tilt_deg) {
  return {{0, 0, 2},
          {std::sin(tilt_deg * deg), 0, -std::cos(tilt_deg * deg)},
          Eigen::Matrix3d::Identity() * 1e-4,
          0};
}

Gravity gravity_for(double tilt_deg, double sigma_deg = 0) {
  return {-leaning(tilt_deg).normal_camera, sigma_deg * deg};
}

double tilt_of(const CircleSolution& solution) {
  return std::atan2(solution.normal_camera.x(), -solution.normal_camera.z()) / deg;
}

const std::array<CircleSolution, 2> both{leaning(5), leaning(-20)};

}  // namespace

TEST_CASE("gravity decides first: the circle lies on a level deck") {
  const PreviousChoice previous{leaning(5).normal_camera, 1};
  const SolutionChoice choice = choose_solution(both, gravity_for(-18), previous, {});
  CHECK(choice.chosen_by == ChosenBy::attitude);
  CHECK(tilt_of(choice.solutions[0]) == Approx(-20));
  CHECK(tilt_of(choice.solutions[1]) == Approx(5));
  CHECK(choice.probability[0] > 0.99);
  CHECK(choice.probability[0] + choice.probability[1] == Approx(1));
}

TEST_CASE("the probability is the ratio of Gaussian likelihoods of the two angles") {
  PoseSettings settings;
  settings.attitude_sigma_deg = 2;
  settings.deck_tilt_sigma_deg = 6;
  // gravity 3 deg: variance 9 + 4 + 36 = 49; off by 10 and 15 degrees
  const SolutionChoice choice = choose_solution(both, gravity_for(-5, 3), {}, settings);
  const double expected = 1 / (1 + std::exp((100.0 - 225.0) / (2 * 49)));
  CHECK(tilt_of(choice.solutions[0]) == Approx(5));
  CHECK(choice.probability[0] == Approx(expected));
}

TEST_CASE("noise of the normals makes the choice less sure") {
  auto noisy = both;
  for (auto& s : noisy) s.normal_variance_rad2 = std::pow(10 * deg, 2);
  const double sure = choose_solution(both, gravity_for(0), {}, {}).probability[0];
  const double unsure = choose_solution(noisy, gravity_for(0), {}, {}).probability[0];
  CHECK(unsure < sure);
  CHECK(unsure > 0.5);
}

TEST_CASE("without gravity the previous normal decides, as far as it was believed") {
  const auto after = [](double probability) {
    return choose_solution(both, {}, PreviousChoice{leaning(-19).normal_camera, probability}, {});
  };
  CHECK(after(1).chosen_by == ChosenBy::continuity);
  CHECK(tilt_of(after(1).solutions[0]) == Approx(-20));
  CHECK(after(1).probability[0] > 0.99);
  CHECK(after(0.7).probability[0] == Approx(0.7).margin(0.001));
}

TEST_CASE("with nothing else the normal nearer the optical axis is taken") {
  const SolutionChoice choice = choose_solution({both[1], both[0]}, {}, {}, {});
  CHECK(choice.chosen_by == ChosenBy::optical_axis);
  CHECK(tilt_of(choice.solutions[0]) == Approx(5));
  CHECK(choice.probability[0] > 0.5);
  CHECK(choice.probability[0] < 0.9);
}

TEST_CASE("two solutions that are one are equally probable") {
  const SolutionChoice choice = choose_solution({leaning(3), leaning(3)}, gravity_for(0), {}, {});
  CHECK(choice.probability[0] == Approx(0.5));
}
