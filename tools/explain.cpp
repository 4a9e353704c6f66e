// Why this circle, why not the others.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <optional>

#include "runtime/command_line.hpp"
#include "tools/explain_core.hpp"

namespace {

int run(int argc, char** argv) {
  CLI::App app("Says what the mission was about at an instant of a log: why this circle, why not the others.",
               "explain");
  std::string log, time;
  std::optional<std::int64_t> why;
  app.add_option("LOG", log, "a log of a run with mission_proc")->required()->check(CLI::ExistingFile);
  app.add_option("TIME", time, "seconds from the log's start, or utime:N, N as in the messages' headers")
      ->required();
  app.add_option("--why", why, "only this circle: its slot; where MISSION knows no slots, its track");
  app.footer(
      "A cost is in metres of way: the way of the hook, and what failures, neighbours, age and doubt are "
      "worth.\n"
      "Answers come from the newest MISSION at TIME. report LOG says how long the log is.");
  stevedore::parse_command_line(
      app, argc, argv, "1 if the log is damaged, no MISSION is in it by then, or --why names no candidate");

  const auto instant = stevedore::parse_instant(time);
  stevedore::LogReader reader(log);
  const auto tell_damage = [&] {
    if (reader.damage().empty()) return;
    std::fflush(stdout);
    fmt::print(stderr, "{}: {} What is told is from the rest.\n", log, stevedore::describe(reader.damage()));
  };
  try {
    const auto said = stevedore::said_at(reader, instant);
    fmt::print("{}", why ? stevedore::explain_one(said, *why) : stevedore::explain(said));
  } catch (const std::runtime_error&) {
    tell_damage();
    throw;
  }
  tell_damage();
  return reader.damage().empty() ? 0 : stevedore::exit_failed;
}

}  // namespace

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] { return run(argc, argv); });
}
