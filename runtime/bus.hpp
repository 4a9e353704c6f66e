// How a stage hears and speaks: typed channels, whatever carries them (LCM live, memory in a replay).
// Rules kept here, once, for every process: a message is decoded, checked and counted before a handler sees
// it; what is published is numbered, stamped, and says which inputs had been read (see lcmtypes/trace_t.lcm).
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "lcmtypes/channels.hpp"
#include "lcmtypes/validate.hpp"

namespace stevedore {

/// every: queued, never thinned. newest: what has been superseded is skipped (FRAME at a live detector only).
enum class Delivery { every, newest };

/// Why an input was of no use though its message was good: counted as lost on its channel.
enum class Loss { malformed, stale, overwritten };

struct InputCounters {
  int64_t received = 0;
  int64_t handled = 0;
  int64_t lost_gap = 0;
  int64_t lost_malformed = 0;
  int64_t lost_stale = 0;
  int64_t lost_overwritten = 0;
  int64_t skipped = 0;
};

/// What has been heard of one run of a publisher.
struct HeardRun {
  int64_t run_id = 0;
  int64_t first_seq = 0;
  int64_t newest_seq = 0;
};

class Bus {
 public:
  explicit Bus(int64_t run_id) : run_id_(run_id) {}
  virtual ~Bus() = default;
  /// What each receiver asks the kernel to hold for it until it is read; there may be no kernel in between.
  [[nodiscard]] virtual size_t receive_buffer_bytes() const { return std::numeric_limits<size_t>::max(); }
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  /// One subscription a channel. Handlers run one at a time, in the thread that drives the bus.
  template <class M>
  void subscribe(const Channel<M>& channel, std::function<void(const M&)> handler,
                 Delivery delivery = Delivery::every) {
    add_input(channel.name, std::make_unique<TypedInput<M>>(std::move(handler), delivery));
  }

  /// Numbers, stamps and sends a message; header.utime and header.frame_seq are the caller's.
  template <class M>
  void publish(const Channel<M>& channel, M message) {
    stamp(channel.name, message.header);
    std::vector<uint8_t> bytes(static_cast<size_t>(message.getEncodedSize()));
    if (message.encode(bytes.data(), 0, static_cast<int>(bytes.size())) != static_cast<int>(bytes.size())) {
      throw std::logic_error(std::string("a message for ") + channel.name + " disagrees with its own sizes");
    }
    transmit(channel.name, bytes);
  }

  /// The input being handled could not be used after all, e.g. its frame was overwritten in the ring.
  void count_loss(const std::string& channel, Loss loss);

  [[nodiscard]] const InputCounters& counters(const std::string& channel) const;
  [[nodiscard]] std::vector<std::string> inputs() const;
  [[nodiscard]] const std::map<std::string, int64_t>& published() const { return next_seq_; }
  /// Ages (arrival minus header.utime, us) since the last call, for HEALTH.
  std::vector<int64_t> take_ages_us(const std::string& channel);
  [[nodiscard]] int64_t run_id() const { return run_id_; }
  /// Now, in the time of what is heard: header.utime of the last message of somebody else, and what has
  /// passed since. A log that is played lives in its own time.
  [[nodiscard]] int64_t stream_utime() const;
  /// The next message on a channel gets this number; a replay of a part of a log starts where the log does.
  void set_next_seq(const std::string& channel, int64_t seq) { next_seq_[channel] = seq; }

 protected:
  /// us, CLOCK_MONOTONIC live; the log's time in a replay.
  [[nodiscard]] virtual int64_t now_utime() const = 0;
  virtual void transmit(const std::string& channel, const std::vector<uint8_t>& bytes) = 0;
  /// Told of each new input, so that a carrier can subscribe underneath.
  virtual void listen(const std::string& channel) = 0;

  /// To be called by the carrier for every message on a subscribed channel.
  void receive(const std::string& channel, const void* data, size_t size);
  /// To be called by the carrier when its socket is drained: hands out what waits as the newest.
  void deliver_newest();

 private:
  class Input {
   public:
    explicit Input(Delivery delivery) : delivery_(delivery) {}
    virtual ~Input() = default;
    Input(const Input&) = delete;
    Input& operator=(const Input&) = delete;
    /// Nothing: undecodable or invalid. On success the message waits inside.
    virtual std::optional<header_t> decode(const void* data, int size) = 0;
    /// Of the type: what every message of it starts with.
    [[nodiscard]] virtual int64_t fingerprint() const = 0;
    virtual void handle() = 0;

    const Delivery delivery_;
    InputCounters counters_;
    std::vector<HeardRun> arrived_;  ///< a few publishers, the one heard last stands last
    std::vector<HeardRun> handled_;
    std::vector<int64_t> ages_us_;
    std::optional<header_t> waiting_;  ///< header of the message inside, not yet handed out
    int64_t waiting_since_utime_ = 0;
  };

  template <class M>
  class TypedInput final : public Input {
   public:
    TypedInput(std::function<void(const M&)> handler, Delivery delivery)
        : Input(delivery), handler_(std::move(handler)) {}
    std::optional<header_t> decode(const void* data, int size) override {
      auto message = decode_checked<M>(data, size);
      if (!message) return std::nullopt;
      message_ = *std::move(message);
      return message_.header;
    }
    [[nodiscard]] int64_t fingerprint() const override { return M::getHash(); }
    void handle() override {
      const M message = std::move(message_);  // a handler may make the bus receive more
      handler_(message);
    }

   private:
    std::function<void(const M&)> handler_;
    M message_{};
  };

  /// A refused message is one loss: where its header can be read it has arrived, and its number is not missed
  /// again as a gap. A number that does not follow on its publisher's last is not believed, and a message
  /// without a readable header has none: should it have been one of a sequence, its gap is counted too.
  static void count_once(Input& input, const std::optional<header_t>& refused);
  void add_input(const std::string& channel, std::unique_ptr<Input> input);
  void hand_out(const std::string& channel, Input& input);
  void stamp(const std::string& channel, header_t& header);

  const int64_t run_id_;
  std::map<std::string, std::unique_ptr<Input>> inputs_;
  std::map<std::string, int64_t> next_seq_;
  std::string cause_;                     ///< channel being handled
  std::optional<int64_t> stream_lag_us_;  ///< arrival minus header.utime of the last message of somebody else
  int64_t cause_receive_utime_ = 0;
};

}  // namespace stevedore
