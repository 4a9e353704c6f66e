// What a mission goes on from after it was killed.
#include "runtime/journal_file.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "lcmtypes/validate.hpp"
#include "tests/support/program.hpp"

using namespace stevedore;

namespace {

mission_journal_t line_of(int16_t attempts) {
  mission_journal_t line{};
  line.header.utime = 1000 + attempts;
  line.header.frame_seq = -1;
  line.attempts = attempts;
  return line;
}

}  // namespace

TEST_CASE("the newest line of a journal comes back, and nothing else is left in the folder") {
  const Folder folder;
  const JournalFile journal(folder.file("mission.journal"));
  CHECK_FALSE(journal.newest());
  for (int16_t attempts = 1; attempts <= 3; ++attempts) journal.keep(line_of(attempts));
  const auto newest = JournalFile(folder.file("mission.journal")).newest();
  REQUIRE(newest);
  CHECK(newest->attempts == 3);
  CHECK(newest->header.utime == 1003);
  CHECK_FALSE(std::filesystem::exists(folder.file("mission.journal.next")));
}

TEST_CASE("a line that was being written when the process was killed leaves the one before it") {
  const Folder folder;
  const JournalFile journal(folder.file("mission.journal"));
  journal.keep(line_of(7));
  std::ofstream(folder.file("mission.journal.next")) << "half a li";
  REQUIRE(journal.newest());
  CHECK(journal.newest()->attempts == 7);
}

TEST_CASE("a journal that says what can't be is none") {
  mission_journal_t line = line_of(1);
  CHECK_FALSE(fault_of(line));
  SECTION("a hook that hangs nowhere") {
    line.hook_off_m[1] = std::nan("");
  }
  SECTION("lessons that were never had") {
    line.hook_lessons = -2;
  }
  SECTION("circles that are not there") {
    line.taken_count = 1;
  }
  CHECK(fault_of(line));
}

TEST_CASE("a journal that is no journal has no line, and one that can't be written says so") {
  const Folder folder;
  std::ofstream(folder.file("mission.journal")) << "something else";
  CHECK_FALSE(JournalFile(folder.file("mission.journal")).newest());
  CHECK_THROWS_AS(JournalFile(folder.file("no/such/folder/journal")).keep(line_of(1)), std::runtime_error);
}
