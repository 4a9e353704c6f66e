// Runs the stages over a log and writes a new log.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <fstream>
#include <opencv2/core.hpp>
#include <sstream>

#include "runtime/process.hpp"
#include "tools/replay_core.hpp"

namespace {

std::string text_of(const std::string& path) {
  std::ostringstream text;
  if (!path.empty()) text << std::ifstream(path).rdbuf();
  return text.str();
}

void print(const stevedore::ReplayResult& result, bool as_flown) {
  fmt::print("{:<16}{:>10}{:>11}{:>13}{:>15}\n", "channel", "equal", "different", "only logged",
             "only replayed");
  for (const auto& [channel, c] : result.channels) {
    fmt::print("{:<16}{:>10}{:>11}{:>13}{:>15}\n", channel, c.equal, c.different, c.only_logged,
               c.only_replayed);
  }
  if (result.missing_inputs > 0) {
    fmt::print("{} inputs that the flight had read are not in the log: answers to them can differ\n",
               result.missing_inputs);
  }
  if (as_flown) fmt::print("{}\n", result.as_flown() ? "as flown: every payload is equal" : "NOT as flown");
}

}  // namespace

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] {
    CLI::App app(
        "Runs the real code of the stages over a log, in lock step and as fast as it can, and writes a new "
        "log.",
        "replay");
    std::string log, out, config_file;
    std::vector<std::string> overrides, stages;
    bool as_flown = false, every_frame = false;
    app.add_option("LOG", log,
                   "log of a flight, with its frames inline (record, or a set started with inline frames)")
        ->required();
    app.add_option("--out", out, "log to write")->required();
    app.add_option("--config", config_file, "the flight's configuration (./run keeps it beside the log)");
    app.add_option("--set", overrides, "section.key=value, over what the file says")
        ->take_all()
        ->allow_extra_args(false);
    app.add_option("--stages", stages,
                   "only these processes, by name; the others' messages come from the log [detector_proc to "
                   "mission_proc, and gimbal_proc where it flew]")
        ->delimiter(',')
        ->allow_extra_args(false)
        ->check(CLI::IsMember(stevedore::replayable_processes()));
    auto* flown =
        app.add_flag("--as-flown", as_flown,
                     "exactly the inputs each stage had in flight; exit status 1 if a payload differs. Of a "
                     "log that starts in mid-flight only stages without memory (the detector) can be equal");
    app.add_flag("--every-frame", every_frame, "every frame of the log (the default)")->excludes(flown);
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      return app.exit(error) == 0 ? 0 : 2;
    }
    cv::setNumThreads(1);

    stevedore::ReplayOptions options;
    options.mode = as_flown ? stevedore::ReplayMode::as_flown : stevedore::ReplayMode::every_frame;
    if (!stages.empty()) options.stages = {stages.begin(), stages.end()};
    options.config = stevedore::Config::load(config_file, overrides);
    options.config_text = text_of(config_file) + text_of(options.config.camera_file()) +
                          fmt::format("{}", fmt::join(overrides, "\n"));
    stevedore::LogWriter writer(out);
    const bool terminal = isatty(STDERR_FILENO) == 1;
    const auto result = stevedore::replay(
        log, options, [&writer](const stevedore::LogEvent& event) { writer.write(event); },
        [terminal](double done) {
          if (terminal) fmt::print(stderr, "\r{:3.0f} %", 100 * done);
        });
    if (terminal) fmt::print(stderr, "\r     \r");
    print(result, as_flown);
    return as_flown && !result.as_flown() ? 1 : 0;
  });
}
