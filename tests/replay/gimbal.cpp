// gimbal_proc over a log: its answers again, and left out where it did not fly.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "gimbal_proc/gimbal_stage.hpp"
#include "runtime/frame_codec.hpp"
#include "tests/support/memory_bus.hpp"
#include "tools/replay_core.hpp"

using namespace stevedore;

namespace {

constexpr int64_t gimbal_run = 7, aircraft_run = 8;

/// A log of a rolling aircraft whose pan-tilt stops in mid-flight, with or without gimbal_proc.
class FlightLog {
 public:
  explicit FlightLog(bool with_gimbal)
      : path_(std::filesystem::temp_directory_path() / ("replay-gimbal-" + std::to_string(getpid()))) {
    LogWriter writer(path_.string());
    MemoryBus aircraft(aircraft_run), process(gimbal_run);
    GimbalStage stage(GimbalSettings{}, CameraMount{}, process);
    health_t health{};
    health.process = "gimbal_proc";
    process.publish(channels::health, health);
    look(aircraft);
    for (int64_t k = 0; k < 200; ++k) {
      fly(aircraft, k);
      for (const auto& [channel, bytes] : aircraft.sent) {
        writer.write({k, channel, bytes});
        process.deliver(channel, bytes);
      }
      aircraft.sent.clear();
      if (!with_gimbal) process.sent.clear();
      for (const auto& [channel, bytes] : process.sent) writer.write({k, channel, bytes});
      process.sent.clear();
    }
  }
  ~FlightLog() { std::filesystem::remove(path_); }
  FlightLog(const FlightLog&) = delete;
  FlightLog& operator=(const FlightLog&) = delete;

  [[nodiscard]] ReplayResult replayed(ReplayMode mode, std::set<std::string> stages = {}) const {
    ReplayOptions options;
    options.mode = mode;
    options.stages = std::move(stages);
    return replay(path_.string(), options, [](const LogEvent&) {});
  }

 private:
  /// One picture: a replay of the line is refused without any.
  static void look(MemoryBus& aircraft) {
    frame_t frame{};
    frame.header.utime = 1'000'000;
    encode_raw(cv::Mat(8, 8, CV_8UC1, cv::Scalar(90)), frame);
    aircraft.publish(channels::frame, frame);
  }
  static void fly(MemoryBus& aircraft, int64_t k) {
    const double roll_rad = 0.2 * std::sin(0.05 * static_cast<double>(k));
    gimbal_state_t gimbal{};
    gimbal.header.utime = 1'000'000 + k * 20'000 - 7'000;
    gimbal.roll_rad = k < 100 ? -roll_rad : 0.3;
    gimbal.off_level_rad = -1;
    gimbal.status = gimbal_state_t::STATUS_OK;
    aircraft.publish(channels::gimbal_state, gimbal);
    vehicle_state_t vehicle{};
    vehicle.header.utime = 1'000'000 + k * 20'000;
    vehicle.ned_from_body[0] = std::cos(roll_rad / 2);
    vehicle.ned_from_body[1] = std::sin(roll_rad / 2);
    aircraft.publish(channels::vehicle_state, vehicle);
  }

  std::filesystem::path path_;
};

}  // namespace

TEST_CASE("gimbal: as flown, every payload is equal") {
  const auto result = FlightLog(true).replayed(ReplayMode::as_flown, {"gimbal_proc"});
  CHECK(result.as_flown());
  CHECK(result.channels.at("GIMBAL_COMMAND").equal == 200);
  CHECK(result.channels.at("GIMBAL_LEVEL").equal == 200);
}

TEST_CASE("gimbal: replayed with the line where it flew, and only there") {
  CHECK(FlightLog(true).replayed(ReplayMode::as_flown).channels.at("GIMBAL_LEVEL").equal == 200);
  CHECK_FALSE(FlightLog(false).replayed(ReplayMode::every_frame).channels.contains("GIMBAL_LEVEL"));
  const auto asked = FlightLog(false).replayed(ReplayMode::every_frame, {"gimbal_proc"});
  CHECK(asked.channels.at("GIMBAL_LEVEL").only_replayed == 200);
}
