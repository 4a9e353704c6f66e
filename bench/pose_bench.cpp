// What a pose costs: the closed form against the paper's solvePnP.
#include <benchmark/benchmark.h>

#include "pose_proc/circle_pose.hpp"
#include "pose_proc/solution_choice.hpp"

using namespace stevedore;

namespace {

const Pinhole camera{640, 480, 337, 337, 319.5, 239.5};

EllipseFit oblique() {
  EllipseFit fit{{210.3, 330.7, 61.2, 48.9, 0.4}, EllipseCovariance::Zero()};
  fit.covariance.diagonal() << 0.0025, 0.0025, 0.005, 0.005, 0.00002;
  return fit;
}

void conic(benchmark::State& state) {
  EllipseFit fit = oblique();
  for (auto _ : state) {
    benchmark::DoNotOptimize(fit);
    benchmark::DoNotOptimize(conic_pose(fit, camera, 0.5));
  }
}
BENCHMARK(conic)->Unit(benchmark::kMicrosecond);

void conic_and_choice(benchmark::State& state) {
  EllipseFit fit = oblique();
  const Gravity gravity{Eigen::Vector3d::UnitZ(), 0.01};
  for (auto _ : state) {
    benchmark::DoNotOptimize(fit);
    benchmark::DoNotOptimize(choose_solution(*conic_pose(fit, camera, 0.5), gravity, {}, {}));
  }
}
BENCHMARK(conic_and_choice)->Unit(benchmark::kMicrosecond);

void four_point(benchmark::State& state) {
  EllipseFit fit = oblique();
  for (auto _ : state) {
    benchmark::DoNotOptimize(fit);
    benchmark::DoNotOptimize(four_point_pose(fit, camera, 0.5));
  }
}
BENCHMARK(four_point)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
