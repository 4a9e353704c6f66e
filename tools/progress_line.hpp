// One line that says how far long work is.
#pragma once

#include <string>

namespace stevedore {

/// On standard output of a terminal the line is written over itself; elsewhere each is a line of its own.
class ProgressLine {
 public:
  ProgressLine();
  ~ProgressLine() { end(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  [[nodiscard]] bool on_terminal() const { return on_terminal_; }
  void show(const std::string& text);
  /// What is written next starts a line of its own.
  void end();

 private:
  bool on_terminal_;
  bool open_ = false;
};

}  // namespace stevedore
