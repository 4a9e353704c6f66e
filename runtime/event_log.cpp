#include "runtime/event_log.hpp"

#include <cstdio>
#include <lcm/lcm-cpp.hpp>
#include <stdexcept>

namespace stevedore {

LogReader::LogReader(const std::string& path) : file_(std::make_unique<lcm::LogFile>(path, "r")) {
  if (!file_->good()) throw std::runtime_error(path + ": can't be read");
}

LogReader::~LogReader() = default;

std::optional<LogEvent> LogReader::next() {
  const lcm::LogEvent* event = file_->readNextEvent();
  if (!event) return std::nullopt;
  const auto* data = static_cast<const uint8_t*>(event->data);
  return LogEvent{event->timestamp, event->channel, {data, data + event->datalen}};
}

int64_t LogReader::position() const {
  return std::ftell(file_->getFilePtr());
}

void LogReader::seek(int64_t position) {
  std::fseek(file_->getFilePtr(), position, SEEK_SET);
}

std::optional<header_t> decode_header(const std::vector<uint8_t>& bytes) {
  constexpr int hash_bytes = 8;  // every message starts with its type's fingerprint
  header_t header{};
  try {
    if (header._decodeNoHash(bytes.data(), hash_bytes, static_cast<int>(bytes.size()) - hash_bytes) < 0)
      return std::nullopt;
  } catch (const std::exception&) {
    return std::nullopt;
  }
  return header;
}

LogWriter::LogWriter(const std::string& path) : file_(std::make_unique<lcm::LogFile>(path, "w")) {
  if (!file_->good()) throw std::runtime_error(path + ": can't be written");
}

LogWriter::~LogWriter() = default;

void LogWriter::write(const LogEvent& event) {
  lcm::LogEvent out{};
  out.timestamp = event.utime;
  out.channel = event.channel;
  out.datalen = static_cast<int32_t>(event.bytes.size());
  std::vector<uint8_t> bytes = event.bytes;  // the library wants it writable
  out.data = bytes.data();
  if (file_->writeEvent(&out) != 0) throw std::runtime_error("the log can't be written: is the disk full?");
}

void LogWriter::flush() {
  std::fflush(file_->getFilePtr());
}

}  // namespace stevedore
