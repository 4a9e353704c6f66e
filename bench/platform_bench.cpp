// What a frame costs the platforms' estimator: two platforms known, four circles of one in view.
#include <benchmark/benchmark.h>

#include <vector>

#include "tests/support/platform_world.hpp"

namespace {

using namespace stevedore;
using namespace stevedore::test;

Station above_the_first(double) {
  return {0, Eigen::Vector2d::Zero(), 6};
}

/// Frames are worked in for the first time each: the estimator is set back outside the timing.
void frame(benchmark::State& state) {
  WorldOptions options;
  options.missed = options.false_circles = 0;
  PlatformWorld world(options);
  PlatformEstimator estimator{PlatformSettings{}};
  for (int i = 0; i < 60; ++i) world.next_frame(estimator, above_the_first);
  FrameSighting sighting = world.last_sighting;
  sighting.utime += 20'000;  // within the aircraft's state, which is 60 ms ahead
  const PlatformEstimator before = estimator;
  for (auto _ : state) {
    state.PauseTiming();
    estimator = before;
    state.ResumeTiming();
    benchmark::DoNotOptimize(estimator.add_frame(sighting));
  }
  state.counters["circles"] = static_cast<double>(sighting.circles.size());
}
BENCHMARK(frame)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
