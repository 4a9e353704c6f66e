// Frames a second of the renderer alone, 640 x 480, with one thread and with two, for several views. Every
// frame is of another seed of noise and a little further on, as in flight.
#include <benchmark/benchmark.h>

#include <string>

#include "sim_proc/world/renderer.hpp"
#include "tools/stills.hpp"

using namespace stevedore;

namespace {

CameraModel paper_camera(Distortion distortion) {
  CameraModel camera;
  camera.given = camera.rectified = {640, 480, 337, 337, 319.5, 239.5};
  camera.distortion = distortion;
  if (distortion == Distortion::plumb_bob) camera.coefficients = {-0.28, 0.075, 0.0006, -0.0004, 0};
  return camera;
}

void render(benchmark::State& state, int number, Distortion distortion) {
  const StillCamera camera = draw_still_camera(paper_camera(distortion), 1, true);
  world::Scene scene = draw_still(camera, 1, number).scene;
  world::Renderer renderer(static_cast<int>(state.range(0)));
  renderer.render(scene);  // the lens and the textures are made once
  for (auto _ : state) {
    scene.eye.noise_seed += 1;
    scene.surroundings.wave_phase_s += 0.02;
    benchmark::DoNotOptimize(renderer.render(scene).data);
  }
  state.counters["frames/s"] =
      benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

/// A hundred views as they come, one frame of each.
void render_mix(benchmark::State& state) {
  const StillCamera camera = draw_still_camera(paper_camera(Distortion::none), 1, true);
  std::vector<world::Scene> scenes;
  for (int i = 0; i < 100; ++i) scenes.push_back(draw_still(camera, 2, i).scene);
  world::Renderer renderer(static_cast<int>(state.range(0)));
  size_t next = 0;
  for (auto _ : state) benchmark::DoNotOptimize(renderer.render(scenes[next++ % scenes.size()]).data);
  state.counters["frames/s"] =
      benchmark::Counter(static_cast<double>(state.iterations()), benchmark::Counter::kIsRate);
}

constexpr auto none = Distortion::none;

void threads(benchmark::internal::Benchmark* bench) {
  bench->Arg(1)->Arg(2)->ArgName("threads")->Unit(benchmark::kMillisecond)->UseRealTime();
}

BENCHMARK_CAPTURE(render, low_over_tarmac, 4, none)->Apply(threads);
BENCHMARK_CAPTURE(render, low_over_grass, 7, none)->Apply(threads);
BENCHMARK_CAPTURE(render, high_over_water, 12, none)->Apply(threads);
BENCHMARK_CAPTURE(render, wide_lens, 4, Distortion::plumb_bob)->Apply(threads);
BENCHMARK(render_mix)->Apply(threads);

}  // namespace

BENCHMARK_MAIN();
