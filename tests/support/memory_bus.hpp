// A bus without a carrier: the test hands messages in and looks at what comes out.
#pragma once

#include <catch2/catch.hpp>
#include <string>
#include <utility>
#include <vector>

#include "runtime/bus.hpp"
#include "runtime/event_log.hpp"

namespace stevedore {

class MemoryBus final : public Bus {
 public:
  explicit MemoryBus(int64_t run_id = 7) : Bus(run_id) {}
  using Bus::deliver_newest;

  void deliver(const std::string& channel, const std::vector<uint8_t>& bytes) {
    receive(channel, bytes.data(), bytes.size());
  }
  template <class M>
  void deliver(const Channel<M>& channel, const M& message) {
    deliver(channel.name, encode(message));
  }
  /// What was published on a channel so far; each passes fault_of.
  template <class M>
  std::vector<M> published_on(const Channel<M>& channel) const {
    std::vector<M> messages;
    for (const auto& [name, bytes] : sent) {
      if (name != channel.name) continue;
      const auto message = decode(LogEvent{0, name, bytes}, channel);
      REQUIRE(message);
      messages.push_back(*message);
    }
    return messages;
  }

  int64_t now = 1000;
  std::vector<std::pair<std::string, std::vector<uint8_t>>> sent;
  std::vector<std::string> listened;

 private:
  [[nodiscard]] int64_t now_utime() const override { return now; }
  void transmit(const std::string& channel, const std::vector<uint8_t>& bytes) override {
    sent.emplace_back(channel, bytes);
  }
  void listen(const std::string& channel) override { listened.push_back(channel); }
};

}  // namespace stevedore
