// Whole missions in lock step: one, or a campaign of many.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <thread>

#include "lcmtypes/names.hpp"
#include "runtime/command_line.hpp"
#include "runtime/kernel.hpp"
#include "runtime/process.hpp"
#include "tools/campaign_core.hpp"
#include "tools/campaign_workers.hpp"
#include "tools/progress_line.hpp"

using namespace stevedore;

namespace {

using Clock = std::chrono::steady_clock;

struct Options {
  std::string config_path, log, out = "campaign.jsonl", shard = "1/1";
  std::vector<std::string> sets, summary;
  std::int64_t seed = 1;
  double longest_s = 1200;
  int missions = 0;
  int jobs = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  bool json = false;
};

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

Config config_of(const Options& options, std::int64_t seed, const std::vector<std::string>& sets) {
  std::vector<std::string> all{"sim.pilot=mission", "sim.rate_hz=10", "mission.job=carry",
                               "mission.start_at_once=true", fmt::format("sim.seed={}", seed)};
  all.insert(all.end(), sets.begin(), sets.end());
  return Config::load(options.config_path, all);
}

void say(double t, const mission_t& m) {
  std::string e;
  for (const auto& each : m.emergencies) e += std::string(" !") + emergency_name(each.kind);
  fmt::print("{:7.2f} {:12} {} / {} {}{}\n", t, phase_name(m.phase), m.delivered, m.attempts, m.reason, e);
  std::fflush(stdout);
}

int fly_one(const Options& options) {
  const auto start = Clock::now();
  const Config config = config_of(options, options.seed, options.sets);
  std::unique_ptr<LogWriter> writer;
  if (!options.log.empty()) writer = std::make_unique<LogWriter>(options.log);
  LockStep flight(config, name_in_this_network(fmt::format("campaign-{}-{}", getpid(), options.seed)),
                  [&](const LogEvent& e) {
                    if (writer) writer->write(e);
                  });
  const auto outcome = options.json ? fly_mission(flight, config, options.longest_s)
                                    : fly_mission(flight, config, options.longest_s, say);
  if (writer) writer->flush();
  if (options.json) {
    fmt::print("{}\n", to_json_line(to_line(outcome, seconds_since(start))));
    return 0;
  }
  fmt::print("seed {} delivered {} of {} told {} attempts {} {:.0f} s, {}\n", outcome.seed, outcome.delivered,
             outcome.wanted, outcome.told_delivered, outcome.attempts, outcome.duration_s,
             outcome.cause.empty() ? "all delivered" : outcome.cause);
  for (const double e : outcome.drop_error_m) fmt::print("  drop error {:.3f} m\n", e);
  return 0;
}

/// Sea states 0 to 3 in turn. A core is a worker's, who draws with one thread and, since it may be killed,
/// leaves no shared memory behind.
std::vector<std::string> sets_of(const Options& options, std::int64_t seed) {
  std::vector<std::string> sets{fmt::format("sim.sea_state={}", seed % 4), "sim.render_threads=1",
                                "sim.transport=raw"};
  sets.insert(sets.end(), options.sets.begin(), options.sets.end());
  return sets;
}

std::vector<std::string> arguments_of(const Options& options, std::int64_t seed) {
  std::vector<std::string> arguments{"--json",
                                     "--config",
                                     options.config_path,
                                     "--seed",
                                     fmt::format("{}", seed),
                                     "--longest",
                                     fmt::format("{}", options.longest_s)};
  for (const std::string& set : sets_of(options, seed)) {
    arguments.emplace_back("--set");
    arguments.push_back(set);
  }
  return arguments;
}

MissionLine line_of(const Options& options, const WorkerEnd& end) {
  const auto line = mission_line_of(end.out);
  if (line && end.fault.empty()) return *line;
  const auto sim = config_of(options, end.seed, sets_of(options, end.seed)).section<SimSettings>("sim");
  MissionLine failed;
  failed.seed = end.seed;
  failed.sea_state = sim.sea_state;
  failed.of = sim.cargoes;
  failed.cause = end.fault.empty() ? "worker told nothing" : end.fault;
  failed.wall_s = end.wall_s;
  return failed;
}

int fly_many(const Options& options) {
  const auto start = Clock::now();
  const Shard shard = parse_shard(options.shard);
  MissionFile file(options.out);
  ProgressLine progress;
  WorkerOrders orders;
  orders.seeds = seeds_to_fly(options.seed, options.missions, shard, file.lines());
  orders.jobs = options.jobs;
  orders.arguments = [&](std::int64_t seed) { return arguments_of(options, seed); };
  orders.stops = stop_requested;
  int flown = 0, all = 0, failed = 0;
  const auto count = static_cast<int>(orders.seeds.size());
  stop_on_signals();
  progress.show(
      fmt::format("{} missions to fly, {} lines in {} already", count, file.lines().size(), options.out));
  orders.ended = [&](const WorkerEnd& end) {
    if (end.is_usage_error) throw UsageError(end.fault);  // of all missions, then
    const MissionLine line = line_of(options, end);
    file.add(line);
    ++flown;
    if (line.all()) ++all;
    if (line.duration_s == 0) ++failed;
    progress.show(fmt::format("{} of {} flown, {} with all delivered, {:.0f} min left; seed {}: {} of {} {}",
                              flown, count, all, seconds_since(start) / 60 * (count - flown) / flown,
                              line.seed, line.delivered, line.of, line.cause));
  };
  run_workers(orders);
  progress.end();
  if (stop_requested()) {
    fmt::print("stopped: the same command goes on with what is missing in {}\n", options.out);
    return exit_stopped;
  }
  fmt::print("{}", summary_of(file.lines()));
  if (flown > 0)
    fmt::print("this run: {} missions in {:.0f} s, {:.1f} an hour with {} at a time\n", flown,
               seconds_since(start), 3600 * flown / seconds_since(start), options.jobs);
  return failed > 0 ? exit_failed : 0;
}

int sum_up(const Options& options) {
  std::vector<MissionLine> lines;
  std::string torn;
  for (const std::string& path : options.summary) {
    const MissionLines more = read_mission_lines(path);
    if (more.is_torn) torn += fmt::format("left out: a torn last line of {}\n", path);
    lines.insert(lines.end(), more.lines.begin(), more.lines.end());
  }
  if (lines.empty()) throw std::runtime_error("no mission's line is in " + options.summary.front());
  fmt::print("{}{}", summary_of(lines), torn);
  return 0;
}

int run(int argc, char** argv) {
  CLI::App app("Flies whole missions in the simulated world, in lock step: one, or with --missions many.",
               "campaign");
  Options o;
  app.add_option("--config", o.config_path, "configuration, as config/world.yaml; needed to fly");
  app.add_option("--set", o.sets, "SECTION.NAME=VALUE over the configuration")->allow_extra_args(false);
  app.add_option("--seed", o.seed, "of the world; with --missions the first, counted up")
      ->check(CLI::NonNegativeNumber)
      ->capture_default_str();
  app.add_option("--longest", o.longest_s, "seconds of flight after which it is given up")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  auto* log = app.add_option("--log", o.log, "one mission: LCM log of every message, TRUTH among them");
  auto* json = app.add_flag("--json", o.json, "one mission: print its line of a campaign and nothing else");
  auto* missions =
      app.add_option("--missions", o.missions, "so many, at sea states 0 to 3 in turn (seed modulo 4)")
          ->check(CLI::PositiveNumber)
          ->excludes(log)
          ->excludes(json);
  app.add_option("--jobs", o.jobs, "missions at a time; a core each")
      ->check(CLI::PositiveNumber)
      ->capture_default_str()
      ->needs(missions);
  app.add_option("--shard", o.shard, "I/K: of the missions only every K-th, beginning with the I-th")
      ->capture_default_str()
      ->needs(missions);
  app.add_option("--out", o.out, "a JSON line a mission; seeds that are in it already are not flown again")
      ->capture_default_str()
      ->needs(missions);
  app.add_option("--summary", o.summary, "only sum up these files of lines")
      ->check(CLI::ExistingFile)
      ->excludes(missions);
  app.footer(
      "Delivered is what stands in a circle of the other platform by TRUTH. A worker that crashes is a "
      "mission\n"
      "that failed, with its cause. Files of shards are merged by cat. docs/campaign.md has examples.");
  parse_command_line(
      app, argc, argv,
      "1 on failure, also of a worker (missions that do not deliver are no failure), 130 if stopped");
  if (!o.summary.empty()) return sum_up(o);
  if (o.config_path.empty()) throw UsageError("--config FILE is needed to fly, as config/world.yaml");
  return o.missions > 0 ? fly_many(o) : fly_one(o);
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  return guarded_main([&] { return run(argc, argv); });
}
