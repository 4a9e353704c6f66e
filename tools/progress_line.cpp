#include "tools/progress_line.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>

namespace stevedore {
namespace {

/// A line that wraps can't be written over.
size_t terminal_columns() {
  constexpr size_t usual = 80;
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return usual;
  return size.ws_col;
}

}  // namespace

ProgressLine::ProgressLine() : on_terminal_(isatty(STDOUT_FILENO) == 1) {}

void ProgressLine::show(const std::string& text) {
  constexpr const char* erase_to_end = "\033[K";
  if (on_terminal_) {
    fmt::print("\r{}{}", text.substr(0, terminal_columns() - 1), erase_to_end);
    open_ = true;
  } else {
    fmt::print("{}\n", text);
  }
  std::fflush(stdout);
}

void ProgressLine::end() {
  if (open_) fmt::print("\n");
  open_ = false;
  std::fflush(stdout);
}

}  // namespace stevedore
