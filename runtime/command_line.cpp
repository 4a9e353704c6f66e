#include "runtime/command_line.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

#include "runtime/config.hpp"

namespace stevedore {
namespace {

/// A program started with a standard stream closed would get it for the first file that it opens, and write
/// its table in there. The stream is given to what refuses it, so that it fails as a closed one does.
void hold_standard_streams() {
  constexpr std::array<int, 3> refusing = {O_WRONLY, O_RDONLY, O_RDONLY};
  for (int fd = 0; fd < 3; ++fd) {
    if (fcntl(fd, F_GETFD) < 0) static_cast<void>(open("/dev/null", refusing.at(static_cast<size_t>(fd))));
  }
}

/// Why standard output did not get everything; empty if it did.
std::string output_fault() {
  errno = 0;
  std::cout.flush();
  if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && std::cout.good()) return {};
  const std::string why = errno == 0 ? "a write failed" : std::strerror(errno);
  return "standard output can't be written: " + why;
}

}  // namespace

void parse_command_line(CLI::App& app, int argc, char** argv, const std::string& statuses) {
  app.set_version_flag("--version", version());
  std::string footer = app.get_footer();
  if (!footer.empty()) footer += "\n";
  app.footer(footer + "Exit status: 0, " + statuses +
             ", 2 for a mistake in the command line or configuration.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    throw ProgramEnd{app.exit(error) == 0 ? 0 : exit_usage};
  }
}

int guarded_main(const std::function<int()>& body) {
  hold_standard_streams();
  int status = exit_failed;
  std::string what;
  try {
    status = body();
  } catch (const ProgramEnd& end) {
    status = end.status;
  } catch (const UsageError& error) {
    status = exit_usage;
    what = error.what();
  } catch (const ConfigError& error) {
    status = exit_usage;
    what = std::string("configuration: ") + error.what();
  } catch (const std::exception& error) {
    what = error.what();
  }
  if (const std::string fault = output_fault(); !fault.empty()) {  // the cause of the exception too, if any
    status = std::max(status, exit_failed);
    what = fault;
  }
  if (!what.empty()) std::cerr << what << '\n';
  return status;
}

}  // namespace stevedore
