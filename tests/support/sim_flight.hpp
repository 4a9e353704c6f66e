// The world and gimbal_proc on buses of memory, in lock step: time is the test's, and no frame is dropped
// unless the test leaves none the time to be drawn.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "gimbal_proc/gimbal_stage.hpp"
#include "runtime/camera_file.hpp"
#include "sim_proc/sim_stage.hpp"
#include "tests/support/memory_bus.hpp"

namespace stevedore {

inline CameraModel world_camera() {
  return load_camera_file(std::string(STEVEDORE_SOURCE_DIR) + "/config/cameras/world_640x480.yaml").camera;
}

class SimFlight {
 public:
  using Sent = std::vector<std::pair<std::string, std::vector<uint8_t>>>;

  explicit SimFlight(const SimSettings& settings, const CameraModel& camera = world_camera())
      : sim_(settings, camera, "sim-flight", sim_bus), gimbal_(GimbalSettings{}, camera.mount, gimbal_bus) {}

  /// Lets the world go on, a step at a time, each frame drawn before the next step.
  void fly(double seconds) {
    for (const int64_t until = now + static_cast<int64_t>(seconds * 1e6); now < until;) {
      now += static_cast<int64_t>(world::World::step_s * 1e6);
      sim_.work(now);
      condition = sim_.finish_drawing();
      exchange();
    }
  }
  /// Time passes in which the process did not run.
  void stall(double seconds) {
    now += static_cast<int64_t>(seconds * 1e6);
    condition = sim_.work(now);
  }

  static constexpr int64_t start_utime = 1'000'000'000;
  int64_t now = start_utime;
  Condition condition;
  MemoryBus sim_bus{7}, gimbal_bus{8};
  Sent log;  ///< of both, in order

 private:
  void exchange() {
    for (; told_ < sim_bus.sent.size(); ++told_) {
      log.push_back(sim_bus.sent[told_]);
      gimbal_bus.deliver(log.back().first, log.back().second);
    }
    for (; answered_ < gimbal_bus.sent.size(); ++answered_) {
      log.push_back(gimbal_bus.sent[answered_]);
      sim_bus.deliver(log.back().first, log.back().second);
    }
  }

  SimStage sim_;
  GimbalStage gimbal_;
  std::size_t told_ = 0, answered_ = 0;
};

}  // namespace stevedore
