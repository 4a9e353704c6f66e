// Whether the covariance of a pose is that of its errors, over ranges, tilts, noises and hidden shares.
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstdlib>

#include "pose_proc/layout_pose.hpp"
#include "pose_proc/pose.hpp"
#include "tests/support/measured_circle.hpp"

using namespace stevedore;

namespace {

const Pinhole camera{640, 480, 337, 337, 319.5, 239.5};
constexpr double deg = std::numbers::pi / 180;
constexpr double within_95 = 7.815;  // chi squared, three degrees of freedom

struct Cell {
  double depth_m, tilt_deg, sigma_px, hidden_share;
};

struct Tally {
  int count = 0, covered = 0, unsolved = 0;
  double nees = 0;

  void add(const Eigen::Vector3d& error_m, const Eigen::Matrix3d& covariance_m2) {
    const double d2 = error_m.dot(covariance_m2.ldlt().solve(error_m));
    ++count;
    covered += d2 < within_95;
    nees += d2;
  }
  [[nodiscard]] double coverage() const { return static_cast<double>(covered) / count; }
  [[nodiscard]] double mean_nees() const { return nees / count / 3; }
};

double range(std::mt19937& random, double from, double to) {
  return std::uniform_real_distribution<double>(from, to)(random);
}

Circle random_circle(double depth_m, double tilt_deg, std::mt19937& random) {
  return circle_at(camera, range(random, 60, 580), range(random, 60, 420), depth_m, tilt_deg * deg,
                   range(random, -std::numbers::pi, std::numbers::pi));
}

std::optional<EllipseFit> measured(const Circle& circle, double sigma_px, double hidden_share,
                                   std::mt19937& random) {
  const auto ellipse = image_of(camera, circle);
  if (!ellipse) return std::nullopt;
  return fitted(edge_points(*ellipse, sigma_px, hidden_share, random), *ellipse, sigma_px);
}

CircleSolution right_one(const std::array<CircleSolution, 2>& solutions, const Circle& truth) {
  const auto off = [&](const CircleSolution& s) {
    return (s.center_camera_m - truth.center_m).norm() + (s.normal_camera - truth.normal).norm();
  };
  return off(solutions[0]) <= off(solutions[1]) ? solutions[0] : solutions[1];
}

Tally tally_of(const Cell& cell, int draws, std::mt19937& random) {
  Tally tally;
  for (int i = 0; i < draws; ++i) {
    const Circle circle = random_circle(cell.depth_m, cell.tilt_deg, random);
    const auto fit = measured(circle, cell.sigma_px, cell.hidden_share, random);
    const auto pair = fit ? conic_pose(*fit, camera, circle.radius_m) : std::nullopt;
    if (!pair) {
      ++tally.unsolved;
      continue;
    }
    const CircleSolution best = right_one(pair->solutions, circle);
    tally.add(best.center_camera_m - circle.center_m, best.covariance_m2);
  }
  return tally;
}

}  // namespace

TEST_CASE("one circle: 95 % of the errors are in the 95 % ellipsoid, in every cell") {
  const bool show = std::getenv("STEVEDORE_SHOW") != nullptr;
  std::mt19937 random(11);
  Tally all;
  for (const double depth : {1.6, 3.0, 5.0, 8.0})
    for (const double tilt : {0.0, 5.0, 15.0, 30.0})
      for (const double sigma : {0.05, 0.2})
        for (const double hidden : {0.0, 0.33, 0.5}) {
          const Tally tally = tally_of({depth, tilt, sigma, hidden}, 1000, random);
          INFO(depth << " m, " << tilt << " deg, " << sigma << " px, hidden " << hidden);
          if (show)
            std::printf("%4.1f m %4.0f deg %4.2f px hidden %4.2f: coverage %.3f NEES/3 %.2f unsolved %d\n",
                        depth, tilt, sigma, hidden, tally.coverage(), tally.mean_nees(), tally.unsolved);
          CHECK(tally.unsolved < 10);
          CHECK(tally.coverage() > 0.90);
          CHECK(tally.coverage() < 0.99);
          CHECK(tally.mean_nees() > 0.85);
          CHECK(tally.mean_nees() < 1.25);
          all.count += tally.count;
          all.covered += tally.covered;
        }
  INFO("overall");
  CHECK(all.coverage() > 0.93);
  CHECK(all.coverage() < 0.97);
}

TEST_CASE("one circle that faces the camera") {
  std::mt19937 random(12);
  for (const double depth : {1.6, 5.0})
    for (const double theta : {0.0, 1.0, 2.0, 4.0}) {
      Tally tally;
      for (int i = 0; i < 1000; ++i) {
        const Circle circle = circle_at(camera, 319.5, 239.5, depth, theta * deg, range(random, -3.1, 3.1));
        const auto fit = measured(circle, 0.1, 0, random);
        const auto pair = conic_pose(*fit, camera, circle.radius_m);
        REQUIRE(pair);
        const CircleSolution best = right_one(pair->solutions, circle);
        tally.add(best.center_camera_m - circle.center_m, best.covariance_m2);
      }
      if (std::getenv("STEVEDORE_SHOW"))
        std::printf("face %g m %g deg: %.3f %.2f\n", depth, theta, tally.coverage(), tally.mean_nees());
      INFO(depth << " m, " << theta << " deg: " << tally.coverage() << " " << tally.mean_nees());
      CHECK(tally.coverage() > 0.90);
      CHECK(tally.mean_nees() > 0.7);
      CHECK(tally.mean_nees() < 1.35);
    }
}

TEST_CASE("both edges of a ring: the covariance holds, and is smaller than one edge's") {
  std::mt19937 random(13);
  for (const double depth : {1.6, 5.0}) {
    Tally tally;
    double one_edge = 0, both_edges = 0;
    for (int i = 0; i < 600; ++i) {
      const Circle outer = random_circle(depth, 20, random);
      Circle inner = outer;
      inner.radius_m = 0.4;
      const auto outer_fit = measured(outer, 0.1, 0, random), inner_fit = measured(inner, 0.1, 0, random);
      REQUIRE(outer_fit);
      REQUIRE(inner_fit);
      const auto alone = conic_pose(*outer_fit, camera, 0.5);
      REQUIRE(alone);
      const auto pose = estimate_pose({*outer_fit, *inner_fit, Label::circle, {}}, camera, {}, {});
      REQUIRE(pose.solutions.size() == 2);
      const CircleSolution best = right_one({pose.solutions[0].circle, pose.solutions[1].circle}, outer);
      tally.add(best.center_camera_m - outer.center_m, best.covariance_m2);
      one_edge += right_one(alone->solutions, outer).covariance_m2.trace();
      both_edges += best.covariance_m2.trace();
    }
    INFO(depth << " m: " << tally.coverage() << " " << tally.mean_nees());
    CHECK(tally.coverage() > 0.90);
    CHECK(tally.mean_nees() > 0.85);
    CHECK(tally.mean_nees() < 1.25);
    CHECK(both_edges < 0.9 * one_edge);
  }
}

TEST_CASE("the circles of a deck: the covariance holds, and the normal is far better than any alone") {
  std::mt19937 random(14);
  for (const std::size_t count : {2u, 4u}) {
    Tally centers;
    double normal_d2 = 0, alone = 0, together = 0;
    int normals = 0, on_deck = 0;
    for (int i = 0; i < 400; ++i) {
      const Circle first = circle_at(camera, range(random, 250, 390), range(random, 180, 300),
                                     range(random, 3, 7), range(random, 3, 20) * deg, range(random, -3, 3));
      const Eigen::Vector3d x = first.normal.unitOrthogonal(), y = first.normal.cross(x);
      std::vector<Circle> circles(count, first);
      for (std::size_t k = 1; k < count; ++k)
        circles[k].center_m += 1.6 * ((k & 1 ? 1.0 : 0.0) * x + (k & 2 ? 1.0 : 0.0) * y);
      std::vector<MarkImage> marks;
      for (const Circle& circle : circles) {
        const auto fit = measured(circle, 0.1, 0, random);
        REQUIRE(fit);
        marks.push_back({*fit, {}, Label::circle, {}});
      }
      const auto poses = estimate_poses(marks, camera, {Gravity{-first.normal, 0}, {}}, {});
      const auto lone = conic_pose(marks[0].outer, camera, 0.5);
      alone += right_one(lone->solutions, first).normal_covariance_rad2.trace();
      for (std::size_t k = 0; k < count; ++k) {
        REQUIRE(poses[k].solutions.size() == 2);
        if (poses[k].deck < 0) continue;
        ++on_deck;
        const CircleSolution& s = poses[k].solutions[0].circle;
        centers.add(s.center_camera_m - circles[k].center_m, s.covariance_m2);
        if (k > 0) continue;
        const Eigen::Vector3d off(x.dot(s.normal_camera), y.dot(s.normal_camera), 0);
        Eigen::Matrix2d c;
        c << x.dot(s.normal_covariance_rad2 * x), x.dot(s.normal_covariance_rad2 * y),
            x.dot(s.normal_covariance_rad2 * y), y.dot(s.normal_covariance_rad2 * y);
        normal_d2 += off.head<2>().dot(c.inverse() * off.head<2>());
        together += s.normal_covariance_rad2.trace();
        ++normals;
      }
    }
    INFO(count << " circles: " << centers.coverage() << " " << centers.mean_nees() << " normal "
               << normal_d2 / normals / 2 << " on deck " << on_deck << " variance " << together / normals
               << " of " << alone / 400);
    CHECK(on_deck > 0.98 * 400 * static_cast<double>(count));
    CHECK(centers.coverage() > 0.90);
    CHECK(centers.mean_nees() > 0.85);
    CHECK(centers.mean_nees() < 1.25);
    CHECK(normal_d2 / normals / 2 > 0.8);
    CHECK(normal_d2 / normals / 2 < 1.3);
    CHECK(together / normals < alone / 400 / (count == 4 ? 10 : 1.5));
  }
}

TEST_CASE("four circles of a known layout: turn and origin, with the covariance that they have") {
  std::mt19937 random(15);
  const std::vector<Eigen::Vector2d> plan_m{{0.8, 0.8}, {0.8, -0.8}, {-0.8, -0.8}, {-0.8, 0.8}};
  constexpr int draws = 500;
  double d2 = 0, chi_squared = 0, heading_rad2 = 0, range_m2 = 0, range_alone_m2 = 0;
  for (int i = 0; i < draws; ++i) {
    const Circle middle = circle_at(camera, range(random, 260, 380), range(random, 190, 290),
                                    range(random, 3.5, 6), range(random, 0, 20) * deg, range(random, -3, 3));
    Eigen::Matrix3d camera_from_deck;
    const Eigen::Vector3d x =
        Eigen::AngleAxisd(range(random, -3, 3), middle.normal) * middle.normal.unitOrthogonal();
    camera_from_deck << x, (-middle.normal).cross(x), -middle.normal;
    std::vector<LayoutMark> marks;
    for (const Eigen::Vector2d& place : plan_m) {
      Circle circle = middle;
      circle.center_m += camera_from_deck.leftCols<2>() * place;
      const auto fit = measured(circle, 0.1, 0, random);
      REQUIRE(fit);
      const CircleSolution alone = right_one(conic_pose(*fit, camera, 0.5)->solutions, circle);
      marks.push_back({edge_image(*fit, camera), 0.5, place, alone.center_camera_m});
      if (marks.size() == 1)
        range_alone_m2 += std::pow(alone.center_camera_m.norm() - circle.center_m.norm(), 2);
    }
    const auto pose = layout_pose(marks, middle.normal);
    REQUIRE(pose);
    const Eigen::AngleAxisd turn(camera_from_deck * pose->camera_from_deck.transpose());
    Eigen::Matrix<double, 6, 1> error;
    error << turn.angle() * turn.axis(), middle.center_m - pose->origin_camera_m;
    d2 += error.dot(pose->covariance.ldlt().solve(error));
    chi_squared += pose->chi_squared / pose->freedom;
    heading_rad2 += std::pow(turn.angle() * turn.axis().dot(middle.normal), 2);
    range_m2 += std::pow(pose->origin_camera_m.norm() - middle.center_m.norm(), 2);
  }
  INFO("NEES/6 " << d2 / draws / 6 << ", chi^2 " << chi_squared / draws << ", heading "
                 << std::sqrt(heading_rad2 / draws) / deg << " deg, range " << std::sqrt(range_m2 / draws)
                 << " m, of one circle alone " << std::sqrt(range_alone_m2 / draws));
  CHECK(d2 / draws / 6 > 0.85);
  CHECK(d2 / draws / 6 < 1.25);
  CHECK(chi_squared / draws == Approx(1).margin(0.1));
  CHECK(std::sqrt(heading_rad2 / draws) < 0.05 * deg);
  CHECK(range_m2 < range_alone_m2 / 4);
  if (std::getenv("STEVEDORE_SHOW"))
    std::printf("layout: NEES/6 %.2f heading %.4f deg range %.2f mm, alone %.2f mm\n", d2 / draws / 6,
                std::sqrt(heading_rad2 / draws) / deg, 1e3 * std::sqrt(range_m2 / draws),
                1e3 * std::sqrt(range_alone_m2 / draws));
}
