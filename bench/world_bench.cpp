// Frames a second of the renderer alone, 640 x 480, with one thread and with two, for several views. Every
// frame is of another seed of noise and a little further on, as in flight. And what a step of the world
// costs, and its truth.
#include <benchmark/benchmark.h>

#include <string>

#include "sim_proc/world/pilot.hpp"
#include "sim_proc/world/renderer.hpp"
#include "sim_proc/world/world.hpp"
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

world::WorldSettings world_settings() {
  world::WorldSettings settings;
  settings.camera = paper_camera(Distortion::none);
  return settings;
}

/// Under the scripted pilot, who is asked ten times a second.
void step(benchmark::State& state) {
  world::World world(world_settings());
  world::ScriptedPilot pilot;
  int steps = 0;
  for (auto _ : state) {
    if (steps++ % 20 == 0) world.command(pilot.fly(world.whereabouts()));
    benchmark::DoNotOptimize(world.step());
  }
}

/// With every circle's outline and visible share, over a platform.
void truth(benchmark::State& state) {
  world::World world(world_settings());
  world::ScriptedPilot pilot;
  for (int i = 0; i < 8000; ++i) {
    if (i % 20 == 0) world.command(pilot.fly(world.whereabouts()));
    world.step();
  }
  for (auto _ : state) benchmark::DoNotOptimize(world.truth().circles.data());
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
BENCHMARK(step)->Unit(benchmark::kMicrosecond);
BENCHMARK(truth)->Unit(benchmark::kMicrosecond);

}  // namespace

BENCHMARK_MAIN();
