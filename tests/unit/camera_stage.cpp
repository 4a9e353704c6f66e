#include "camera_proc/camera_stage.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>

#include "tests/support/memory_bus.hpp"

using namespace stevedore;
namespace fs = std::filesystem;

namespace {

/// Three images of 8 x 6 pixels.
class Images {
 public:
  Images() : path_(fs::temp_directory_path() / ("stevedore_camera_stage_" + std::to_string(getpid()))) {
    fs::remove_all(path_);
    fs::create_directories(path_);
    for (const char* name : {"1.png", "2.png", "3.png"})
      REQUIRE(cv::imwrite(path_ / name, cv::Mat(6, 8, CV_8UC1, cv::Scalar(9))));
  }
  ~Images() { fs::remove_all(path_); }
  Images(const Images&) = delete;
  Images& operator=(const Images&) = delete;

  [[nodiscard]] CameraSettings settings() const {
    CameraSettings settings;
    settings.source = path_;
    settings.once = true;
    settings.rate_hz = 1000;
    settings.frames.transport = "raw";
    return settings;
  }

 private:
  fs::path path_;
};

CameraModel lens(int width_px, int height_px) {
  CameraModel camera;
  camera.given = camera.rectified = {width_px, height_px, 5, 5, 3.5, 2.5};
  return camera;
}

Condition play(CameraStage& stage) {
  Condition condition;
  for (int i = 0; i < 20; ++i) condition = stage.work();
  return condition;
}

}  // namespace

TEST_CASE("images are sent, numbered, and counted as the camera's own input") {
  const Images images;
  MemoryBus bus;
  CameraStage stage(images.settings(), lens(8, 6), "test", bus);
  const Condition condition = play(stage);
  const auto frames = bus.published_on(channels::frame);
  REQUIRE(frames.size() == 3);
  CHECK(frames[2].header.frame_seq == 2);
  CHECK(condition.state == health_t::STATE_FINISHED);
  REQUIRE(condition.source);
  CHECK(condition.source->channel == "camera");
  CHECK(condition.source->handled == 3);
  CHECK(condition.source->lost_malformed == 0);
}

TEST_CASE("images of another size than the camera file's are not sent as if they were the camera's") {
  const Images images;
  MemoryBus bus;
  CameraStage stage(images.settings(), lens(16, 12), "test", bus);
  const Condition condition = play(stage);
  CHECK(bus.published_on(channels::frame).empty());
  CHECK(condition.state == health_t::STATE_FAILED);
  CHECK(condition.message.find("8x6") != std::string::npos);
  CHECK(condition.message.find("16x12") != std::string::npos);
  CHECK(condition.source->lost_malformed == 3);
}

TEST_CASE("a last image that is not sent keeps nobody from the end") {
  const Images images;
  cv::imwrite(fs::path(images.settings().source) / "4.png", cv::Mat(12, 16, CV_8UC1, cv::Scalar(9)));
  MemoryBus bus;
  CameraStage stage(images.settings(), lens(8, 6), "test", bus);
  const Condition condition = play(stage);
  CHECK(bus.published_on(channels::frame).size() == 3);
  CHECK(condition.state == health_t::STATE_FINISHED);
  CHECK(condition.message.find("1 not sent") != std::string::npos);
}

TEST_CASE("unpaced files wait for the tracker's answer") {
  const Images images;
  CameraSettings settings = images.settings();
  settings.paced = false;
  MemoryBus bus;
  CameraStage stage(settings, std::nullopt, "test", bus);
  for (int64_t answered = 0; answered < 3; ++answered) {
    play(stage);
    REQUIRE(bus.published_on(channels::frame).size() == static_cast<size_t>(answered + 1));
    tracks_t tracks{};
    tracks.header.frame_seq = answered;
    tracks.header.seq = answered;
    tracks.width_px = tracks.height_px = 1;
    tracks.target_id = -1;
    tracks.target_status = track_t::STATUS_SEARCHING;
    bus.deliver(channels::tracks, tracks);
  }
  CHECK(play(stage).state == health_t::STATE_FINISHED);
}
