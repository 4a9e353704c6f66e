#include "sim_proc/sim_stage.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "geometry/rectify.hpp"
#include "runtime/frame_codec.hpp"
#include "sim_proc/published_outline.hpp"
#include "tests/support/sim_flight.hpp"

using namespace stevedore;

namespace {

/// A sixteenth of the pixels: quick to draw.
CameraModel small_camera() {
  CameraModel camera = world_camera();
  for (Pinhole* pinhole : {&camera.given, &camera.rectified}) {
    pinhole->fx_px /= 4, pinhole->fy_px /= 4, pinhole->cx_px /= 4, pinhole->cy_px /= 4;
    pinhole->width_px /= 4, pinhole->height_px /= 4;
  }
  return camera;
}

SimSettings small_settings() {
  SimSettings settings;
  settings.rate_hz = 10;
  settings.render_threads = 1;
  settings.frames.transport = "raw";
  return settings;
}

template <class M>
void check_times(const std::vector<M>& messages, std::size_t expected, const SimFlight& flight) {
  CHECK(std::abs(static_cast<double>(messages.size()) - static_cast<double>(expected)) <= 1);
  for (std::size_t i = 0; i < messages.size(); ++i) {
    CHECK(messages[i].header.seq == static_cast<int64_t>(i));
    CHECK(messages[i].header.utime >= SimFlight::start_utime);
    CHECK(messages[i].header.utime <= flight.now);
    if (i > 0) CHECK(messages[i].header.utime > messages[i - 1].header.utime);
  }
}

}  // namespace

TEST_CASE("sim stage: everything comes at its rate, stamped with when it was taken") {
  SimFlight flight(small_settings(), small_camera());
  flight.fly(2);
  const MemoryBus& bus = flight.sim_bus;
  check_times(bus.published_on(channels::vehicle_state), 100, flight);
  check_times(bus.published_on(channels::gimbal_state), 100, flight);
  check_times(bus.published_on(channels::altimeter), 40, flight);
  check_times(bus.published_on(channels::hook_state), 20, flight);
  check_times(bus.published_on(channels::autopilot_status), 4, flight);
  CHECK_FALSE(bus.published_on(channels::platform_state).empty());
  const auto frames = bus.published_on(channels::frame);
  const auto truths = bus.published_on(channels::truth);
  REQUIRE(std::abs(static_cast<int>(frames.size()) - 20) <= 1);
  REQUIRE(truths.size() == frames.size());
  for (std::size_t i = 0; i < frames.size(); ++i) {
    CHECK(frames[i].header.seq == static_cast<int64_t>(i));
    CHECK(frames[i].header.frame_seq == static_cast<int64_t>(i));
    CHECK(truths[i].header.utime == frames[i].header.utime);
    CHECK(truths[i].header.frame_seq == frames[i].header.frame_seq);
    CHECK(frames[i].width_px == 160);
  }
  CHECK(flight.condition.state == health_t::STATE_OK);
  CHECK(flight.condition.message.empty());
}

TEST_CASE("sim stage: time does not stretch, what is not drawn in time is a drop and is counted") {
  SimSettings settings = small_settings();
  settings.frames.transport = "ring";
  SimFlight flight(settings);  // large pictures: none is drawn while the world catches up
  flight.fly(0.3);
  const auto before = flight.sim_bus.published_on(channels::frame).size();
  flight.stall(1);
  flight.fly(0.3);
  const auto frames = flight.sim_bus.published_on(channels::frame);
  check_times(flight.sim_bus.published_on(channels::vehicle_state), 80, flight);
  REQUIRE(frames.size() > before + 1);
  const header_t& last = frames.back().header;
  CHECK(last.seq + 1 == static_cast<int64_t>(frames.size()));
  const int64_t drops = last.frame_seq - last.seq;
  CHECK(drops > 3);
  CHECK(last.frame_seq >= 15);
  CHECK(flight.condition.message.find(std::to_string(drops) + " of ") == 0);
}

TEST_CASE("sim stage: gimbal_proc and the world keep the camera level in flight") {
  SimFlight flight(small_settings(), small_camera());
  flight.fly(6);
  double worst_rad = 0, worst_told_rad = 0;
  for (const truth_t& truth : flight.sim_bus.published_on(channels::truth)) {
    if (truth.header.frame_seq < 20) continue;
    const double* q = truth.ned_from_camera;
    const Eigen::Vector3d axis = Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * Eigen::Vector3d::UnitZ();
    worst_rad = std::max(worst_rad, std::acos(std::min(1.0, axis.z())));
  }
  for (const gimbal_state_t& level : flight.gimbal_bus.published_on(channels::gimbal_level)) {
    if (level.header.seq < 100) continue;
    CHECK(level.status == gimbal_state_t::STATUS_OK);
    worst_told_rad = std::max(worst_told_rad, level.off_level_rad);
  }
  constexpr double deg = std::numbers::pi / 180;
  CHECK(worst_rad < 4 * deg);  // attitude's bias and noise, the mount's 0.5 deg, the pan-tilt's lag
  CHECK(worst_told_rad < 2 * deg);
  CHECK(flight.sim_bus.published_on(channels::truth).back().position_ned_m[2] < -3);  // it flies
}

TEST_CASE("sim stage: after its seconds the world says nothing more, and has finished") {
  SimSettings settings = small_settings();
  settings.seconds = 1;
  SimFlight flight(settings, small_camera());
  flight.fly(1.1);
  CHECK(flight.condition.state == health_t::STATE_FINISHED);
  const auto messages = flight.sim_bus.sent.size();
  flight.fly(0.5);
  CHECK(flight.sim_bus.sent.size() == messages);
  CHECK(flight.sim_bus.published_on(channels::vehicle_state).size() == 50);
}

TEST_CASE("sim stage: without TRUTH every other message is the same to the byte") {
  SimSettings settings = small_settings();
  SimFlight with(settings, small_camera());
  settings.truth = false;
  SimFlight without(settings, small_camera());
  with.fly(3);
  without.fly(3);
  CHECK(without.sim_bus.published_on(channels::truth).empty());
  std::erase_if(with.log, [](const auto& message) { return message.first == channels::truth.name; });
  CHECK(with.log.size() > 300);
  CHECK(with.log == without.log);
}

TEST_CASE("sim stage: frames travel as the settings say") {
  SimSettings settings = small_settings();
  settings.frames.transport = "png";
  settings.pilot = "none";
  SimFlight flight(settings, small_camera());
  flight.fly(0.2);
  CHECK(flight.condition.state == health_t::STATE_OK);
  FrameReader reader;
  const auto frames = flight.sim_bus.published_on(channels::frame);
  REQUIRE_FALSE(frames.empty());
  CHECK(reader.image(frames.back()));
}

TEST_CASE("outlines of truth lie where the lens and the told rectification put the circle's edge") {
  world::WorldSettings settings;
  settings.camera = world_camera();
  world::World world(settings);
  world::ScriptedPilot pilot;
  int seen = 0;
  for (int i = 0; i < 6000; ++i) {
    if (i % 4 == 0) world.command(pilot.fly(world.whereabouts()));
    world.step();
    if (i % 400 != 0) continue;
    const world::Scene scene = world.scene(i);
    for (const world::CircleTruth& circle : world.truth().circles) {
      const auto outline = published_outline(scene, circle, settings.camera);
      if (!outline) continue;
      ++seen;
      const Eigen::Vector3d east = circle.normal_ned.unitOrthogonal(), north = circle.normal_ned.cross(east);
      for (double t = 0; t < 6.28; t += 0.3) {
        const Eigen::Vector3d edge_ned_m =
            circle.center_ned_m + circle.radius_m * (std::cos(t) * east + std::sin(t) * north);
        const auto& lens = scene.eye.lens;
        const Eigen::Vector2d given_px =
            distort(lens, lens.rectified.project(scene.eye.rigid.to_local(edge_ned_m)));
        if (given_px.x() < 0 || given_px.x() > 639 || given_px.y() < 0 || given_px.y() > 479) continue;
        const auto published_px = undistort(settings.camera, given_px);
        REQUIRE(published_px);
        const double radius = std::sqrt(normalized_radius_squared(*outline, *published_px));
        CHECK(std::abs(radius - 1) * outline->b_px < 0.05);
      }
    }
  }
  CHECK(seen > 20);
}
