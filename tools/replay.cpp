// Runs the stages over a log and writes a new log.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <opencv2/core.hpp>
#include <sstream>

#include "runtime/process.hpp"
#include "tools/flown_configuration.hpp"
#include "tools/replay_compare.hpp"
#include "tools/replay_core.hpp"

namespace {

using namespace stevedore;
namespace fs = std::filesystem;

struct Options {
  std::string log, out, config_file;
  std::vector<std::string> overrides, stages;
  bool as_flown = false, every_frame = false;
};

void declare(CLI::App& app, Options& o) {
  app.add_option("LOG", o.log,
                 "log of a flight, with its frames' pixels (of record, or of a set started with "
                 "camera.transport=jpeg)")
      ->required();
  app.add_option("--out", o.out, "log to write; it gets its name when it is complete")->required();
  app.add_option(
      "--config", o.config_file,
      "the flight's configuration [config.yaml beside the log with the settings of settings.txt, where "
      "./run keeps them]");
  app.add_option("--set", o.overrides, "section.key=value, over what the files say")
      ->take_all()
      ->allow_extra_args(false);
  app.add_option("--stages", o.stages,
                 "only these processes, by name; the others' messages come from the log")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(replayable_processes()));
  auto* flown = app.add_flag(
      "--as-flown", o.as_flown,
      "exactly the inputs each stage had in flight, and their answers compared: to the bit, or within stated "
      "tolerances where the frames are JPEG. Of a log that starts in mid-flight only stages without memory "
      "(the "
      "detector) can be equal");
  app.add_flag("--every-frame", o.every_frame, "every frame of the log (the default)")->excludes(flown);
  app.footer(fmt::format("Tolerances where frames are JPEG: {}.", lossy_tolerances));
}

std::string text_of(const std::string& path) {
  std::ostringstream text;
  if (!path.empty()) text << std::ifstream(path).rdbuf();
  return text.str();
}

/// A log that takes its name, and the place of what had it, when it is complete.
class NewLog {
 public:
  explicit NewLog(const std::string& path) : path_(path), written_(path), writer_(name_to_write()) {}
  ~NewLog() {
    std::error_code ignored;
    if (written_ != path_) fs::remove(written_, ignored);
  }
  NewLog(const NewLog&) = delete;
  NewLog& operator=(const NewLog&) = delete;

  void write(const LogEvent& event) { writer_.write(event); }
  void keep() {
    writer_.flush();
    if (written_ != path_) fs::rename(written_, path_);
    written_ = path_;
  }

 private:
  /// A device can't be replaced: it is written as it is.
  std::string name_to_write() {
    if (!fs::exists(path_) || fs::is_regular_file(path_)) written_ += fmt::format(".part-{}", getpid());
    return written_;
  }

  const std::string path_;
  std::string written_;
  LogWriter writer_;
};

/// What is read must not be what is written.
void check_output(const Options& o, const FlownConfiguration& flown) {
  if (fs::is_directory(o.out)) throw UsageError("--out " + o.out + ": is a folder");
  for (const std::string& input : {o.log, flown.file}) {
    std::error_code missing;  // then they are not the same
    if (!input.empty() && fs::equivalent(input, o.out, missing))
      throw UsageError("--out " + o.out + ": is " + input + ", which is read");
  }
}

void print_table(const ReplayResult& result) {
  const auto within = [&result](const std::string& text) {
    return result.frames_are_lossy ? fmt::format("{:>11}", text) : std::string();
  };
  fmt::print("{:<16}{:>10}{}{:>11}{:>13}{:>15}\n", "channel", "equal", within("tolerance"), "different",
             "only logged", "only replayed");
  for (const auto& [channel, c] : result.channels) {
    fmt::print("{:<16}{:>10}{}{:>11}{:>13}{:>15}\n", channel, c.equal,
               within(fmt::format("{}", c.within_tolerance)), c.different, c.only_logged, c.only_replayed);
  }
}

/// What the log lacks, a line each.
void print_lacks(const std::string& log, const ReplayResult& result) {
  if (!result.damage.empty()) fmt::print("{}: {}\n", log, describe(result.damage));
  if (result.unreadable > 0)
    fmt::print("{} messages in the log can't be read: damaged, or of another version\n", result.unreadable);
  if (result.frames_elsewhere > 0) {
    fmt::print("{} frames of {} are in the log without their pixels: no stage could see them\n",
               result.frames_elsewhere, log);
  }
  if (result.missing_inputs > 0) {
    fmt::print("{} inputs that the flight had read are not in the log: answers to them can differ\n",
               result.missing_inputs);
  }
}

void print_verdict(const ReplayResult& result) {
  if (!result.as_flown()) {
    const bool within = result.frames_are_lossy;
    fmt::print("NOT as flown ({})\n",
               within ? "compared within tolerances, see --help" : "compared to the bit");
  } else if (result.equal_to_the_bit()) {
    fmt::print("as flown: every payload is equal to the bit\n");
  } else {
    fmt::print("as flown within tolerances (the log's frames are JPEG): {}\n", lossy_tolerances);
  }
}

ReplayResult replay_into(NewLog& out, const Options& o, const ReplayOptions& options) {
  const bool terminal = isatty(STDERR_FILENO) == 1;
  const auto write = [&out](const LogEvent& event) {
    if (stop_requested()) throw ProgramEnd{exit_stopped};  // nothing half done is left
    out.write(event);
  };
  const auto result = replay(o.log, options, write, [terminal](double done) {
    if (terminal) fmt::print(stderr, "\r{:3.0f} %", 100 * done);
  });
  if (terminal) fmt::print(stderr, "\r     \r");
  return result;
}

int run(int argc, char** argv) {
  CLI::App app(
      "Runs the real code of the stages over a log, in lock step and as fast as it can, and writes a new "
      "log.",
      "replay");
  Options o;
  declare(app, o);
  parse_command_line(
      app, argc, argv,
      "1 if the log is damaged or lacks pixels, or (--as-flown) a payload differs, 130 if it was "
      "stopped");
  cv::setNumThreads(1);
  stop_on_signals();
  static_cast<void>(LogReader(o.log));  // says what is wrong with the log before anything else is looked at
  const FlownConfiguration flown = flown_configuration(o.log, o.config_file, o.overrides);
  check_output(o, flown);

  ReplayOptions options;
  options.mode = o.as_flown ? ReplayMode::as_flown : ReplayMode::every_frame;
  if (!o.stages.empty()) options.stages = {o.stages.begin(), o.stages.end()};
  options.config = Config::load(flown.file, flown.settings);
  options.config_text = text_of(flown.file) + text_of(options.config.camera_file()) +
                        fmt::format("{}", fmt::join(flown.settings, "\n"));
  NewLog out(o.out);
  const ReplayResult result = replay_into(out, o, options);
  out.keep();
  print_table(result);
  print_lacks(o.log, result);
  if (o.as_flown) print_verdict(result);
  return result.complete() && (!o.as_flown || result.as_flown()) ? 0 : exit_failed;
}

}  // namespace

int main(int argc, char** argv) {
  return guarded_main([&] { return run(argc, argv); });
}
