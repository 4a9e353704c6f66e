#include "runtime/event_log.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <lcm/lcm-cpp.hpp>
#include <stdexcept>
#include <type_traits>

namespace stevedore {
namespace {

constexpr const char* unwritable = "the log can't be written: is the disk full?";

constexpr int64_t header_bytes = 28;
constexpr std::array<uint8_t, 4> sync_word = {0xed, 0xa1, 0xda, 0x01};
constexpr int64_t longest_channel = 63;  // LCM_MAX_CHANNEL_NAME_LENGTH

[[noreturn]] void fail(const std::string& path, int error) {
  throw std::runtime_error(path + ": " + std::strerror(error));
}

template <class Integer>
Integer big_endian(const uint8_t* bytes) {
  std::make_unsigned_t<Integer> value = 0;
  for (size_t i = 0; i < sizeof(Integer); ++i) value = value << 8 | bytes[i];
  return static_cast<Integer>(value);
}

bool printable(const std::string& channel) {
  return std::all_of(channel.begin(), channel.end(), [](char c) { return c > ' ' && c <= '~'; });
}

}  // namespace

std::string describe(const std::vector<DamagedPart>& damage) {
  constexpr size_t told_at_most = 3;
  std::string text;
  for (size_t i = 0; i < std::min(damage.size(), told_at_most); ++i) {
    const auto& [position, bytes, at_end] = damage[i];
    text += fmt::format("damaged at byte {}: {} bytes to {} can't be read. ", position, bytes,
                        at_end ? "the end of the file" : "the next whole event");
  }
  if (damage.size() > told_at_most)
    text += fmt::format("{} more such places. ", damage.size() - told_at_most);
  if (!text.empty()) text.pop_back();
  return text;
}

int64_t LogReader::Place::channel_position() const {
  return position + header_bytes;
}

int64_t LogReader::Place::end() const {
  return channel_position() + channel_bytes + data_bytes;
}

LogReader::LogReader(const std::string& path) : path_(path), file_(open(path.c_str(), O_RDONLY | O_CLOEXEC)) {
  if (file_.get() < 0) fail(path, errno);
  struct stat about {};
  if (fstat(file_.get(), &about) != 0) fail(path, errno);
  if (S_ISDIR(about.st_mode)) fail(path, EISDIR);
  if (!S_ISREG(about.st_mode)) throw std::runtime_error(path + ": is not a file that can be read twice");
  size_ = about.st_size;
}

std::optional<LogEvent> LogReader::next() {
  while (next_position_ < size_) {
    const auto event = event_at(next_position_);
    // where no event follows, a wrong length may have swallowed some
    const auto swallowed =
        event && !ends_well(*event) ? find_event(next_position_ + 1, event->end()) : std::nullopt;
    if (event && !swallowed) {
      event_position_ = event->position;
      next_position_ = event->end();
      return load(*event);
    }
    const auto following = swallowed ? swallowed : find_event(next_position_ + 1, size_);
    const int64_t resumed = following ? following->position : size_;
    damage_.push_back({next_position_, resumed - next_position_, !following});
    next_position_ = resumed;
  }
  return std::nullopt;
}

std::optional<LogReader::Place> LogReader::event_at(int64_t position) const {
  std::array<uint8_t, header_bytes> header{};
  if (size_ - position < header_bytes) return std::nullopt;
  read(position, header.data(), header_bytes);
  if (!std::equal(sync_word.begin(), sync_word.end(), header.begin())) return std::nullopt;
  const Place event{position, big_endian<int64_t>(&header[12]), big_endian<int32_t>(&header[20]),
                    big_endian<int32_t>(&header[24])};
  if (event.channel_bytes < 1 || event.channel_bytes > longest_channel || event.data_bytes < 0 ||
      event.end() > size_)
    return std::nullopt;
  std::string channel(static_cast<size_t>(event.channel_bytes), ' ');
  read(event.channel_position(), channel.data(), event.channel_bytes);
  if (!printable(channel)) return std::nullopt;
  return event;
}

std::optional<LogReader::Place> LogReader::find_event(int64_t begin, int64_t end) const {
  constexpr int64_t chunk_bytes = 1 << 16, overlap = sync_word.size() - 1;
  std::vector<uint8_t> chunk(chunk_bytes);
  for (int64_t start = begin; start < end; start += chunk_bytes - overlap) {
    const auto count = std::min(chunk_bytes, size_ - start);
    read(start, chunk.data(), count);
    const auto chunk_end = chunk.begin() + count;
    for (auto found = chunk.begin();; ++found) {
      found = std::search(found, chunk_end, sync_word.begin(), sync_word.end());
      const int64_t position = start + (found - chunk.begin());
      if (found == chunk_end || position >= end) break;
      if (const auto event = event_at(position)) return event;
    }
  }
  return std::nullopt;
}

bool LogReader::ends_well(const Place& event) const {
  if (event.end() == size_) return true;
  std::array<uint8_t, sync_word.size()> next_word{};
  if (size_ - event.end() < static_cast<int64_t>(next_word.size())) return false;
  read(event.end(), next_word.data(), next_word.size());
  return next_word == sync_word;
}

LogEvent LogReader::load(const Place& place) const {
  LogEvent event;
  event.utime = place.utime;
  event.channel.resize(static_cast<size_t>(place.channel_bytes));
  event.bytes.resize(static_cast<size_t>(place.data_bytes));
  read(place.channel_position(), event.channel.data(), place.channel_bytes);
  read(place.channel_position() + place.channel_bytes, event.bytes.data(), place.data_bytes);
  return event;
}

void LogReader::read(int64_t position, void* bytes, int64_t count) const {
  for (int64_t done = 0; done < count;) {
    const ssize_t n = pread(file_.get(), static_cast<uint8_t*>(bytes) + done,
                            static_cast<size_t>(count - done), position + done);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) fail(fmt::format("{}: at byte {}", path_, position + done), errno);
    if (n == 0) throw std::runtime_error(path_ + ": became shorter while it was read");
    done += n;
  }
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
  if (!file_->good()) fail(path + ": can't be written", errno);
}

LogWriter::~LogWriter() = default;

void LogWriter::write(const LogEvent& event) {
  lcm::LogEvent out{};
  out.timestamp = event.utime;
  out.channel = event.channel;
  out.datalen = static_cast<int32_t>(event.bytes.size());
  std::vector<uint8_t> bytes = event.bytes;  // the library wants it writable
  out.data = bytes.data();
  if (file_->writeEvent(&out) != 0) throw std::runtime_error(unwritable);
}

void LogWriter::flush() {
  if (std::fflush(file_->getFilePtr()) != 0) throw std::runtime_error(unwritable);
}

}  // namespace stevedore
