// Whole missions in lock step.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <opencv2/core/utility.hpp>

#include "lcmtypes/names.hpp"
#include "runtime/command_line.hpp"
#include "runtime/kernel.hpp"
#include "tools/campaign_core.hpp"

using namespace stevedore;

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  return guarded_main([&] {
    CLI::App app("Flies whole missions in the simulated world, in lock step.");
    std::string config_path, log;
    std::vector<std::string> sets;
    std::int64_t seed = 1;
    double longest_s = 1200;
    app.add_option("--config", config_path, "configuration, as config/world.yaml")->required();
    app.add_option("--set", sets, "SECTION.NAME=VALUE over the configuration");
    app.add_option("--seed", seed, "of the world")->capture_default_str();
    app.add_option("--longest", longest_s, "seconds of flight after which it is given up")
        ->capture_default_str();
    app.add_option("--log", log, "LCM log of every message, TRUTH among them");
    CLI11_PARSE(app, argc, argv);
    std::vector<std::string> all{"sim.pilot=mission", "sim.rate_hz=10", "mission.job=carry",
                                 "mission.start_at_once=true", fmt::format("sim.seed={}", seed)};
    all.insert(all.end(), sets.begin(), sets.end());
    const Config config = Config::load(config_path, all);
    std::unique_ptr<LogWriter> writer;
    if (!log.empty()) writer = std::make_unique<LogWriter>(log);
    LockStep flight(config, name_in_this_network(fmt::format("campaign-{}-{}", getpid(), seed)),
                    [&](const LogEvent& e) {
                      if (writer) writer->write(e);
                    });
    const auto outcome = fly_mission(flight, config, longest_s, [](double t, const mission_t& m) {
      std::string e;
      for (const auto& each : m.emergencies) e += std::string(" !") + emergency_name(each.kind);
      fmt::print("{:7.2f} {:12} {} / {} {}{}\n", t, phase_name(m.phase), m.delivered, m.attempts, m.reason,
                 e);
      fflush(stdout);
    });
    fmt::print("seed {} delivered {} of {} told {} attempts {} {:.0f} s, {}\n", outcome.seed,
               outcome.delivered, outcome.wanted, outcome.told_delivered, outcome.attempts,
               outcome.duration_s, outcome.cause);
    for (const double e : outcome.drop_error_m) fmt::print("  drop error {:.3f} m\n", e);
    return 0;
  });
}
