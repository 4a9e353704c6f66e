#include "runtime/journal_file.hpp"

#include <fcntl.h>

#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "runtime/event_log.hpp"

namespace stevedore {
namespace {

void sync(const std::string& path) {
  const FileDescriptor file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  if (file.get() < 0 || fsync(file.get()) != 0)
    throw std::runtime_error("can't bring the journal to the disk: " +
                             std::error_code(errno, std::generic_category()).message() + ": " + path);
}

}  // namespace

std::optional<mission_journal_t> JournalFile::newest() const {
  if (!std::filesystem::exists(path_)) return std::nullopt;
  LogReader log(path_);
  std::optional<mission_journal_t> line;
  while (const auto event = log.next())
    if (const auto decoded = decode(*event, channels::mission_journal)) line = decoded;
  return line;
}

void JournalFile::keep(const mission_journal_t& line) const {
  const std::string next = path_ + ".next";
  {
    LogWriter log(next);
    log.write({line.header.utime, channels::mission_journal.name, encode(line)});
    log.flush();
  }
  sync(next);
  std::filesystem::rename(next, path_);
  const std::string folder = std::filesystem::path(path_).parent_path().string();
  sync(folder.empty() ? "." : folder);
}

}  // namespace stevedore
