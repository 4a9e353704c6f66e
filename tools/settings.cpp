// Every setting of every section, with default, unit, range and the effect of raising it: docs/tuning.md is
// this output.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

#include "camera_proc/source.hpp"
#include "detector_proc/detector_settings.hpp"
#include "gimbal_proc/gimbal.hpp"
#include "mission_proc/mission.hpp"
#include "platform/platform_settings.hpp"
#include "pose_proc/pose_settings.hpp"
#include "runtime/process.hpp"
#include "sim_proc/sim_stage.hpp"
#include "tools/record_settings.hpp"
#include "tracker_proc/tracker.hpp"

namespace {

/// Visits a settings struct and prints a row of a Markdown table for each setting.
class MarkdownTable {
 public:
  explicit MarkdownTable(std::string prefix = "") : prefix_(std::move(prefix)) {}

  template <class Number>
  void operator()(const char* key, Number& value, double lowest, double highest, const char* unit,
                  const char* effect) {
    row(key, fmt::format("{}", value), fmt::format("{} to {} {}", lowest, highest, unit), effect);
  }
  void operator()(const char* key, bool& value, const char* effect) {
    row(key, value ? "true" : "false", "true or false", effect);
  }
  void operator()(const char* key, std::string& value, const char* effect) {
    row(key, quoted(value), "text", effect);
  }
  void choice(const char* key, std::string& value, std::initializer_list<const char*> options,
              const char* effect) {
    row(key, quoted(value), fmt::format("{}", fmt::join(options, ", ")), effect);
  }
  template <class T>
  void list(const char* key, std::vector<T>& values, const char* effect) {
    row(key, fmt::format("{} entries", values.size()), "list", effect);
    T element{};
    MarkdownTable table(prefix_ + key + "[]");
    table.prefix_ += ".";
    describe(element, table);
  }

 private:
  static std::string quoted(const std::string& text) { return text.empty() ? "''" : text; }
  void row(const char* key, const std::string& value, const std::string& range, const char* effect) const {
    fmt::print("| `{}{}` | {} | {} | {} |\n", prefix_, key, value, range, effect);
  }

  std::string prefix_;
};

template <class Settings>
void print(const char* section) {
  fmt::print("\n## {}\n\n| setting | default | range | effect |\n|---|---|---|---|\n", section);
  Settings settings{};
  MarkdownTable table;
  describe(settings, table);
}

int run(int argc, char** argv) {
  CLI::App app("Prints every setting of the configuration as Markdown: sections, defaults, ranges, effects.",
               "settings");
  stevedore::parse_command_line(app, argc, argv);
  fmt::print(
      "# Settings\n\nMade by `settings`. A deployment's YAML file (config/) has a section a process; what it "
      "does not name has "
      "the default below. `--set section.key=value` on the command line goes over the file. `camera_file` at "
      "the top of "
      "the file names the camera's calibration, relative to the file; `bus.url` LCM's address.\n");
  print<stevedore::CameraSettings>("camera");
  print<stevedore::DetectorSettings>("detector");
  print<stevedore::TrackerSettings>("tracker");
  print<stevedore::PoseSettings>("pose");
  print<stevedore::PlatformSettings>("platform");
  print<stevedore::MissionSettings>("mission");
  print<stevedore::RecordSettings>("record");
  print<stevedore::GimbalSettings>("gimbal");
  print<stevedore::SimSettings>("sim");
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] { return run(argc, argv); });
}
