// What poses cost, beside one cv::solvePnP of the same run. Lines named "..._of_8" are eight poses.
#include <benchmark/benchmark.h>

#include <Eigen/Dense>
#include <opencv2/calib3d.hpp>

#include "pose_proc/pose.hpp"

using namespace stevedore;

namespace {

const Pinhole camera{640, 480, 337, 337, 319.5, 239.5};
const PoseContext level{Gravity{Eigen::Vector3d(0.1, -0.05, 1).normalized(), 0.01}, {}};

EllipseFit fit_of(const Ellipse& ellipse) {
  EllipseFit fit{ellipse, EllipseCovariance::Zero()};
  fit.covariance.diagonal() << 0.0002, 0.0002, 0.0004, 0.0004, 0.0004 / (ellipse.a_px * ellipse.a_px);
  return fit;
}

/// The image of a circle of the deck that lies 4 m away and leans by some degrees; radius_m of its edge.
EllipseFit on_deck(double x_m, double y_m, double radius_m) {
  const Eigen::Vector3d n = -level.gravity->direction_camera, origin(0, 0, 4);
  const Eigen::Vector3d ex = n.unitOrthogonal(), ey = n.cross(ex);
  Eigen::Matrix3d plane;
  plane << radius_m * ex, radius_m * ey, origin + x_m * ex + y_m * ey;
  const Eigen::Matrix3d inverse = (camera.matrix() * plane).inverse();
  return fit_of(*ellipse_from_conic(inverse.transpose() * Eigen::Vector3d(1, 1, -1).asDiagonal() * inverse));
}

/// Two rows of four circles, 1.2 m apart.
std::vector<MarkImage> deck_of_8(bool rings) {
  std::vector<MarkImage> marks;
  for (int i = 0; i < 8; ++i) {
    const double x = 1.2 * (i % 4 - 1.5), y = 1.2 * (i / 4 - 0.5);
    MarkImage mark{on_deck(x, y, 0.5), {}, Label::circle, {}};
    if (rings) mark.inner = on_deck(x, y, 0.4);
    marks.push_back(mark);
  }
  return marks;
}

void solve_pnp(benchmark::State& state) {
  const cv::Matx33d intrinsics(337, 0, 319.5, 0, 337, 239.5, 0, 0, 1);
  const std::vector<cv::Point3d> circle{{0.5, 0, 0}, {0, -0.5, 0}, {-0.5, 0, 0}, {0, 0.5, 0}};
  const std::vector<cv::Point2d> image{{266.7, 354.5}, {191.3, 375.7}, {153.9, 306.9}, {229.3, 285.7}};
  cv::Vec3d turn, center_m;
  for (auto _ : state) {
    cv::solvePnP(circle, image, intrinsics, cv::noArray(), turn, center_m);
    benchmark::DoNotOptimize(center_m);
  }
}
BENCHMARK(solve_pnp)->Unit(benchmark::kMicrosecond);

void one(benchmark::State& state, const Ellipse& ellipse) {
  MarkImage mark{fit_of(ellipse), {}, Label::circle, {}};
  for (auto _ : state) {
    benchmark::DoNotOptimize(mark);
    benchmark::DoNotOptimize(estimate_pose(mark, camera, level, {}));
  }
}
BENCHMARK_CAPTURE(one, tilted, Ellipse{210.3, 330.7, 61.2, 48.9, 0.4})->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(one, facing, Ellipse{319.5, 239.5, 61.201, 61.2, 0.4})->Unit(benchmark::kMicrosecond);

void alone_of_8(benchmark::State& state) {
  const auto marks = deck_of_8(false);
  for (auto _ : state)
    for (const MarkImage& mark : marks) benchmark::DoNotOptimize(estimate_pose(mark, camera, level, {}));
}
BENCHMARK(alone_of_8)->Unit(benchmark::kMicrosecond);

void deck_of_8(benchmark::State& state, bool rings) {
  const auto marks = deck_of_8(rings);
  for (auto _ : state) benchmark::DoNotOptimize(estimate_poses(marks, camera, level, {}));
}
BENCHMARK_CAPTURE(deck_of_8, discs, false)->Unit(benchmark::kMicrosecond);
BENCHMARK_CAPTURE(deck_of_8, rings, true)->Unit(benchmark::kMicrosecond);

void four_point(benchmark::State& state) {
  const EllipseFit fit = fit_of({210.3, 330.7, 61.2, 48.9, 0.4});
  for (auto _ : state) benchmark::DoNotOptimize(four_point_pose(fit, camera, 0.5));
}
BENCHMARK(four_point)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
