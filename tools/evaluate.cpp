#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>
#include <utility>

#include "runtime/command_line.hpp"
#include "tools/evaluate_core.hpp"
#include "tools/evaluate_page.hpp"

namespace {

namespace fs = std::filesystem;

void write_file(const fs::path& path, const std::string& text) {
  std::ofstream file(path);
  file << text << std::flush;
  if (!file) throw std::runtime_error(path.string() + ": can't be written");
}

int run(int argc, char** argv) {
  CLI::App app(
      "Says how good the vision of a flight was: poses, ids, platforms and slots against TRUTH, altitude "
      "against "
      "the laser, latencies. Prints a table, and writes a page for people and JSON for programs.",
      "evaluate");
  std::string log, out, reference, config;
  std::vector<std::string> settings;
  app.add_option("LOG", log, "log of a flight (recording.lcm of ./run)")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("--out", out, "folder for evaluation.html and evaluation.json [that of LOG]");
  app.add_option("--reference", reference,
                 "another log of the same frames: its POSES are a second source to compare with")
      ->check(CLI::ExistingFile);
  app.add_option("--config", config,
                 "the flight's configuration, which says where the laser sits and which camera flew "
                 "[config.yaml beside LOG with the settings of settings.txt, where ./run keeps them]")
      ->check(CLI::ExistingFile);
  app.add_option("--set", settings, "section.key=value, over what the files say")
      ->take_all()
      ->allow_extra_args(false);
  app.footer(
      "Without a configuration errors that camera and paint give to all poses of a flight count as each "
      "pose's own. "
      "TRUTH is only there in logs of the simulated world.");
  stevedore::parse_command_line(app, argc, argv, "1 if a log is damaged or nothing in it can be evaluated");

  const stevedore::Evaluation evaluation =
      stevedore::evaluate(log, stevedore::flown_configuration(log, config, settings), reference);
  const fs::path folder = out.empty() ? fs::path(log).parent_path() : fs::path(out);
  std::error_code ignored;  // the file says whether the folder is there
  fs::create_directories(folder, ignored);
  write_file(folder / "evaluation.html", stevedore::to_html(evaluation));
  const nlohmann::ordered_json json = stevedore::to_json(evaluation);
  // a file's name is any bytes
  write_file(folder / "evaluation.json",
             json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n");
  fmt::print("{}\nKept: {}, {}\n", stevedore::to_text(evaluation), (folder / "evaluation.html").string(),
             (folder / "evaluation.json").string());
  std::fflush(stdout);
  int status = 0;
  for (const auto& [path, damage] :
       {std::pair(log, evaluation.flight.damage), std::pair(reference, evaluation.reference_damage)}) {
    if (damage.empty()) continue;
    fmt::print(stderr, "{}: {}\n", path, stevedore::describe(damage));
    status = stevedore::exit_failed;
  }
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] { return run(argc, argv); });
}
