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

nlohmann::ordered_json to_json(const std::vector<stevedore::DamagedPart>& damage) {
  auto list = nlohmann::ordered_json::array();
  for (const auto& part : damage) list.push_back({{"position", part.position}, {"bytes", part.bytes}});
  return list;
}

int run(int argc, char** argv) {
  CLI::App app("Reads a log and says how the run went: frames in and out, lost and skipped, latencies.",
               "report");
  std::string log, out;
  bool json = false;
  int cargoes = 0;
  app.add_option("LOG", log, "a log written by record or lcm-logger")->required()->check(CLI::ExistingFile);
  app.add_option("--out", out, "folder for report.json; made if it is not there");
  app.add_flag("--json", json, "print report.json's text instead of the table");
  app.add_option("--cargoes", cargoes, "a mission to carry that many: exit status 1 if fewer were delivered")
      ->check(CLI::PositiveNumber);
  app.footer(
      "lost: numbers missing, messages damaged, frames gone from the ring before they were read.\n"
      "skipped: passed over by choice because a newer frame was there. kernel drops show up as lost too.\n"
      "A stage's latency runs from the publishing of what it answers to its own publishing; the\n"
      "camera's from capture. cpu %: of one core, mean over the run. Processes that no frame goes through\n"
      "stand below the line, with the messages that they received and sent.\n"
      "altitude below 2 m: the camera's height over the plane of the target's circle as MISSION told it, "
      "less\n"
      "TRUTH's, from the beginning of each descent to the end of the climb; measured: that frame showed a\n"
      "circle of the platform.");
  stevedore::parse_command_line(
      app, argc, argv,
      "1 if the log is damaged, nothing of this system is in it, or too little was delivered");

  stevedore::LogReader reader(log);
  stevedore::LogSummary summary;
  while (const auto event = reader.next()) summary.add(*event);
  stevedore::Report report = summary.report();
  bool empty = true;
  for (const auto& stage : report.stages) empty = empty && stage.out == 0 && !stage.lost;
  if (empty) {
    throw std::runtime_error(fmt::format(
        "{}: nothing of this system can be read in it ({} messages on its channels are unreadable). {}", log,
        report.unreadable, stevedore::describe(reader.damage())));
  }

  if (cargoes > 0 && !report.mission) report.mission.emplace();  // it never flew
  auto object = stevedore::to_json(report, log);
  object["damaged"] = to_json(reader.damage());
  // a file's name and a message's text are any bytes
  const std::string text =
      object.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
  if (!out.empty()) write_file(std::filesystem::path(out) / "report.json", text);
  fmt::print("{}", json ? text : stevedore::to_text(report));
  const bool all_delivered = cargoes == 0 || report.mission->delivered() >= cargoes;
  if (reader.damage().empty()) return all_delivered ? 0 : stevedore::exit_failed;
  std::fflush(stdout);
  fmt::print(stderr, "{}: {}\n", log, stevedore::describe(reader.damage()));
  return stevedore::exit_failed;
}

}  // namespace

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] { return run(argc, argv); });
}
