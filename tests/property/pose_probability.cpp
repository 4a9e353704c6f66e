// Whether the solution that is chosen is the right one, and as often as its probability says.
#include <array>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>

#include "pose_proc/pose.hpp"
#include "pose_proc/ring_pose.hpp"
#include "tests/support/measured_circle.hpp"

using namespace stevedore;

namespace {

const Pinhole camera{640, 480, 337, 337, 319.5, 239.5};
constexpr double deg = std::numbers::pi / 180;

double range(std::mt19937& random, double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(random);
}

/// A direction turned by a normal variable about each of the two axes across it.
Eigen::Vector3d turned(const Eigen::Vector3d& direction, double sigma_rad, std::mt19937& random) {
  std::normal_distribution<double> normal(0, sigma_rad);
  const Eigen::Vector3d x = direction.unitOrthogonal(), y = direction.cross(x);
  return (direction + normal(random) * x + normal(random) * y).normalized();
}

struct Seen {
  Circle circle;
  Eigen::Vector3d up_camera;  ///< true
};

/// The camera leans by up to max_lean_deg, the deck from level by its sigma.
Seen random_circle(double deck_sigma_deg, double max_lean_deg, double depth_m, std::mt19937& random) {
  const double lean = range(random, 0, max_lean_deg) * deg, azimuth = range(random, -3.15, 3.15);
  const Eigen::Vector3d up(std::sin(lean) * std::cos(azimuth), std::sin(lean) * std::sin(azimuth),
                           -std::cos(lean));
  Circle circle{depth_m * camera.unproject({range(random, 60, 580), range(random, 60, 420)}),
                turned(up, deck_sigma_deg * deg, random), 0.5};
  return {circle, up};
}

std::optional<EllipseFit> measured(const Circle& circle, double sigma_px, double hidden,
                                   std::mt19937& random) {
  const auto ellipse = image_of(camera, circle);
  return ellipse ? fitted(edge_points(*ellipse, sigma_px, hidden, random), *ellipse, sigma_px) : std::nullopt;
}

bool is_right(const CirclePose& pose, const Circle& truth) {
  const auto off = [&](std::size_t i) {
    return (pose.solutions[i].circle.normal_camera - truth.normal).norm();
  };
  return off(0) <= off(1);
}

double theta_of(const Circle& circle) {
  return std::acos(-circle.normal.dot(circle.center_m.normalized()));
}

/// Ten bins between a half and one.
struct Calibration {
  std::array<double, 10> sum{};
  std::array<int, 10> count{}, right{};
  int total = 0;

  void add(double probability, bool is_right_one) {
    const auto bin = static_cast<std::size_t>(std::clamp((probability - 0.5) * 20, 0.0, 9.0));
    sum[bin] += probability;
    ++count[bin];
    right[bin] += is_right_one;
    ++total;
  }
  [[nodiscard]] double error(const char* name) const {
    double out = 0;
    for (std::size_t i = 0; i < 10; ++i) {
      if (count[i] == 0) continue;
      if (std::getenv("STEVEDORE_SHOW"))
        std::printf("%s: said %.3f, right %.3f of %d\n", name, sum[i] / count[i],
                    static_cast<double>(right[i]) / count[i], count[i]);
      out += std::abs(sum[i] - right[i]) / total;
    }
    return out;
  }
};

}  // namespace

TEST_CASE("one circle on a level deck, attitude within 1 degree: right in 99.5 % from 4 degrees on") {
  std::mt19937 random(21);
  int count = 0, wrong = 0, surely_wrong = 0;
  for (int i = 0; i < 20000; ++i) {
    const Seen seen = random_circle(0, 30, range(random, 1.2, 4.0), random);  // semi-axes of 40 px and more
    const auto fit = measured(seen.circle, 0.1, 0, random);
    if (!fit || fit->ellipse.a_px < 40) continue;
    const Gravity gravity{-turned(seen.up_camera, 1 * deg, random), 0};
    const CirclePose pose = estimate_pose({*fit, {}, Label::circle, {}}, camera, {gravity, {}}, {});
    REQUIRE(pose.solutions.size() == 2);
    const bool right = is_right(pose, seen.circle);
    surely_wrong += !right && pose.solutions[0].probability > 0.99;
    if (theta_of(seen.circle) < 4 * deg) continue;
    ++count;
    wrong += !right;
  }
  INFO(wrong << " wrong of " << count);
  CHECK(count > 15000);
  CHECK(wrong <= count / 200);
  CHECK(surely_wrong == 0);
}

TEST_CASE("probabilities come true: one circle, over decks, attitudes, ranges, noises and hidden shares") {
  std::mt19937 random(22);
  Calibration calibration, facing;  // of all, and of those that nearly face the camera, where it is hard
  for (int i = 0; i < 30000; ++i) {
    PoseSettings settings;
    settings.deck_tilt_sigma_deg = range(random, 0.5, 6);
    settings.attitude_sigma_deg = range(random, 0.2, 3);
    const Seen seen =
        random_circle(settings.deck_tilt_sigma_deg, range(random, 0, 30), range(random, 1.2, 12), random);
    const auto fit = measured(seen.circle, range(random, 0.03, 0.4), range(random, 0, 0.5), random);
    if (!fit) continue;
    const Gravity gravity{-turned(seen.up_camera, settings.attitude_sigma_deg * deg, random), 0};
    const CirclePose pose = estimate_pose({*fit, {}, Label::circle, {}}, camera, {gravity, {}}, settings);
    if (pose.solutions.size() < 2) continue;
    calibration.add(pose.solutions[0].probability, is_right(pose, seen.circle));
    if (theta_of(seen.circle) < 8 * deg)
      facing.add(pose.solutions[0].probability, is_right(pose, seen.circle));
  }
  CHECK(calibration.total > 29000);
  CHECK(calibration.error("one circle") < 0.02);
  CHECK(facing.total > 1000);
  CHECK(facing.error("facing") < 0.05);
}

TEST_CASE("probabilities come true: rings and the circles of a deck") {
  std::mt19937 random(23);
  Calibration rings, decks;
  for (int i = 0; i < 6000; ++i) {
    const PoseSettings settings;
    const double sigma_px = range(random, 0.05, 0.4);
    const Seen seen = random_circle(settings.deck_tilt_sigma_deg, 20, range(random, 2, 12), random);
    const Gravity gravity{-turned(seen.up_camera, settings.attitude_sigma_deg * deg, random), 0};
    const auto fit = measured(seen.circle, sigma_px, 0, random);
    Circle inner = seen.circle, other = seen.circle;
    inner.radius_m = 0.4;
    other.center_m += 1.6 * turned(other.normal.unitOrthogonal(), 0, random);
    const auto inner_fit = measured(inner, sigma_px, 0, random);
    const auto other_fit = other.center_m.z() > 1 ? measured(other, sigma_px, 0, random) : std::nullopt;
    if (!fit || !inner_fit || !other_fit) continue;
    const CirclePose ring =
        estimate_pose({*fit, *inner_fit, Label::circle, {}}, camera, {gravity, {}}, settings);
    if (ring.solutions.size() == 2) rings.add(ring.solutions[0].probability, is_right(ring, seen.circle));
    const auto two = estimate_poses({{*fit, {}, Label::circle, {}}, {*other_fit, {}, Label::circle, {}}},
                                    camera, {gravity, {}}, settings);
    if (two[0].solutions.size() == 2)
      decks.add(two[0].solutions[0].probability, is_right(two[0], seen.circle));
  }
  CHECK(rings.error("ring") < 0.02);
  CHECK(decks.error("two circles") < 0.02);
}

TEST_CASE(
    "two circles of a deck that leans by 3 degrees rms: right in 99.5 % from 4 degrees on, in one frame") {
  std::mt19937 random(24);
  int count = 0, wrong = 0, surely_wrong = 0;
  for (int i = 0; i < 8000; ++i) {
    const Seen seen = random_circle(3, 20, range(random, 1.6, 4.0), random);
    Circle other = seen.circle;
    other.center_m +=
        1.6 * (Eigen::AngleAxisd(range(random, -3.1, 3.1), other.normal) * other.normal.unitOrthogonal());
    if (other.center_m.z() < 1) continue;
    const auto fit = measured(seen.circle, 0.1, 0, random), other_fit = measured(other, 0.1, 0, random);
    if (!fit || !other_fit) continue;
    const Gravity gravity{-turned(seen.up_camera, 1 * deg, random), 0};
    const auto poses = estimate_poses({{*fit, {}, Label::circle, {}}, {*other_fit, {}, Label::circle, {}}},
                                      camera, {gravity, {}}, {});
    const bool right = is_right(poses[0], seen.circle);
    surely_wrong += !right && poses[0].solutions[0].probability > 0.99;
    if (theta_of(seen.circle) < 4 * deg) continue;
    ++count;
    wrong += !right;
  }
  INFO(wrong << " wrong of " << count << ", " << surely_wrong << " above 0.99");
  CHECK(count > 5000);
  CHECK(wrong <= count / 200);
  CHECK(surely_wrong == 0);
}

TEST_CASE(
    "probabilities come true: after two seconds of frames, where the two solutions are near each other") {
  std::mt19937 random(29);
  Calibration calibration;
  for (int i = 0; i < 15000; ++i) {
    const PoseSettings settings;
    const Seen seen = random_circle(settings.deck_tilt_sigma_deg, 5, range(random, 4, 8), random);
    const double sigma_px = range(random, 0.1, 0.4);
    const Gravity gravity{-turned(seen.up_camera, settings.attitude_sigma_deg * deg, random), 0};
    if (theta_of(seen.circle) > 12 * deg) continue;
    std::optional<PreviousChoice> previous;
    CirclePose pose;
    for (int frame = 0; frame < 20; ++frame) {  // 10 Hz; deck and attitude err all the time by the same
      const auto fit = measured(seen.circle, sigma_px, 0, random);
      if (!fit) continue;
      pose = estimate_pose({*fit, {}, Label::circle, previous}, camera, {gravity, {}}, settings);
      if (pose.solutions.size() < 2) continue;
      previous =
          PreviousChoice{{pose.solutions[0].circle.normal_camera, pose.solutions[1].circle.normal_camera},
                         pose.solutions[0].probability,
                         0.1};
    }
    if (pose.solutions.size() == 2)
      calibration.add(pose.solutions[0].probability, is_right(pose, seen.circle));
  }
  CHECK(calibration.total > 1000);
  CHECK(calibration.error("two seconds") < 0.05);
}

TEST_CASE("a cargo leans as the deck that it stands on does, which its circles tell better than gravity") {
  std::mt19937 random(30);
  int count = 0, wrong = 0, wrong_alone = 0;
  Calibration calibration;
  for (int i = 0; i < 4000; ++i) {
    PoseSettings settings;
    const Seen seen = random_circle(6, 20, range(random, 2.5, 6), random);
    settings.deck_tilt_sigma_deg = 6;
    const Circle& circle = seen.circle;
    const Eigen::Vector3d along = circle.normal.unitOrthogonal();
    Circle other = circle;
    other.center_m += 1.6 * (Eigen::AngleAxisd(range(random, -3.1, 3.1), circle.normal) * along);
    const Circle rim{circle.center_m + 0.3 * circle.normal, turned(circle.normal, 1 * deg, random),
                     settings.cargo_radius_m};
    if (other.center_m.z() < 1 || theta_of(rim) < 4 * deg) continue;
    const auto fit = measured(circle, 0.1, 0, random), other_fit = measured(other, 0.1, 0, random),
               rim_fit = measured(rim, 0.15, 0, random);
    if (!fit || !other_fit || !rim_fit) continue;
    const Gravity gravity{-turned(seen.up_camera, 1 * deg, random), 0};
    const MarkImage cargo{*rim_fit, {}, Label::cargo, {}};
    const CirclePose alone = estimate_pose(cargo, camera, {gravity, {}}, settings);
    const auto poses =
        estimate_poses({cargo, {*fit, {}, Label::circle, {}}, {*other_fit, {}, Label::circle, {}}}, camera,
                       {gravity, {}}, settings);
    if (poses[0].solutions.size() < 2 || alone.solutions.size() < 2) continue;
    ++count;
    wrong += !is_right(poses[0], rim);
    wrong_alone += !is_right(alone, rim);
    calibration.add(poses[0].solutions[0].probability, is_right(poses[0], rim));
  }
  INFO(wrong << " wrong, alone " << wrong_alone << ", of " << count);
  CHECK(count > 1500);
  CHECK(2 * wrong < wrong_alone);
  CHECK(calibration.error("cargo on deck") < 0.03);
}

TEST_CASE("a ring tells by itself which way it leans") {
  std::mt19937 random(25);
  int right = 0, count = 0;
  for (int i = 0; i < 500; ++i) {
    const Circle outer =
        circle_at(camera, range(random, 200, 440), range(random, 150, 330), range(random, 1.6, 3),
                  range(random, 20, 35) * deg, range(random, -3.1, 3.1));
    Circle inner = outer;
    inner.radius_m = 0.4;
    const auto outer_fit = measured(outer, 0.05, 0, random), inner_fit = measured(inner, 0.05, 0, random);
    if (theta_of(outer) < 6 * deg || !outer_fit || !inner_fit) continue;
    const auto alone = conic_pose(*outer_fit, camera, 0.5);
    REQUIRE(alone);
    const auto ring = ring_pose(*outer_fit, *inner_fit, camera, 0.5, alone->solutions);
    REQUIRE(ring);
    const auto off = [&](std::size_t k) { return (alone->solutions[k].normal_camera - outer.normal).norm(); };
    right += (ring->log_odds > 0) == (off(0) < off(1));
    ++count;
    // what is not of one ring is left out: an inner edge whose centre is elsewhere
    EllipseFit bucket = *inner_fit;
    bucket.ellipse.u_px += 6;
    REQUIRE_FALSE(ring_pose(*outer_fit, bucket, camera, 0.5, alone->solutions));
  }
  INFO(right << " of " << count);
  CHECK(count > 400);
  CHECK(right > 0.99 * count);
}

TEST_CASE(
    "four circles of a deck tell by themselves which way it leans, and a fifth that is elsewhere stays "
    "alone") {
  std::mt19937 random(26);
  PoseSettings blind;
  blind.camera_tilt_sigma_deg = 45;
  int right = 0, count = 0, stranger_alone = 0;
  for (int i = 0; i < 300; ++i) {
    const Circle first = circle_at(camera, range(random, 200, 300), range(random, 150, 240),
                                   range(random, 3, 6), range(random, 6, 25) * deg, range(random, -3.1, 3.1));
    const Eigen::Vector3d x = first.normal.unitOrthogonal(), y = first.normal.cross(x);
    std::vector<MarkImage> marks;
    for (int k = 0; k < 5; ++k) {
      Circle circle = first;
      circle.center_m += 1.6 * ((k & 1) * x + (k & 2) / 2 * y);
      if (k == 4) circle = circle_at(camera, 500, 100, 6, 30 * deg, range(random, -3.1, 3.1));
      const auto fit = measured(circle, 0.1, 0, random);
      REQUIRE(fit);
      marks.push_back({*fit, {}, Label::circle, {}});
    }
    const auto poses = estimate_poses(marks, camera, {}, blind);
    if (theta_of(first) < 4 * deg) continue;
    ++count;
    right += is_right(poses[0], first);
    stranger_alone += poses[4].deck != poses[0].deck;
  }
  INFO(right << " right, " << stranger_alone << " strangers alone, of " << count);
  CHECK(right > 0.98 * count);
  CHECK(stranger_alone > 0.95 * count);
}

TEST_CASE("edges that err twice as much as they say do not turn a level deck over") {
  std::mt19937 random(28);
  int wrong = 0, count = 0;
  for (int i = 0; i < 400; ++i) {
    const Circle first =
        circle_at(camera, range(random, 150, 300), range(random, 100, 240), range(random, 2.5, 5),
                  range(random, 0, 2) * deg, range(random, -3.1, 3.1));
    const Eigen::Vector3d x = first.normal.unitOrthogonal(), y = first.normal.cross(x);
    std::vector<MarkImage> marks;
    std::vector<Circle> circles;
    for (int k = 0; k < 4; ++k) {
      circles.push_back(first);
      circles.back().center_m += 1.3 * (k % 3 * x + k / 3 * y);
      auto fit = measured(circles.back(), 0.1, 0, random);
      REQUIRE(fit);
      fit->covariance /= 6;
      marks.push_back({*fit, {}, Label::circle, {}});
    }
    const Gravity gravity{Eigen::Vector3d::UnitZ(), 0};
    const auto poses = estimate_poses(marks, camera, {gravity, {}}, {});
    for (std::size_t k = 0; k < marks.size(); ++k) {
      if (poses[k].solutions.size() < 2 || theta_of(circles[k]) < 4 * deg) continue;
      ++count;
      wrong += !is_right(poses[k], circles[k]);
    }
  }
  CHECK(count > 1500);
  CHECK(wrong == 0);
}

TEST_CASE("a small ring's odds come true") {
  std::mt19937 random(27);
  int right = 0, count = 0;
  for (int i = 0; i < 500; ++i) {
    const Circle outer = circle_at(camera, 319.5, 239.5, range(random, 5, 8), range(random, 15, 30) * deg,
                                   range(random, -3.1, 3.1));
    Circle inner = outer;
    inner.radius_m = 0.4;
    const auto outer_fit = measured(outer, 0.1, 0, random), inner_fit = measured(inner, 0.1, 0, random);
    if (!outer_fit || !inner_fit) continue;
    const auto alone = conic_pose(*outer_fit, camera, 0.5);
    REQUIRE(alone);
    const auto ring = ring_pose(*outer_fit, *inner_fit, camera, 0.5, alone->solutions);
    if (!ring || std::abs(ring->log_odds) < 1) continue;
    const auto off = [&](std::size_t k) { return (alone->solutions[k].normal_camera - outer.normal).norm(); };
    right += (ring->log_odds > 0) == (off(0) < off(1));
    ++count;
  }
  INFO(right << " of " << count);
  CHECK(count > 50);
  CHECK(right > 0.75 * count);
}
