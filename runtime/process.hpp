// What every process is built on: command line, configuration, log, bus, frames, HEALTH, and a clean stop.
//
//   int main(int argc, char** argv) {
//     return stevedore::guarded_main([&] {
//       stevedore::Process process(argc, argv, "foo_proc", "Does foo.");
//       stevedore::FooStage stage(process.settings<FooSettings>("foo"), process.bus(), process.frames());
//       return process.run();
//     });
//   }
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "runtime/command_line.hpp"
#include "runtime/condition.hpp"
#include "runtime/config.hpp"
#include "runtime/frame_codec.hpp"
#include "runtime/lcm_bus.hpp"

namespace CLI {
class App;
}

namespace stevedore {

class Process {
 public:
  /// Reads the command line (--config, --set, --lcm-url, --log-level, --help, --version) and the
  /// configuration, opens log and bus. Throws ConfigError, std::runtime_error, and ProgramEnd after --help
  /// and --version.
  Process(int argc, char** argv, std::string name, const std::string& what_it_does,
          const std::function<void(CLI::App&)>& more_options = {});
  ~Process();
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  template <class Settings>
  [[nodiscard]] Settings settings(const std::string& section) const {
    return config_.section<Settings>(section);
  }
  [[nodiscard]] const Config& config() const { return config_; }
  [[nodiscard]] LcmBus& bus() { return *bus_; }
  [[nodiscard]] FrameReader& frames() { return frames_; }

  /// While this channel is silent for longer than silent_s, publishes TIMEOUT twice a second, in the time of
  /// what is heard: the silence of the clock itself.
  void watch_silence(const Channel<vehicle_state_t>& channel, double silent_s);

  /// Handles messages and publishes HEALTH at 1 Hz until SIGTERM or SIGINT. `work`, where given, is called
  /// again and again (it should wait a little itself) and says how the process is. Returns the exit status.
  int run(const std::function<Condition()>& work = {});

 private:
  /// A change of state also goes to the log.
  void set_condition(const Condition& condition);
  void publish_health();
  void publish_timeouts();

  std::string name_;
  Config config_;
  std::unique_ptr<LcmBus> bus_;
  FrameReader frames_;
  Condition condition_;
  int64_t start_utime_ = 0;

  struct Silence {
    std::string channel;
    double silent_s;
    int64_t handled = 0;
    int64_t heard_utime = 0;
    int64_t told_utime = 0;
  };
  std::optional<Silence> silence_;

  int64_t health_utime_ = 0;
  double cpu_s_ = 0;
  std::map<std::string, int64_t> handled_before_;
  std::map<std::string, int64_t> published_before_;
};

/// LCM's address: bus.url of the configuration, over its default.
std::string bus_url(const Config& config);

/// Set by SIGTERM and SIGINT.
bool stop_requested();
void stop_on_signals();

}  // namespace stevedore
