// The platforms' part of pose_proc's stage: messages in, PLATFORM_ESTIMATE out.
#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>
#include <memory>

#include "pose_proc/pose_stage.hpp"
#include "runtime/config.hpp"
#include "tests/support/film.hpp"
#include "tests/support/memory_bus.hpp"

using namespace stevedore;

namespace {

constexpr int64_t frame_us = 66'667;
constexpr double height_m = 5;

/// A level aircraft that stands still, its camera 5 m over the middle of a level deck that moves north.
vehicle_state_t vehicle_at(int64_t utime) {
  vehicle_state_t vehicle{};
  vehicle.header.utime = utime;
  vehicle.position_ned_m[2] = -height_m - PlatformSettings{}.camera_down_m;
  vehicle.ned_from_body[0] = 1;
  for (int i = 0; i < 3; ++i) {
    vehicle.velocity_variance_m2ps2[i] = 1e-4;
    vehicle.attitude_variance_rad2[i] = 1e-5;
  }
  return vehicle;
}

constexpr double speed_mps = 0.3;

/// Where the deck's circles are then, seen straight from above: x is right, y is backward.
tracks_t tracks_at(int64_t k, bool second_occupied) {
  const Pinhole camera = film_camera();
  tracks_t tracks{};
  tracks.header.utime = 1'000'000 + k * frame_us;
  tracks.header.frame_seq = k;
  tracks.header.seq = k;
  tracks.width_px = static_cast<int16_t>(camera.width_px);
  tracks.height_px = static_cast<int16_t>(camera.height_px);
  tracks.target_id = -1;
  tracks.target_status = track_t::STATUS_SEARCHING;
  const double moved_m = speed_mps * static_cast<double>(k) * frame_us * 1e-6;
  for (const auto& [forward_m, right_m] : {std::pair(0.8, -0.8), {0.8, 0.8}, {-0.8, 0.8}, {-0.8, -0.8}}) {
    track_t track{};
    track.id = static_cast<int64_t>(tracks.tracks.size());
    const Eigen::Vector2d center_px = camera.project({right_m, -forward_m - moved_m + 0.8, height_m});
    track.ellipse.outer.u_px = center_px.x();
    track.ellipse.outer.v_px = center_px.y();
    track.ellipse.outer.a_px = track.ellipse.outer.b_px = camera.fx_px * 0.5 / height_m;
    for (int i = 0; i < 5; ++i) track.ellipse.outer.covariance[6 * i] = 0.0025;
    track.ellipse.coverage = 1;
    track.ellipse.kind = ellipse_t::KIND_WHOLE;
    track.ellipse.label = ellipse_t::LABEL_CIRCLE;
    track.ellipse.occupied =
        second_occupied && track.id == 1 ? ellipse_t::OCCUPIED_YES : ellipse_t::OCCUPIED_NO;
    track.status = track_t::STATUS_TRACKING;
    tracks.tracks.push_back(track);
  }
  tracks.count = static_cast<int16_t>(tracks.tracks.size());
  return tracks;
}

platform_state_t report_at(int64_t utime) {
  platform_state_t report{};
  report.header.utime = utime;
  report.platform = 1;
  report.position_ned_m[0] = 2;
  report.velocity_ned_mps[0] = speed_mps;
  return report;
}

struct Fixture {
  MemoryBus bus;
  std::unique_ptr<PoseStage> stage;
  int64_t states = 0, reports = 0;

  Fixture() {
    CameraModel camera;
    camera.given = camera.rectified = film_camera();
    stage = std::make_unique<PoseStage>(PoseSettings{}, camera, bus);
  }
  void run(int64_t from, int64_t to) {
    for (int64_t k = from; k < to; ++k) {
      for (const int64_t end = 1'000'000 + (k + 1) * frame_us; states * 20'000 < end; ++states) {
        vehicle_state_t vehicle = vehicle_at(states * 20'000);
        vehicle.header.seq = states;
        bus.deliver(channels::vehicle_state, vehicle);
      }
      if (k % 8 == 0) {
        platform_state_t report = report_at(1'000'000 + k * frame_us);
        report.header.seq = reports++;
        bus.deliver(channels::platform_state, report);
      }
      bus.deliver(channels::tracks, tracks_at(k, true));
    }
  }
};

}  // namespace

TEST_CASE("pose stage: a deck's circles give its estimate with every frame, under its own number") {
  Fixture f;
  f.run(0, 60);
  const auto estimates = f.bus.published_on(channels::platform_estimate);
  CHECK(f.bus.published_on(channels::poses).size() == 60);
  REQUIRE(estimates.size() == 60);
  const platform_estimate_t& last = estimates.back();
  CHECK(last.platform == 1);
  CHECK(last.header.utime == 1'000'000 + 59 * frame_us);
  CHECK(last.header.frame_seq == 59);
  CHECK(last.header.trace.cause == "TRACKS");
  CHECK(last.measured_utime == last.header.utime);
  CHECK(last.identity_certain);
  const double moved_m = speed_mps * 59 * frame_us * 1e-6;
  CHECK(last.center_ned_m[0] == Approx(moved_m - 0.8 + PlatformSettings{}.camera_forward_m).margin(0.03));
  CHECK(last.center_ned_m[1] == Approx(0).margin(0.03));
  CHECK(last.center_ned_m[2] == Approx(0).margin(0.05));
  CHECK(last.velocity_ned_mps[0] == Approx(speed_mps).margin(0.03));
  REQUIRE(last.slots.size() == 4);
  CHECK(last.slots[0].state == slot_t::STATE_EMPTY);
  CHECK(last.slots[1].state == slot_t::STATE_OCCUPIED);
  CHECK(last.slots[1].center_ned_m[1] == Approx(0.8).margin(0.03));
  CHECK(last.slots[2].index == 2);
  REQUIRE(last.predictions.size() == 4);
  CHECK(last.predictions[1].center_ned_m[0] - last.center_ned_m[0] == Approx(speed_mps).margin(0.04));
}

TEST_CASE("pose stage: a layout that can't be is a mistake in the configuration") {
  MemoryBus bus;
  PlatformSettings settings;
  settings.slots = {{1, 0}, {-1, 0}};
  CHECK_THROWS_AS(PlatformStage(settings, CameraMount{}, bus), ConfigError);
}

TEST_CASE("pose stage: without the aircraft's state there is no estimate, with a silent gimbal neither") {
  Fixture f;
  f.bus.deliver(channels::tracks, tracks_at(0, false));
  CHECK(f.bus.published_on(channels::platform_estimate).empty());
  gimbal_state_t gimbal{};
  gimbal.header.utime = 1'200'000;
  gimbal.status = gimbal_state_t::STATUS_OK;
  f.bus.deliver(channels::gimbal_state, gimbal);
  f.run(1, 30);
  const auto estimates = f.bus.published_on(channels::platform_estimate);
  REQUIRE_FALSE(estimates.empty());
  CHECK(estimates.back().header.utime <= 1'400'000);
}

TEST_CASE("pose stage: a platform that is only told of is estimated where it says it is") {
  Fixture f;
  for (int64_t i = 0; i < 60; ++i) {
    vehicle_state_t vehicle = vehicle_at(900'000 + i * 20'000);
    vehicle.header.seq = i;
    f.bus.deliver(channels::vehicle_state, vehicle);
  }
  f.bus.deliver(channels::platform_state, report_at(1'000'000));
  tracks_t tracks = tracks_at(0, false);
  tracks.tracks.clear();
  tracks.count = 0;
  f.bus.deliver(channels::tracks, tracks);
  const auto estimates = f.bus.published_on(channels::platform_estimate);
  REQUIRE(estimates.size() == 1);
  CHECK(estimates[0].center_ned_m[0] == Approx(2).margin(0.1));
  CHECK(estimates[0].covariance[0] > 4);
  CHECK_FALSE(estimates[0].identity_certain);
  CHECK(estimates[0].slots.empty());
}
