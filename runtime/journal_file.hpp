// The newest line of a mission's journal, in a file: what a mission_proc that comes back goes on from.
#pragma once

#include <stevedore/mission_journal_t.hpp>

#include <optional>
#include <string>

namespace stevedore {

/// An LCM log of one event, so that every tool for logs reads it. A line takes the place of the one before it
/// as a whole: after a kill or a power cut at any time there is the one or the other.
class JournalFile {
 public:
  explicit JournalFile(std::string path) : path_(std::move(path)) {}

  /// Nothing where there is no file, or none that holds a line.
  [[nodiscard]] std::optional<mission_journal_t> newest() const;
  /// On the disk when it returns. Throws std::runtime_error if it can't be written.
  void keep(const mission_journal_t& line) const;

 private:
  std::string path_;
};

}  // namespace stevedore
