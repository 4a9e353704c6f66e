// The rules of docs/architecture.md about who may include what. lcm/lcm.h is on the default include path, so
// that linking alone can't hold them.
#include <algorithm>
#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;
using Strings = std::vector<std::string>;

constexpr long max_main_lines = 60;  // stage and runtime put together; more is work that belongs to a stage

struct Source {
  std::string path;  ///< from the top of the tree
  std::string text;
};

bool starts_with_any(const std::string& text, const Strings& beginnings) {
  return std::any_of(beginnings.begin(), beginnings.end(),
                     [&](const std::string& beginning) { return text.starts_with(beginning); });
}

std::string room_of(const std::string& path) {
  return path.substr(0, path.find('/'));
}

bool is_process_room(const std::string& room) {
  return room.ends_with("_proc");
}

std::string without_comments(const std::string& text) {
  static const std::regex comment(R"(//[^\n]*|/\*[^*]*\*+(?:[^/*][^*]*\*+)*/)");
  return std::regex_replace(text, comment, "");
}

Strings matches(const std::string& text, const std::regex& pattern) {
  Strings found;
  for (std::sregex_iterator match(text.begin(), text.end(), pattern), end; match != end; ++match) {
    found.push_back((*match)[1]);
  }
  return found;
}

bool has_word(const std::string& code, const std::string& word) {
  return std::regex_search(code, std::regex("(^|\\W)" + word + "(\\W|$)"));
}

Strings includes_of(const std::string& code) {
  static const std::regex include(R"re(#\s*include\s*[<"]([^>"]+)[>"])re");
  return matches(code, include);
}

/// A header of the C++ library has neither folder nor suffix; fmt stands in for its <format>, which gcc 12
/// lacks.
bool is_standard(const std::string& header) {
  return header.find_first_of("/.") == std::string::npos || header == "fmt/format.h";
}

/// Clocks, files, threads and streams: what makes a result depend on more than its inputs.
bool reaches_outside(const std::string& header) {
  static const std::set<std::string> headers = {
      "atomic",   "chrono", "condition_variable", "ctime",      "filesystem", "fstream",   "future",
      "iostream", "mutex",  "shared_mutex",       "stop_token", "thread",     "semaphore", "latch",
      "barrier",  "csignal"};
  return headers.contains(header) ||
         starts_with_any(header, {"opencv2/highgui", "opencv2/imgcodecs", "opencv2/videoio",
                                  "opencv2/core/utils/filesystem"});
}

bool is_library(const std::string& header) {
  return is_standard(header) || starts_with_any(header, {"Eigen/", "unsupported/Eigen/", "opencv2/"});
}

enum class Part { algorithm, device, stage, main, other };

Part part_of(const std::string& path) {
  const std::string room = room_of(path), file = fs::path(path).filename().string();
  if (room == "geometry" || room == "platform") return Part::algorithm;
  if (!is_process_room(room)) return Part::other;
  if (file == "main.cpp") return Part::main;
  const std::string stem = fs::path(file).stem().string();
  if (stem.ends_with("_stage") || stem.ends_with("_messages")) return Part::stage;
  if (room == "camera_proc" && file.starts_with("source")) return Part::device;
  if (path.starts_with("sim_proc/render_thread.")) return Part::device;
  if (path.starts_with("sim_proc/world/workers.")) return Part::device;  // the renderer's threads
  return Part::algorithm;
}

/// Whether a file of that part and room may include the header.
bool may_include(Part part, const std::string& room, const std::string& header) {
  if (part == Part::other) {
    const bool is_base = room == "runtime" || room == "lcmtypes";
    return !is_base || !is_process_room(room_of(header));
  }
  if (room == "geometry")
    return !reaches_outside(header) && (is_library(header) || header.starts_with("geometry/"));
  const bool near = is_library(header) || starts_with_any(header, {"geometry/", "platform/", room + "/"});
  switch (part) {
    case Part::algorithm:
      return near && !reaches_outside(header);
    case Part::device:
      return near || (!starts_with_any(header, {"lcm/", "lcmtypes/", "stevedore/"}) &&
                      header != "runtime/bus.hpp" && header != "runtime/lcm_bus.hpp" &&
                      header != "runtime/process.hpp" && !is_process_room(room_of(header)));
    case Part::stage:
      return (near && !reaches_outside(header)) || starts_with_any(header, {"lcmtypes/", "stevedore/"}) ||
             (header.starts_with("runtime/") && header != "runtime/lcm_bus.hpp" &&
              header != "runtime/process.hpp");
    default:
      return !header.starts_with("lcm/") && (room_of(header) == room || !is_process_room(room_of(header)));
  }
}

/// Words that reach around the include rules.
Strings forbidden_words(Part part, const std::string& room) {
  Strings words;
  if (part == Part::algorithm)
    words = {"getTickCount", "getenv", "clock_gettime", "gettimeofday", "random_device", "fopen", "printf"};
  if (room != "runtime" && part != Part::other) words.push_back("setNumThreads");
  const std::set<std::string> may_know_truth = {"sim_proc", "tools", "tests", "bench", "lcmtypes"};
  if (!may_know_truth.contains(room)) {
    words.insert(words.end(), {"channels::truth", "TRUTH", "truth_t"});
  }
  if (part == Part::stage || part == Part::algorithm || part == Part::main) words.push_back("lcm::LCM");
  return words;
}

Strings faults_of(const Source& source) {
  const std::string room = room_of(source.path), code = without_comments(source.text);
  const Part part = part_of(source.path);
  Strings faults;
  for (const std::string& header : includes_of(code)) {
    if (!may_include(part, room, header)) faults.push_back(source.path + " includes " + header);
  }
  for (const std::string& word : forbidden_words(part, room)) {
    if (has_word(code, word)) faults.push_back(source.path + " says " + word);
  }
  const auto lines = std::count(source.text.begin(), source.text.end(), '\n');
  if (part == Part::main && lines > max_main_lines) {
    faults.push_back(source.path + " has " + std::to_string(lines) + " lines");
  }
  return faults;
}

/// Names of test cases that CMake's lists would split: such tests vanish without a word.
Strings split_names_of(const Source& source) {
  static const std::regex test_case(R"re(TEST_CASE\(\s*((?:"[^"]*"\s*)+))re");
  Strings names = matches(source.text, test_case);
  std::erase_if(names,
                [](const std::string& name) { return name.find_first_of("[];") == std::string::npos; });
  return names;
}

std::vector<Source> sources_of_the_tree() {
  std::vector<Source> sources;
  const fs::path top = STEVEDORE_SOURCE_DIR;
  for (const auto& room : fs::directory_iterator(top)) {
    const std::string name = room.path().filename().string();
    if (!room.is_directory() || name == "build" || name == "report" || name.starts_with(".")) continue;
    for (const auto& entry : fs::recursive_directory_iterator(room.path())) {
      const std::string suffix = entry.path().extension().string();
      if (suffix != ".cpp" && suffix != ".hpp") continue;
      std::ifstream file(entry.path());
      sources.push_back({entry.path().lexically_relative(top).generic_string(),
                         {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()}});
    }
  }
  return sources;
}

bool breaks_a_rule(const std::string& path, const std::string& text) {
  return !faults_of({path, text}).empty();
}

}  // namespace

TEST_CASE("every source keeps the include rules") {
  const std::vector<Source> sources = sources_of_the_tree();
  REQUIRE(std::any_of(sources.begin(), sources.end(),
                      [](const Source& s) { return part_of(s.path) == Part::algorithm; }));
  for (const Source& source : sources) CHECK(faults_of(source) == Strings{});
}

TEST_CASE("every test case has a name that ctest can run") {
  for (const Source& source : sources_of_the_tree()) {
    INFO(source.path);
    CHECK(split_names_of(source) == Strings{});
  }
  CHECK(split_names_of({"tests/unit/x.cpp", "TEST_CASE(\"x in [0, 1)\") {}"}).size() == 1);
  CHECK(split_names_of({"tests/unit/x.cpp", "TEST_CASE(\"x is\"\n    \"small; y too\") {}"}).size() == 1);
  CHECK(split_names_of({"tests/unit/x.cpp", "TEST_CASE(\"x is small\", \"[tag]\") {}"}).empty());
}

TEST_CASE("algorithms know their inputs only") {
  const std::string file = "detector_proc/detector.cpp";
  CHECK_FALSE(breaks_a_rule(file,
                            "#include \"detector_proc/marks.hpp\"\n#include \"geometry/ellipse.hpp\"\n"
                            "#include <Eigen/Core>\n#include <opencv2/imgproc.hpp>\n#include <vector>\n"));
  CHECK_FALSE(breaks_a_rule(file, "// #include <chrono> would be wrong\n/* lcm::LCM too */\n"));
  for (const char* header :
       {"lcm/lcm-cpp.hpp", "lcmtypes/channels.hpp", "stevedore/frame_t.hpp", "runtime/bus.hpp",
        "tracker_proc/tracker.hpp", "sim_proc/world/world.hpp", "chrono", "fstream", "filesystem", "thread",
        "mutex", "unistd.h", "opencv2/highgui.hpp", "spdlog/spdlog.h"}) {
    INFO(header);
    CHECK(breaks_a_rule(file, "#include <" + std::string(header) + ">\n"));
    CHECK(breaks_a_rule("platform/estimator.hpp", "#  include \"" + std::string(header) + "\"\n"));
  }
  CHECK(breaks_a_rule("geometry/ellipse.cpp", "#include \"detector_proc/marks.hpp\"\n"));
  CHECK(breaks_a_rule(file, "auto t = cv::getTickCount();\n"));
  CHECK(breaks_a_rule(file, "printf(\"%d\", n);\n"));
  CHECK_FALSE(breaks_a_rule(file, "std::snprintf(text, sizeof text, \"%d\", n);\n"));
}

TEST_CASE("the camera's sources reach devices and files, but not the bus") {
  const std::string file = "camera_proc/source_v4l2.cpp";
  CHECK_FALSE(
      breaks_a_rule(file, "#include <chrono>\n#include <filesystem>\n#include <linux/videodev2.h>\n"));
  CHECK(breaks_a_rule(file, "#include \"runtime/bus.hpp\"\n"));
  CHECK(breaks_a_rule("camera_proc/pacing.cpp", "#include <chrono>\n"));
}

TEST_CASE("the world is an algorithm: only the thread that draws it is none") {
  CHECK_FALSE(breaks_a_rule("sim_proc/render_thread.cpp", "#include <thread>\n#include <mutex>\n"));
  CHECK(breaks_a_rule("sim_proc/render_thread.cpp", "#include \"runtime/bus.hpp\"\n"));
  CHECK_FALSE(breaks_a_rule("sim_proc/world/world.cpp", "#include \"sim_proc/world/dice.hpp\"\n"));
  CHECK(breaks_a_rule("sim_proc/world/world.cpp", "#include <chrono>\n"));
  CHECK(breaks_a_rule("sim_proc/world/world.cpp", "#include \"runtime/time.hpp\"\n"));
  CHECK(breaks_a_rule("sim_proc/world/world.cpp", "#include \"gimbal_proc/gimbal.hpp\"\n"));
  CHECK(breaks_a_rule("sim_proc/sim_stage.cpp", "#include <chrono>\n"));
  CHECK(breaks_a_rule("mission_proc/main.cpp", "#include \"sim_proc/world/truth.hpp\"\n"));
}

TEST_CASE("of the world only its workers know threads") {
  CHECK_FALSE(breaks_a_rule("sim_proc/world/workers.cpp", "#include <thread>\n#include <mutex>\n"));
  CHECK(breaks_a_rule("sim_proc/world/renderer.cpp", "#include <thread>\n"));
  CHECK(breaks_a_rule("sim_proc/world/workers.cpp", "#include \"runtime/bus.hpp\"\n"));
}

TEST_CASE("stages see messages, not their carrier") {
  const std::string file = "tracker_proc/tracker_stage.cpp";
  CHECK_FALSE(breaks_a_rule(file,
                            "#include \"runtime/bus.hpp\"\n#include \"lcmtypes/channels.hpp\"\n"
                            "#include \"tracker_proc/tracker.hpp\"\n"));
  CHECK(breaks_a_rule(file, "#include <lcm/lcm-cpp.hpp>\n"));
  CHECK(breaks_a_rule(file, "#include \"runtime/lcm_bus.hpp\"\n"));
  CHECK(breaks_a_rule(file, "#include \"detector_proc/detector.hpp\"\n"));
  CHECK(breaks_a_rule(file, "#include <chrono>\n"));
}

TEST_CASE("a main puts its room and the runtime together, and no more") {
  const std::string file = "pose_proc/main.cpp";
  CHECK_FALSE(
      breaks_a_rule(file, "#include \"pose_proc/pose_stage.hpp\"\n#include \"runtime/process.hpp\"\n"));
  CHECK(breaks_a_rule(file, "#include \"tracker_proc/tracker_stage.hpp\"\n"));
  CHECK(breaks_a_rule(file, std::string(max_main_lines + 1, '\n')));
}

TEST_CASE("threads of OpenCV and the truth of the simulator stay where they belong") {
  CHECK(breaks_a_rule("pose_proc/main.cpp", "cv::setNumThreads(4);\n"));
  CHECK_FALSE(breaks_a_rule("runtime/process.cpp", "cv::setNumThreads(1);\n"));
  CHECK(breaks_a_rule("runtime/process.cpp", "#include \"pose_proc/pose.hpp\"\n"));
  for (const char* stage :
       {"camera_proc/camera_stage.cpp", "detector_proc/detector_stage.cpp", "tracker_proc/tracker_stage.cpp",
        "pose_proc/pose_stage.cpp", "mission_proc/mission_stage.cpp", "gimbal_proc/gimbal_stage.cpp",
        "platform/estimator.cpp", "runtime/process.cpp"}) {
    INFO(stage);
    CHECK(breaks_a_rule(stage, "bus.subscribe(channels::truth, handler);\n"));
  }
  CHECK(breaks_a_rule("runtime/bus.cpp", "listen(\"TRUTH\");\n"));
  CHECK_FALSE(breaks_a_rule("tools/evaluate.cpp", "bus.subscribe(channels::truth, handler);\n"));
}
