// The operator's word to mission_proc, from a terminal.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <optional>
#include <string>

#include "lcmtypes/names.hpp"
#include "runtime/command_line.hpp"
#include "runtime/lcm_bus.hpp"
#include "runtime/process.hpp"

namespace {

using namespace stevedore;

constexpr int wait_ms = 50;

const std::map<std::string, int8_t> words = {{"start", mission_command_t::COMMAND_START},
                                             {"hold", mission_command_t::COMMAND_HOLD},
                                             {"resume", mission_command_t::COMMAND_RESUME},
                                             {"abort", mission_command_t::COMMAND_ABORT},
                                             {"choose", mission_command_t::COMMAND_CHOOSE}};

/// Whether it was said by somebody who had read a command of that run.
bool knows(const mission_t& mission, int64_t run_id) {
  const auto& inputs = mission.header.trace.inputs;
  return std::any_of(inputs.begin(), inputs.end(), [run_id](const input_mark_t& mark) {
    return mark.channel == channels::mission_command.name && mark.run_id == run_id;
  });
}

/// Says it, and waits for the MISSION that answers.
int tell(LcmBus& bus, mission_command_t command, double patience_s) {
  std::optional<mission_t> newest;
  bus.subscribe<mission_t>(channels::mission, [&newest](const mission_t& m) { newest = m; });
  command.header.utime = bus.now_utime();
  command.header.frame_seq = -1;
  bus.publish(channels::mission_command, command);
  const int64_t until_utime = bus.now_utime() + static_cast<int64_t>(patience_s * 1e6);
  while (!stop_requested() && bus.now_utime() < until_utime) {
    bus.handle(wait_ms);
    if (!newest || !knows(*newest, bus.run_id())) continue;
    fmt::print("{}: {}\n", phase_name(newest->phase), newest->reason);
    return 0;
  }
  if (stop_requested()) return exit_stopped;
  const char* what = newest ? "MISSION is on the bus, but its sender did not hear the command"
                            : "No MISSION: mission_proc does not run, or on another bus";
  fmt::print(stderr, "{}, in {:.1f} s.\n", what, patience_s);
  return exit_failed;
}

int run(int argc, char** argv) {
  CLI::App app("Tells mission_proc the operator's word, and what came of it: the phase, and why.", "tell");
  std::string url = default_lcm_url;
  double patience_s = 2;
  mission_command_t command{};
  command.track_id = command.platform = command.slot = -1;
  std::string word;
  app.add_option("WORD", word, "resume: also from suspended")->required()->check(CLI::IsMember(words));
  auto* track = app.add_option("--track", command.track_id, "choose: this mark (job: watch)");
  auto* platform = app.add_option("--platform", command.platform, "choose: of this platform (job: carry)");
  auto* slot = app.add_option("--slot", command.slot, "choose: this circle (job: carry)");
  platform->needs(slot)->excludes(track);
  slot->needs(platform);
  app.add_option("--patience", patience_s, "seconds to wait for an answer")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--lcm-url", url, "LCM's address")->capture_default_str();
  parse_command_line(app, argc, argv, "1 if nobody answered, 130 when stopped by a signal");
  command.command = words.at(word);
  const bool names_one = *track || *platform;
  if (names_one != (command.command == mission_command_t::COMMAND_CHOOSE))
    throw UsageError("choose, and nothing else, takes --track N or --platform P --slot S");
  stop_on_signals();
  LcmBus bus(url);
  return tell(bus, command, patience_s);
}

}  // namespace

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] { return run(argc, argv); });
}
