#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>

#include "runtime/event_log.hpp"
#include "runtime/process.hpp"
#include "tools/report_core.hpp"

namespace {

void write_file(const std::filesystem::path& path, const std::string& text) {
  std::error_code ignored;  // the file says whether the folder is there
  std::filesystem::create_directories(path.parent_path(), ignored);
  std::ofstream file(path);
  file << text << std::flush;
  if (!file) throw std::runtime_error(path.string() + ": can't be written");
}

int run(int argc, char** argv) {
  CLI::App app("Reads a log and says how the run went: frames in and out, lost and skipped, latencies.",
               "report");
  std::string log, out;
  bool json = false;
  app.add_option("LOG", log, "a log written by record or lcm-logger")->required()->check(CLI::ExistingFile);
  app.add_option("--out", out, "folder for report.json; made if it is not there");
  app.add_flag("--json", json, "print report.json's text instead of the table");
  app.set_version_flag("--version", stevedore::version());
  app.footer(
      "lost: numbers missing, messages damaged, frames gone from the ring before they were read.\n"
      "skipped: passed over by choice because a newer frame was there. kernel drops show up as lost too.\n"
      "A stage's latency runs from the publishing of what it answers to its own publishing; the\n"
      "camera's from capture. cpu %: of one core, mean over the run. Processes that no frame goes through\n"
      "stand below the line, with the messages that they received and sent.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }

  stevedore::LogReader reader(log);
  stevedore::LogSummary summary;
  while (const auto event = reader.next()) summary.add(*event);
  const stevedore::Report report = summary.report();
  bool empty = true;
  for (const auto& stage : report.stages) empty = empty && stage.out == 0 && !stage.lost;
  if (empty) {
    throw std::runtime_error(fmt::format(
        "{}: nothing of this system can be read in it ({} messages on its channels are unreadable)", log,
        report.unreadable));
  }

  const std::string text = stevedore::to_json(report, log).dump(2) + "\n";
  if (!out.empty()) write_file(std::filesystem::path(out) / "report.json", text);
  fmt::print("{}", json ? text : stevedore::to_text(report));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] { return run(argc, argv); });
}
