#include "runtime/process.hpp"

#include <fmt/format.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <atomic>
#include <csignal>
#include <opencv2/core.hpp>

#include "lcmtypes/names.hpp"
#include "runtime/kernel.hpp"
#include "runtime/time.hpp"

namespace stevedore {
namespace {

std::atomic<bool> stop_flag = false;
static_assert(std::atomic<bool>::is_always_lock_free);  // set in a signal handler

constexpr int64_t health_period_us = 1'000'000;
constexpr int64_t timeout_period_us = 500'000;
/// Longest wait without looking at stop signals and HEALTH.
constexpr int wait_ms = 50;

double percentile_ms(const std::vector<int64_t>& sorted_us, double share) {
  if (sorted_us.empty()) return -1;
  const auto index = static_cast<size_t>(share * static_cast<double>(sorted_us.size() - 1) + 0.5);
  return static_cast<double>(sorted_us[index]) * 1e-3;
}

struct BusSettings {
  std::string url = default_lcm_url;
};

template <class Visitor>
void describe(BusSettings& s, Visitor& visit) {
  visit("url", s.url, "LCM's address; ttl=0 keeps everything on this host");
}

void open_log(const std::string& name, const std::string& level) {
  auto log = spdlog::stderr_color_mt(name);
  log->set_pattern("%Y-%m-%d %H:%M:%S.%e %n %^%l%$ %v");
  log->set_level(spdlog::level::from_str(level));
  spdlog::set_default_logger(log);
}

}  // namespace

std::string bus_url(const Config& config) {
  return config.section<BusSettings>("bus").url;
}

bool stop_requested() {
  return stop_flag;
}

void stop_on_signals() {
  struct sigaction action {};
  action.sa_handler = [](int) { stop_flag = true; };
  sigaction(SIGTERM, &action, nullptr);
  sigaction(SIGINT, &action, nullptr);
}

Process::Process(int argc, char** argv, std::string name, const std::string& what_it_does,
                 const std::function<void(CLI::App&)>& more_options)
    : name_(std::move(name)), start_utime_(monotonic_utime()) {
  CLI::App app(what_it_does, name_);
  std::string config_file, url, level = "info";
  std::vector<std::string> overrides;
  app.add_option("--config", config_file,
                 "the deployment's YAML file; without one every setting has its default");
  app.add_option("--set", overrides, "section.key=value, over what the file says")->take_all();
  app.add_option("--lcm-url", url, fmt::format("LCM's address, over bus.url [{}]", default_lcm_url));
  app.add_option("--log-level", level, "trace, debug, info, warning, error or off")
      ->check(CLI::IsMember({"trace", "debug", "info", "warning", "error", "off"}));
  if (more_options) more_options(app);
  parse_command_line(app, argc, argv);
  open_log(name_, level);
  cv::setNumThreads(1);
  stop_on_signals();
  config_ = Config::load(config_file, overrides);
  bus_ = std::make_unique<LcmBus>(url.empty() ? bus_url(config_) : url);
}

Process::~Process() {
  spdlog::shutdown();
}

void Process::watch_silence(const Channel<vehicle_state_t>& channel, double silent_s) {
  silence_ = Silence{channel.name, silent_s, 0, monotonic_utime(), 0};
}

int Process::run(const std::function<Condition()>& work) {
  spdlog::info("running, pid {}", getpid());
  while (!stop_requested()) {
    bus_->handle(work ? 0 : wait_ms);
    if (work) set_condition(work());
    if (silence_) publish_timeouts();
    if (monotonic_utime() - health_utime_ >= health_period_us) publish_health();
  }
  bus_->handle(0);  // what has arrived
  publish_health();
  bus_->handle(0);  // a recorder hears its own last HEALTH
  spdlog::info("stopped");
  return 0;
}

void Process::set_condition(const Condition& condition) {
  const bool changed = condition.state != condition_.state;
  if (changed) {
    const bool bad = condition.state == health_t::STATE_DEGRADED || condition.state == health_t::STATE_FAILED;
    spdlog::log(bad ? spdlog::level::warn : spdlog::level::info, "{}: {}", state_name(condition.state),
                condition.message);
  }
  condition_ = condition;
  if (changed && condition.state == health_t::STATE_FINISHED)
    publish_health();  // who waits for it waits no longer
}

void Process::publish_timeouts() {
  const int64_t now = monotonic_utime();
  const int64_t handled = bus_->counters(silence_->channel).handled;
  if (handled != silence_->handled) {
    silence_->handled = handled;
    silence_->heard_utime = now;
  }
  const double silent_s = static_cast<double>(now - silence_->heard_utime) * 1e-6;
  if (silent_s < silence_->silent_s || now - silence_->told_utime < timeout_period_us) return;
  silence_->told_utime = now;
  timeout_t message{};
  message.header.utime = std::max<int64_t>(0, bus_->stream_utime());
  message.header.frame_seq = -1;
  message.channel = silence_->channel;
  message.silent_s = silent_s;
  bus_->publish(channels::timeout, message);
}

void Process::publish_health() {
  const int64_t now = monotonic_utime();
  const double cpu_s = cpu_time_s();
  // the first report has no second behind it
  const double elapsed_s = health_utime_ == 0 ? 0 : static_cast<double>(now - health_utime_) * 1e-6;
  const auto rate = [elapsed_s](int64_t count) {
    return elapsed_s > 0 ? static_cast<double>(count) / elapsed_s : 0;
  };

  health_t health{};
  health.header.utime = now;
  health.header.frame_seq = -1;
  health.process = name_;
  health.pid = getpid();
  health.utc_offset_us = utc_offset_us();
  health.uptime_s = static_cast<double>(now - start_utime_) * 1e-6;
  health.state = condition_.state;
  health.message = condition_.message;
  health.kernel_drops = kernel_udp_drops();
  health.cpu_share = elapsed_s > 0 ? (cpu_s - cpu_s_) / elapsed_s : 0;
  health.memory_mb = resident_mb();
  for (const auto& channel : bus_->inputs()) {
    const InputCounters& counters = bus_->counters(channel);
    auto ages_us = bus_->take_ages_us(channel);
    std::sort(ages_us.begin(), ages_us.end());
    input_health_t input{};
    input.channel = channel;
    input.received = counters.received;
    input.handled = counters.handled;
    input.lost_gap = counters.lost_gap;
    input.lost_malformed = counters.lost_malformed;
    input.lost_stale = counters.lost_stale;
    input.lost_overwritten = counters.lost_overwritten;
    input.skipped = counters.skipped;
    input.rate_hz = rate(counters.handled - std::exchange(handled_before_[channel], counters.handled));
    input.age_p50_ms = percentile_ms(ages_us, 0.50);
    input.age_p99_ms = percentile_ms(ages_us, 0.99);
    health.inputs.push_back(input);
  }
  if (condition_.source) {
    input_health_t& source = health.inputs.emplace_back(*condition_.source);
    source.rate_hz = rate(source.handled - std::exchange(handled_before_[source.channel], source.handled));
    source.age_p50_ms = source.age_p99_ms = -1;
  }
  for (const auto& [channel, count] : bus_->published()) {
    output_health_t output{};
    output.channel = channel;
    output.published = count;
    output.rate_hz = rate(count - std::exchange(published_before_[channel], count));
    health.outputs.push_back(output);
  }
  health.input_count = static_cast<int16_t>(health.inputs.size());
  health.output_count = static_cast<int16_t>(health.outputs.size());
  health_utime_ = now;
  cpu_s_ = cpu_s;
  bus_->publish(channels::health, health);
}

}  // namespace stevedore
