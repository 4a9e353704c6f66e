// The bus over LCM.
#pragma once

#include <memory>
#include <string>

#include "runtime/bus.hpp"

namespace lcm {
class LCM;
struct ReceiveBuffer;
}  // namespace lcm

namespace stevedore {

/// TTL 0: nothing leaves this host (the bus is not authenticated). 2 MB hold a dozen inline frames; the
/// kernel cuts it to net.core.rmem_max without a word (`doctor` looks).
inline constexpr const char* default_lcm_url = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152";

/// What sockets with that LCM address ask the kernel for.
size_t asked_receive_buffer(const std::string& url);

class LcmBus final : public Bus {
 public:
  /// Throws std::runtime_error with what to do when LCM can't be had (no multicast route, mostly).
  explicit LcmBus(const std::string& url);
  ~LcmBus() override;

  /// Waits up to timeout_ms for a message, then handles all that has arrived. Returns at once with one of
  /// them.
  void handle(int timeout_ms);

  /// us, CLOCK_MONOTONIC.
  [[nodiscard]] int64_t now_utime() const override;
  [[nodiscard]] const std::string& url() const { return url_; }
  /// recv_buf_size of the URL, or the kernel's default.
  [[nodiscard]] size_t receive_buffer_bytes() const override { return receive_buffer_bytes_; }

 private:
  void transmit(const std::string& channel, const std::vector<uint8_t>& bytes) override;
  void listen(const std::string& channel) override;
  static void on_message(const ::lcm::ReceiveBuffer* buffer, const std::string& channel, LcmBus* bus);

  const std::string url_;
  const size_t receive_buffer_bytes_;
  std::unique_ptr<::lcm::LCM> lcm_;
};

}  // namespace stevedore
