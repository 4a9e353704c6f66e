#include "runtime/lcm_bus.hpp"

#include <cstdlib>
#include <lcm/lcm-cpp.hpp>
#include <random>

#include "runtime/frame_codec.hpp"
#include "runtime/time.hpp"

namespace stevedore {
namespace {

/// One a start: two publishers of a channel, or one that came back, can be told apart.
int64_t draw_run_id() {
  std::random_device device;
  return static_cast<int64_t>((uint64_t{device()} << 32 | device()) >> 1);
}

/// LCM drops from the end of a full queue without a word. Ten seconds of the fastest channel: what is dropped
/// later shows as a gap.
constexpr int queue_capacity = 1024;

/// Longest run of messages handled before the caller gets a turn (stop signals, HEALTH); draining a socket
/// takes far less.
constexpr int64_t longest_turn_us = 100'000;

}  // namespace

size_t asked_receive_buffer(const std::string& url) {
  const std::string key = "recv_buf_size=";
  const auto at = url.find(key);
  const size_t asked = at == std::string::npos ? 0 : std::strtoul(url.c_str() + at + key.size(), nullptr, 10);
  return asked > 0 ? asked : granted_receive_buffer(0);
}

LcmBus::LcmBus(const std::string& url)
    : Bus(draw_run_id()),
      url_(url),
      receive_buffer_bytes_(asked_receive_buffer(url)),
      lcm_(std::make_unique<::lcm::LCM>(url)) {
  if (!lcm_->good()) {
    throw std::runtime_error(
        "LCM can't open " + url +
        "; is there a multicast route? `ip route add 224.0.0.0/4 dev lo` as root, or start "
        "through launch/netns; `doctor` tells more");
  }
}

LcmBus::~LcmBus() = default;

void LcmBus::handle(int timeout_ms) {
  int timeout = timeout_ms;
  const int64_t until_utime = now_utime() + int64_t{timeout_ms} * 1000 + longest_turn_us;
  while (lcm_->handleTimeout(timeout) > 0 && now_utime() < until_utime) timeout = 0;
  deliver_newest();
}

int64_t LcmBus::now_utime() const {
  return monotonic_utime();
}

void LcmBus::transmit(const std::string& channel, const std::vector<uint8_t>& bytes) {
  lcm_->publish(channel, bytes.data(), static_cast<unsigned int>(bytes.size()));
}

void LcmBus::listen(const std::string& channel) {
  // a plain function: under its sanitizers gcc 12 calls pointers to members with the wrong object
  lcm_->subscribeFunction(channel, &LcmBus::on_message, this)->setQueueCapacity(queue_capacity);
}

void LcmBus::on_message(const ::lcm::ReceiveBuffer* buffer, const std::string& channel, LcmBus* bus) {
  bus->receive(channel, buffer->data, buffer->data_size);
}

}  // namespace stevedore
