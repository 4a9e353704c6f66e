// Every program's command line: help, version, exit statuses, and no output lost in silence.
#include <fcntl.h>

#include <catch2/catch.hpp>

#include "runtime/command_line.hpp"
#include "tests/support/program.hpp"

using namespace stevedore;

namespace {

const std::vector<std::string> programs = {
    "camera_proc", "detector_proc", "tracker_proc", "pose_proc", "mission_proc", "record",   "replay",
    "report",      "overlay",       "locate",       "doctor",    "settings",     "explain",  "campaign",
    "calibrate",   "sim_proc",      "gimbal_proc",  "watch",     "tell",         "evaluate", "scenes"};
const std::string golden_log = STEVEDORE_SOURCE_DIR "/logs/film.lcm";

}  // namespace

TEST_CASE("--help states the exit statuses, --version the build, a mistake is status 2") {
  for (const std::string& program : programs) {
    INFO(program);
    const auto help = run_program("$BIN/" + program + " --help");
    CHECK(help.status == 0);
    CHECK(help.out.find("Exit status: 0, ") != std::string::npos);
    CHECK(help.err.empty());
    const auto version = run_program("$BIN/" + program + " --version");
    CHECK(version.status == 0);
    CHECK(version.out.find(" (") != std::string::npos);
    const auto mistake = run_program("$BIN/" + program + " --bogus");
    CHECK(mistake.status == 2);
    CHECK(mistake.out.empty());
    CHECK_FALSE(mistake.err.empty());
  }
}

TEST_CASE("scripts have --help too, with no root, no screen, and nothing done") {
  for (const std::string script :
       {"run", "test", "launch/netns", "launch/make-services", "launch/make-systemd-units",
        "launch/multicast-route", "logs/record-golden", "scripts/install-packages", "scripts/lint-format",
        "scripts/lint-tidy", "tools/spy"}) {
    INFO(script);
    const auto help =
        run_program("unset DISPLAY; PATH=/usr/bin:/bin " STEVEDORE_SOURCE_DIR "/" + script + " --help");
    CHECK(help.status == 0);
    CHECK(help.out.find("usage: ") != std::string::npos);
    CHECK(help.err.empty());
  }
}

TEST_CASE("output that can't be written is an error, whatever else went well") {
  const Folder folder;
  std::ofstream(folder.file("a.pgm")) << "P5 4 4 255\n0123456789abcdef";
  const std::vector<std::string> commands = {
      "locate " + folder.file("a.pgm"),
      "locate --help",
      "report " + golden_log,
      "report --json " + golden_log,
      "settings",
      "doctor --channels",
      "overlay " + golden_log + " --every 20 --frames " + folder.file("png"),
      "record --help",
      "replay --version"};
  for (const std::string& command : commands) {
    INFO(command);
    for (const std::string where : {">/dev/full", ">&-"}) {
      const auto run = run_program("$BIN/" + command + " " + where);
      CHECK(run.status == 1);
      CHECK(run.err.find("standard output can't be written") != std::string::npos);
    }
    CHECK(run_program("$BIN/" + command).status == 0);
  }
}

TEST_CASE("a program started with its streams closed opens no file in their place") {
  const pid_t child = fork();
  if (child == 0) {
    for (const int fd : {0, 1, 2}) close(fd);
    _exit(guarded_main([] { return open(golden_log.c_str(), O_RDONLY) > 2 ? 42 : 43; }));
  }
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  REQUIRE(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 42);
}

TEST_CASE("record refuses a folder") {
  const Folder folder;
  const auto run = run_program("$BIN/record --out " + folder.file(""));
  CHECK(run.status == 2);
  CHECK(run.err.find("is a folder") != std::string::npos);
}
