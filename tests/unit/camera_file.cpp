#include "runtime/camera_file.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <string>

using namespace stevedore;

namespace {

const std::string cameras = std::string(STEVEDORE_SOURCE_DIR) + "/config/cameras/";

const std::string good =
    "image_width: 640\n"
    "image_height: 480\n"
    "camera_matrix: {rows: 3, cols: 3, data: [300, 0, 320, 0, 301, 240, 0, 0, 1]}\n"
    "distortion_model: plumb_bob\n"
    "distortion_coefficients: {rows: 1, cols: 5, data: [-0.2, 0.03, 0.001, 0.002, 0]}\n"
    "response: 2.2\n";

std::string with(const std::string& line, const std::string& instead) {
  std::string text = good;
  const auto at = text.find(line);
  REQUIRE(at != std::string::npos);
  return text.replace(at, line.size(), instead);
}

/// A file for the length of a test.
class TemporaryFile {
 public:
  explicit TemporaryFile(const std::string& text)
      : path_(std::filesystem::temp_directory_path() /
              ("camera_file_test_" + std::to_string(getpid()) + ".yaml")) {
    std::ofstream(path_) << text;
  }
  ~TemporaryFile() { std::filesystem::remove(path_); }
  TemporaryFile(const TemporaryFile&) = delete;
  TemporaryFile& operator=(const TemporaryFile&) = delete;
  [[nodiscard]] std::string path() const { return path_; }

 private:
  std::filesystem::path path_;
};

CameraFile load(const std::string& text) {
  return load_camera_file(TemporaryFile(text).path());
}

std::string complaint(const std::string& text) {
  try {
    load(text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "nothing was wrong";
}

void check_complaint(const std::string& text, const std::string& place, const std::string& expected) {
  const std::string said = complaint(text);
  CAPTURE(said);
  CHECK(said.find(place) != std::string::npos);
  CHECK(said.find(expected) != std::string::npos);
}

}  // namespace

TEST_CASE("a complete file") {
  const CameraFile file = load(good + "mount_deg: {pitch: 90}\n");
  const CameraModel& camera = file.camera;
  CHECK(file.warnings.empty());
  CHECK(camera.given.width_px == 640);
  CHECK(camera.given.height_px == 480);
  CHECK(camera.given.fx_px == 300);
  CHECK(camera.given.fy_px == 301);
  CHECK(camera.given.cx_px == 320);
  CHECK(camera.given.cy_px == 240);
  CHECK(camera.rectified.matrix() == camera.given.matrix());
  CHECK(camera.distortion == Distortion::plumb_bob);
  CHECK(camera.coefficients == std::vector<double>{-0.2, 0.03, 0.001, 0.002, 0});
  CHECK(camera.response.curve == Response::Curve::gamma);
  CHECK(camera.response.gamma == 2.2);
  CHECK(camera.mount.pitch_rad == Approx(1.5707963));
}

TEST_CASE("projection_matrix is the rectified camera") {
  const CameraFile file = load(
      good + "projection_matrix: {rows: 3, cols: 4, data: [250, 0, 319, 0, 0, 251, 239, 0, 0, 0, 1, 0]}\n");
  CHECK(file.camera.rectified.fx_px == 250);
  CHECK(file.camera.rectified.cy_px == 239);
  CHECK(file.camera.rectified.width_px == 640);
}

TEST_CASE("without response it is srgb, with a warning") {
  const CameraFile file = load(with("response: 2.2\n", ""));
  CHECK(file.camera.response.curve == Response::Curve::srgb);
  REQUIRE(file.warnings.size() == 1);
  CHECK(file.warnings[0].find("response") != std::string::npos);
}

TEST_CASE("coefficients that are all zero are no distortion, except for an equidistant lens") {
  CHECK(load(with("[-0.2, 0.03, 0.001, 0.002, 0]", "[0, 0, 0, 0, 0.0]")).camera.distortion ==
        Distortion::none);
  const std::string fisheye =
      "distortion_model: equidistant\ndistortion_coefficients: {rows: 1, cols: 4, data: [0, 0, 0, 0]}\n";
  const std::string text = good.substr(0, good.find("distortion_model")) + fisheye;
  CHECK(load(text).camera.distortion == Distortion::equidistant);
}

TEST_CASE("complaints name line, key and what is expected") {
  check_complaint(with("image_width: 640\n", ""), "image_width", "missing");
  check_complaint(with("image_height: 480", "image_height: tall"), ":2: image_height", "whole number");
  check_complaint(with("image_width: 640", "image_width: 0"), ":1: image_width", "from 1");
  check_complaint(with("rows: 3, cols: 3", "rows: 3, cols: 2"), ":3: camera_matrix", "9 numbers");
  check_complaint(with("[300, 0, 320, 0", "[300, 0, 320"), ":3: camera_matrix", "with 8 numbers");
  check_complaint(with("[300, 0", "[wide, 0"), ":3: camera_matrix.data", "number");
  check_complaint(with("[300, 0", "[.nan, 0"), ":3: camera_matrix.data", "number");
  check_complaint(with("[300, 0", "[-300, 0"), ":3: camera_matrix", "positive");
  check_complaint(with("[300, 0", "[300, 2"), ":3: camera_matrix", "skew");
  check_complaint(with("plumb_bob", "fisheye"), ":4: distortion_model", "equidistant");
  check_complaint(with("plumb_bob", "equidistant"), ":5: distortion_coefficients", "4 numbers");
  check_complaint(with("response: 2.2", "response: rec709"), ":6: response", "linear, srgb");
  check_complaint(with("response: 2.2", "response: 22"), ":6: response", "0.2 to 5");
  check_complaint(with("response", "responce"), ":6: responce", "is not a key");
  check_complaint(good + "image_width: 320\n", ":7: image_width", "stands here twice");
  check_complaint(good + "mount_deg: {tilt: 1}\n", ":7: mount_deg.tilt", "roll, pitch, yaw");
  check_complaint(good + "rectification_matrix: {rows: 3, cols: 3, data: [0,1,0, 1,0,0, 0,0,1]}\n",
                  ":7: rectification_matrix", "identity");
  check_complaint(good + "projection_matrix: {rows: 3, cols: 4, data: [250,0,1,9, 0,250,1,0, 0,0,1,0]}\n",
                  ":7: projection_matrix", "single camera");
  check_complaint("- a list\n", ":1:", "camera file");
  check_complaint("image_width: [\n", ":", "yaml");
}

TEST_CASE("a file that is not there") {
  CHECK_THROWS_AS(load_camera_file("/nonexistent/camera.yaml"), ConfigError);
}

TEST_CASE("the cameras that come along can be read") {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(cameras)) {
    INFO(entry.path());
    CHECK(load_camera_file(entry.path()).warnings.empty());
    ++count;
  }
  CHECK(count >= 2);
}
