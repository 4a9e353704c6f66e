// LCM event logs: what lcm-logger and `record` write and lcm-logplayer and `replay` read.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "lcmtypes/channels.hpp"
#include "lcmtypes/validate.hpp"

namespace lcm {
class LogFile;
}

namespace stevedore {

struct LogEvent {
  int64_t utime = 0;  ///< us, the logger's clock (UTC for lcm-logger and record)
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

class LogReader {
 public:
  /// Throws std::runtime_error if the file can't be read.
  explicit LogReader(const std::string& path);
  ~LogReader();
  LogReader(const LogReader&) = delete;
  LogReader& operator=(const LogReader&) = delete;

  /// Nothing at the end, and at a torn tail (a logger that was killed).
  std::optional<LogEvent> next();
  /// Where the next event starts, to come back to with seek.
  [[nodiscard]] int64_t position() const;
  void seek(int64_t position);

 private:
  std::unique_ptr<lcm::LogFile> file_;
};

class LogWriter {
 public:
  /// Throws std::runtime_error if the file can't be written; what was there is replaced.
  explicit LogWriter(const std::string& path);
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  /// Throws std::runtime_error when the disk is full.
  void write(const LogEvent& event);
  void flush();

 private:
  std::unique_ptr<lcm::LogFile> file_;
};

}  // namespace stevedore
