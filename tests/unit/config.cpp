#include "runtime/config.hpp"

#include <unistd.h>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "camera_proc/source.hpp"
#include "detector_proc/detector_settings.hpp"
#include "gimbal_proc/gimbal.hpp"
#include "mission_proc/mission.hpp"
#include "platform/platform_settings.hpp"
#include "pose_proc/pose_settings.hpp"
#include "runtime/camera_file.hpp"
#include "sim_proc/sim_stage.hpp"
#include "tools/record_settings.hpp"
#include "tracker_proc/tracker.hpp"

using namespace stevedore;
using Catch::Matchers::Contains;

namespace {

struct Colour {
  int hue = 0;
};
template <class Visitor>
void describe(Colour& s, Visitor& visit) {
  visit("hue", s.hue, 0.0, 179.0, "OpenCV hue", "");
}

struct TestSettings {
  double gate_px = 3;
  int votes = 2;
  bool hull = true;
  std::string method = "paper";
  std::vector<Colour> colours;
};
template <class Visitor>
void describe(TestSettings& s, Visitor& visit) {
  visit("gate_px", s.gate_px, 0.5, 10.0, "px", "");
  visit("votes", s.votes, 1.0, 5.0, "votes", "");
  visit("hull", s.hull, "");
  visit.choice("method", s.method, {"paper", "arcs"}, "");
  visit.list("colours", s.colours, "");
}

class File {
 public:
  explicit File(const std::string& text) {
    std::string name = (std::filesystem::temp_directory_path() / "stevedore-config-XXXXXX").string();
    const int descriptor = mkstemp(name.data());
    REQUIRE(descriptor >= 0);
    close(descriptor);
    path = name;
    std::ofstream(path) << text;
  }
  ~File() { std::filesystem::remove(path); }
  std::string path;
};

TestSettings read(const std::string& text, const std::vector<std::string>& overrides = {}) {
  const File file(text);
  return Config::load(file.path, overrides).section<TestSettings>("detector");
}

}  // namespace

TEST_CASE("settings come from the file, the rest from the defaults") {
  const auto s = read("detector:\n  gate_px: 4.5\n  method: arcs\n  colours: [{hue: 10}, {hue: 20}]\n");
  CHECK(s.gate_px == 4.5);
  CHECK(s.votes == 2);
  CHECK(s.method == "arcs");
  REQUIRE(s.colours.size() == 2);
  CHECK(s.colours[1].hue == 20);
  CHECK(read("").gate_px == 3);
  CHECK(read("detector:\n").gate_px == 3);
}

TEST_CASE("the command line goes over the file") {
  CHECK(read("detector:\n  gate_px: 4.5\n", {"detector.gate_px=6"}).gate_px == 6);
  CHECK(read("", {"detector.hull=false"}).hull == false);
  CHECK_THROWS_WITH(read("", {"detector"}), Contains("section.key=value"));
}

TEST_CASE("what is wrong is said with file, line and key") {
  CHECK_THROWS_WITH(read("detector:\n  gate_px: 4\n  gaet: 1\n"),
                    Contains(":3: detector.gaet: is not a setting"));
  CHECK_THROWS_WITH(read("detector:\n  gate_px: 40\n"),
                    Contains(":2: detector.gate_px: 40 is not between 0.5 and 10 px"));
  CHECK_THROWS_WITH(read("detector:\n  gate_px: wide\n"), Contains("is not a number"));
  CHECK_THROWS_WITH(read("detector:\n  gate_px: .nan\n"), Contains("is not a number"));
  CHECK_THROWS_WITH(read("detector:\n  votes: 1.5\n"), Contains("is not a whole number"));
  CHECK_THROWS_WITH(read("detector:\n  hull: perhaps\n"), Contains("is not true or false"));
  CHECK_THROWS_WITH(read("detector:\n  method: guess\n"), Contains("is not one of: paper, arcs"));
  CHECK_THROWS_WITH(read("detector:\n  colours: [{hue: 10}, {hue: 200}]\n"),
                    Contains("detector.colours[1].hue"));
  CHECK_THROWS_WITH(read("detector: 5\n"), Contains("is not a map"));
  CHECK_THROWS_WITH(read("detector:\n  votes: 1\n  votes: 2\n"),
                    Contains(":3: detector.votes: stands here twice"));
  CHECK_THROWS_WITH(read("detector: {votes: 1}\ncamera: {}\ndetector: {votes: 2}\n"),
                    Contains(":3: detector: stands here twice"));
  CHECK_THROWS_WITH(read("detector: {votes: 1}\n", {"detector.gate_px=40"}),
                    Contains("--set: detector.gate_px: 40"));
  CHECK_THROWS_WITH(read("detector: {votes: 1}\n", {"detector={gate_px: 40}"}),
                    Contains("--set: detector.gate_px: 40"));
  CHECK_THROWS_WITH(read("\n\n", {"detector.colours=[{hue: 10}, {hue: 200}]"}),
                    Contains("--set: detector.colours[1].hue"));
  CHECK_THROWS_AS(read("", {"detector=3", "detector.votes=3"}), ConfigError);
  CHECK_THROWS_AS(Config::load("/tmp"), ConfigError);
  CHECK_THROWS_WITH(read("detectro:\n  gate_px: 4\n"), Contains(":1: detectro: is not a section"));
  CHECK_THROWS_WITH(read("detector: [\n"), Contains(":"));
  CHECK_THROWS_AS(Config::load("/nowhere/at/all.yaml"), ConfigError);
}

TEST_CASE(
    "every configuration that is shipped names settings that there are, and a camera file that is read") {
  int files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(STEVEDORE_SOURCE_DIR "/config")) {
    if (entry.path().extension() != ".yaml") continue;
    INFO(entry.path());
    const Config config = Config::load(entry.path());
    CHECK_NOTHROW(camera_of(config));
    CHECK_NOTHROW(config.section<CameraSettings>("camera"));
    CHECK_NOTHROW(config.section<DetectorSettings>("detector"));
    CHECK_NOTHROW(config.section<TrackerSettings>("tracker"));
    CHECK_NOTHROW(config.section<PoseSettings>("pose"));
    CHECK_NOTHROW(config.section<PlatformSettings>("platform"));
    CHECK_NOTHROW(config.section<MissionSettings>("mission"));
    CHECK_NOTHROW(config.section<GimbalSettings>("gimbal"));
    CHECK_NOTHROW(config.section<SimSettings>("sim"));
    CHECK_NOTHROW(config.section<RecordSettings>("record"));
    ++files;
  }
  CHECK(files >= 4);
}
