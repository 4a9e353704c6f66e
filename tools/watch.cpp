#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "runtime/command_line.hpp"
#include "runtime/config.hpp"
#include "runtime/lcm_bus.hpp"
#include "runtime/process.hpp"
#include "tools/progress_line.hpp"
#include "tools/watch_view.hpp"

namespace {

using namespace stevedore;

constexpr int64_t line_period_us = 1'000'000;
constexpr int wait_ms = 50;

void show(ProgressLine& progress, WatchView& view, int64_t now) {
  for (const std::string& news : view.take_news()) {
    progress.end();
    fmt::print("{}\n", news);
  }
  progress.show(view.line(now));
}

void subscribe(LcmBus& bus, WatchView& view) {
  bus.subscribe<health_t>(channels::health, [&](const health_t& m) { view.on_health(m, bus.now_utime()); });
  bus.subscribe<frame_t>(channels::frame, [&](const frame_t& m) { view.on_frame(m.header); });
  bus.subscribe<ellipses_t>(channels::ellipses,
                            [&](const ellipses_t& m) { view.on_ellipses(m, bus.now_utime()); });
  bus.subscribe<tracks_t>(channels::tracks, [&](const tracks_t& m) { view.on_tracks(m, bus.now_utime()); });
  bus.subscribe<poses_t>(channels::poses, [&](const poses_t& m) { view.on_poses(m, bus.now_utime()); });
  bus.subscribe<mission_t>(channels::mission,
                           [&](const mission_t& m) { view.on_mission(m, bus.now_utime()); });
}

int watch(LcmBus& bus, double patience_s, int cargoes) {
  WatchView view(bus.now_utime(), cargoes);
  subscribe(bus, view);
  ProgressLine progress;
  for (int64_t line_utime = bus.now_utime(); !stop_requested();) {
    bus.handle(wait_ms);
    const int64_t now = bus.now_utime();
    const bool worked_off = view.worked_off(now) || view.mission_over(now);
    const bool gave_up = !worked_off && view.silent_s(now) >= patience_s;
    if (worked_off || gave_up || now - line_utime >= line_period_us) {
      show(progress, view, now);
      line_utime += line_period_us;
    }
    if (worked_off) return 0;
    if (view.ended_without_frames()) {
      progress.end();
      fmt::print(stderr, "The camera ended without one frame: {}\n", view.camera_message());
      return 1;
    }
    if (gave_up) {
      progress.end();
      fmt::print(stderr, "No MISSION for {:.0f} s. {}\n", view.silent_s(now), view.silence(now));
      return 1;
    }
  }
  return exit_stopped;
}

int run(int argc, char** argv) {
  CLI::App app(
      "Watches a running set: one line a second, until its images are worked off or its mission is over.",
      "watch");
  std::string config_file, url;
  std::vector<std::string> overrides;
  double patience_s = 20;
  int cargoes = 0;
  app.add_option("--patience", patience_s, "seconds without a MISSION for a frame after which to give up")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--cargoes", cargoes, "a mission that is to carry so many: shows it, and ends with it")
      ->check(CLI::PositiveNumber);
  app.add_option("--config", config_file, "the set's YAML file: its bus.url is where to listen");
  app.add_option("--set", overrides, "section.key=value, over what the file says")->take_all();
  app.add_option("--lcm-url", url, fmt::format("LCM's address, over bus.url [{}]", default_lcm_url));
  app.footer(
      "The line: elapsed time, frames in/out, frames with the target measured, status and number of the\n"
      "target, phase, frames a second, latency from capture to MISSION (p50/p99 of the last second), lost "
      "and\n"
      "skipped messages of all processes, frames that the camera did not deliver, emergencies. With "
      "--cargoes\n"
      "the phase of the mission, what it counts as delivered and its target (platform.circle) instead of "
      "the\n"
      "frames.");
  parse_command_line(app, argc, argv, "1 if nothing came, or for too long, 130 when stopped by a signal");
  stop_on_signals();
  if (url.empty()) url = bus_url(Config::load(config_file, overrides));
  if (url != default_lcm_url) fmt::print("Others hear this bus with --lcm-url '{}'\n", url);
  LcmBus bus(url);
  return watch(bus, patience_s, cargoes);
}

}  // namespace

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] { return run(argc, argv); });
}
