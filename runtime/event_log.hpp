// LCM event logs: what lcm-logger and `record` write and lcm-logplayer and `replay` read.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/channels.hpp"
#include "lcmtypes/validate.hpp"
#include "runtime/file_descriptor.hpp"

namespace lcm {
class LogFile;
}

namespace stevedore {

struct LogEvent {
  int64_t utime = 0;  ///< us, the logger's clock (UTC for lcm-logger; SteadyUtc for record)
  std::string channel;
  std::vector<uint8_t> bytes;
};

/// The header of any message, without looking at the rest. Nothing if the bytes are too few.
std::optional<header_t> decode_header(const std::vector<uint8_t>& bytes);

/// A message as bytes.
template <class M>
std::vector<uint8_t> encode(const M& message) {
  std::vector<uint8_t> bytes(static_cast<size_t>(message.getEncodedSize()));
  message.encode(bytes.data(), 0, static_cast<int>(bytes.size()));
  return bytes;
}

/// The message of an event, if it is on this channel and passes fault_of.
template <class M>
std::optional<M> decode(const LogEvent& event, const Channel<M>& channel) {
  if (event.channel != channel.name) return std::nullopt;
  return decode_checked<M>(event.bytes.data(), static_cast<int>(event.bytes.size()));
}

/// A stretch of a log that no event could be read from.
struct DamagedPart {
  int64_t position = 0;  ///< of its first byte in the file
  int64_t bytes = 0;
  bool at_end = false;  ///< no event follows
};

/// One sentence a damaged part, the first few; empty for a log that is whole.
std::string describe(const std::vector<DamagedPart>& damage);

/// Reads a log from beginning to end. Every length is held against the file before it is believed; behind a
/// damaged event reading goes on at the next sync word with a sound header, and what was skipped is told.
///
/// An event (LCM's log format, all big-endian): sync word 0xEDA1DA01, event number (64 bits), time in us
/// (64), lengths of channel and data (32 each), channel, data.
class LogReader {
 public:
  /// Throws std::runtime_error that says why the file can't be read.
  explicit LogReader(const std::string& path);
  LogReader(const LogReader&) = delete;
  LogReader& operator=(const LogReader&) = delete;

  /// Nothing at the end. Throws std::runtime_error where the disk gives an error.
  std::optional<LogEvent> next();
  /// Where the event that next() gave last starts, to come back to with seek.
  [[nodiscard]] int64_t position() const { return event_position_; }
  void seek(int64_t position) { next_position_ = position; }
  /// What next() has skipped so far, in the order of reading.
  [[nodiscard]] const std::vector<DamagedPart>& damage() const { return damage_; }

 private:
  struct Place {
    int64_t position, utime, channel_bytes, data_bytes;
    [[nodiscard]] int64_t channel_position() const;
    [[nodiscard]] int64_t end() const;
  };

  /// The event at this position, if its header is sound and it ends within the file.
  [[nodiscard]] std::optional<Place> event_at(int64_t position) const;
  /// The first event that starts within [begin, end).
  [[nodiscard]] std::optional<Place> find_event(int64_t begin, int64_t end) const;
  /// Whether an event is followed by another one, or by nothing.
  [[nodiscard]] bool ends_well(const Place& event) const;
  [[nodiscard]] LogEvent load(const Place& event) const;
  /// These bytes of the file.
  void read(int64_t position, void* bytes, int64_t count) const;

  std::string path_;
  FileDescriptor file_;
  int64_t size_ = 0;
  int64_t event_position_ = 0;
  int64_t next_position_ = 0;
  std::vector<DamagedPart> damage_;
};

class LogWriter {
 public:
  /// Throws std::runtime_error if the file can't be written; what was there is replaced.
  explicit LogWriter(const std::string& path);
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  /// They throw std::runtime_error when the disk is full. Without a flush at the end nobody is told of that.
  void write(const LogEvent& event);
  void flush();

 private:
  std::unique_ptr<lcm::LogFile> file_;
};

}  // namespace stevedore
