// A log that was damaged on its way is read as far as it can be, and never taken for a whole one.
#include "runtime/event_log.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "tests/support/program.hpp"

using namespace stevedore;

namespace {

constexpr int64_t events = 10, data_bytes = 100;
const std::string channel = "FRAME";
constexpr int64_t event_bytes = 28 + 5 + data_bytes;
constexpr int64_t channel_length_at = 20, data_length_at = 24, data_at = 33;

/// Ten events; the first byte of each one's data is its number.
std::string write_log(const Folder& folder) {
  LogWriter writer(folder.file("log.lcm"));
  for (uint8_t i = 0; i < events; ++i) {
    LogEvent event{i, channel, std::vector<uint8_t>(data_bytes, 0xaa)};
    event.bytes[0] = i;
    writer.write(event);
  }
  writer.flush();
  return folder.file("log.lcm");
}

void overwrite(const std::string& path, int64_t position, const std::vector<uint8_t>& bytes) {
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(position);
  for (const uint8_t byte : bytes) file.put(static_cast<char>(byte));
  REQUIRE(file.flush());
}

struct Read {
  std::vector<int> numbers;
  std::vector<DamagedPart> damage;
};

Read read(const std::string& path) {
  LogReader reader(path);
  Read result;
  while (const auto event = reader.next())
    result.numbers.push_back(event->bytes.empty() ? -1 : event->bytes[0]);
  result.damage = reader.damage();
  return result;
}

}  // namespace

TEST_CASE("a whole log has no damage, and its events can be come back to") {
  const Folder folder;
  const auto log = write_log(folder);
  const Read whole = read(log);
  CHECK(whole.numbers == std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  CHECK(whole.damage.empty());
  CHECK(describe(whole.damage).empty());
  LogReader reader(log);
  reader.next();
  reader.next();
  CHECK(reader.position() == event_bytes);
  reader.next();
  reader.seek(event_bytes);
  const auto second = reader.next();
  REQUIRE(second);
  CHECK(second->utime == 1);
  CHECK(second->channel == channel);
  CHECK(second->bytes.size() == data_bytes);
}

TEST_CASE("a damaged header costs its event only, and is told with its place") {
  const Folder folder;
  const int64_t third = 2 * event_bytes;
  const std::vector<std::pair<int64_t, std::vector<uint8_t>>> damages = {
      {0, {0}},                                    // sync word
      {channel_length_at, {0, 0, 0, 0}},           // no channel
      {channel_length_at, {0xff, 0, 0, 0}},        // negative
      {channel_length_at, {0, 0, 1, 0}},           // longer than LCM's
      {data_length_at, {0x7f, 0xff, 0xff, 0xff}},  // beyond the file
      {data_length_at, {0xff, 0xff, 0xff, 0xff}},  // negative
      {data_length_at, {0, 0, 1, 0x77}},           // into the events behind
      {data_length_at + 4, {0}},                   // a channel of no text
  };
  for (const auto& [at, bytes] : damages) {
    const auto log = write_log(folder);
    overwrite(log, third + at, bytes);
    const Read damaged = read(log);
    INFO("byte " << at << ", " << damaged.damage.size() << " parts");
    CHECK(damaged.numbers == std::vector<int>{0, 1, 3, 4, 5, 6, 7, 8, 9});
    REQUIRE(damaged.damage.size() == 1);
    CHECK(damaged.damage[0].position == third);
    CHECK(damaged.damage[0].bytes == event_bytes);
    CHECK_FALSE(damaged.damage[0].at_end);
    CHECK(describe(damaged.damage).find("byte 266") != std::string::npos);
  }
}

TEST_CASE("a length that is too short: the rest of the event is damage") {
  const Folder folder;
  const auto log = write_log(folder);
  overwrite(log, 2 * event_bytes + data_length_at, {0, 0, 0, 40});
  const Read damaged = read(log);
  CHECK(damaged.numbers ==
        std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9});  // whoever decodes it will refuse it
  REQUIRE(damaged.damage.size() == 1);
  CHECK(damaged.damage[0].position == 2 * event_bytes + data_at + 40);
  CHECK(damaged.damage[0].bytes == data_bytes - 40);
}

TEST_CASE("two damaged places with a whole event between them") {
  const Folder folder;
  const auto log = write_log(folder);
  overwrite(log, 2 * event_bytes, {0});
  overwrite(log, 4 * event_bytes, {0});
  const Read damaged = read(log);
  CHECK(damaged.numbers == std::vector<int>{0, 1, 3, 5, 6, 7, 8, 9});
  CHECK(damaged.damage.size() == 2);
}

TEST_CASE("a log that was cut off ends with damage") {
  const Folder folder;
  for (const int64_t kept : {int64_t{1}, int64_t{27}, int64_t{40}, event_bytes - 1}) {
    const auto log = write_log(folder);
    std::filesystem::resize_file(log, static_cast<uintmax_t>(9 * event_bytes + kept));
    const Read cut = read(log);
    CHECK(cut.numbers.size() == 9);
    REQUIRE(cut.damage.size() == 1);
    CHECK(cut.damage[0].position == 9 * event_bytes);
    CHECK(cut.damage[0].bytes == kept);
    CHECK(cut.damage[0].at_end);
  }
}

TEST_CASE("a sync word among the pixels of a whole event is none") {
  const Folder folder;
  const auto log = write_log(folder);
  std::vector<uint8_t> forged = {0xed, 0xa1, 0xda, 0x01};
  forged.resize(28);
  forged[23] = forged[27] = 4;  // lengths
  forged.insert(forged.end(), {'T', 'E', 'X', 'T'});
  overwrite(log, 2 * event_bytes + data_at + 1, forged);
  const Read whole = read(log);
  CHECK(whole.numbers == std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9});
  CHECK(whole.damage.empty());
}

TEST_CASE("random bytes hold no event, no file and a folder are errors that say which") {
  const Folder folder;
  std::mt19937 random(1);
  std::ofstream file(folder.file("random"), std::ios::binary);
  for (int i = 0; i < 200'000; ++i) file.put(static_cast<char>(random()));
  file.close();
  const Read nothing = read(folder.file("random"));
  CHECK(nothing.numbers.empty());
  REQUIRE(nothing.damage.size() == 1);
  CHECK(nothing.damage[0].bytes == 200'000);
  CHECK_THROWS_WITH(LogReader(folder.file("missing")), Catch::Contains("No such file"));
  CHECK_THROWS_WITH(LogReader(folder.file("")), Catch::Contains("directory"));
}

TEST_CASE("bytes changed anywhere never bring the reader down") {
  const Folder folder;
  std::mt19937 random(2);
  for (int i = 0; i < 300; ++i) {
    const auto log = write_log(folder);
    for (int k = 0; k < 5; ++k) {
      overwrite(log, static_cast<int64_t>(random() % (events * event_bytes)),
                {static_cast<uint8_t>(random())});
    }
    CHECK(read(log).numbers.size() >= 4);
  }
}

TEST_CASE("a log on a full disk is an error at the latest when it is flushed") {
  LogWriter writer("/dev/full");
  writer.write({0, channel, {1, 2, 3}});
  CHECK_THROWS_WITH(writer.flush(), Catch::Contains("disk full"));
}
