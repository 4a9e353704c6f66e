// The mission decides the same whether TRUTH is on the bus or not.
#include <unistd.h>

#include <catch2/catch.hpp>
#include <filesystem>
#include <string>
#include <vector>

#include "tests/support/sim_flight.hpp"
#include "tools/replay_core.hpp"

using namespace stevedore;

namespace {

/// MISSION payloads of the line over a flight's log, in lock step.
std::vector<std::vector<uint8_t>> missions_of(const SimFlight::Sent& flight) {
  const auto path = std::filesystem::temp_directory_path() / ("replay-truth-" + std::to_string(getpid()));
  {
    LogWriter writer(path.string());
    for (const auto& [channel, bytes] : flight) writer.write({0, channel, bytes});
  }
  ReplayOptions options;
  options.config = Config::load(std::string(STEVEDORE_SOURCE_DIR) + "/config/world.yaml");
  std::vector<std::vector<uint8_t>> missions;
  replay(path.string(), options, [&missions](const LogEvent& event) {
    if (event.channel == channels::mission.name)
      missions.push_back(payload_of(event.channel, event.bytes).value());
  });
  std::filesystem::remove(path);
  return missions;
}

}  // namespace

TEST_CASE("a flight's MISSION payloads with TRUTH and without it") {
  SimSettings settings;
  settings.rate_hz = 2;
  settings.frames.transport = "jpeg";
  settings.frames.jpeg_quality = 75;  // under the limit of inline messages
  SimFlight with(settings);
  settings.truth = false;
  SimFlight without(settings);
  with.fly(8);
  without.fly(8);
  CHECK(with.sim_bus.published_on(channels::truth).size() > 12);
  CHECK(without.sim_bus.published_on(channels::truth).empty());
  const auto missions = missions_of(with.log);
  CHECK(missions.size() > 12);
  CHECK(missions == missions_of(without.log));
}
