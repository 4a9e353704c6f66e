// What every program's main is built on: its command line, its exit status, and no output lost in silence.
#pragma once

#include <functional>
#include <stdexcept>
#include <string>

namespace CLI {
class App;
}

namespace stevedore {

constexpr int exit_failed = 1, exit_usage = 2, exit_stopped = 130;  ///< the last: by SIGINT, as shells say

/// Thrown to end the program through guarded_main.
struct ProgramEnd {
  int status = 0;
};

/// What was asked for makes no sense; exit status 2.
struct UsageError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Parses the command line; adds --version, and below --help what the exit statuses mean. `statuses` says
/// what there is between 0 and 2, e.g. "1 if an image could not be read". --help and --version end the
/// program with 0, mistakes with 2.
void parse_command_line(CLI::App& app, int argc, char** argv, const std::string& statuses = "1 on failure");

/// Runs main's body; an exception becomes one line on standard error and exit status 1; UsageError and
/// ConfigError are 2. What could not be written to standard output (a full disk, a closed file) is a failure
/// too.
int guarded_main(const std::function<int()>& body);

/// Which build this is, for --version and a replay's run_id: the release and the commit; where files differ
/// from the commit, or there is none, a hash of the sources.
const char* version();

}  // namespace stevedore
