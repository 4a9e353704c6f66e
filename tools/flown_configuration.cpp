#include "tools/flown_configuration.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>

namespace stevedore {
namespace {

namespace fs = std::filesystem;

/// The lines of settings.txt: section.key=value, with or without --set before it.
std::vector<std::string> settings_of(const fs::path& path) {
  std::vector<std::string> settings;
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("--set ")) line.erase(0, 6);
    if (!line.empty()) settings.push_back(line);
  }
  return settings;
}

}  // namespace

FlownConfiguration flown_configuration(const std::string& log, const std::string& file,
                                       const std::vector<std::string>& settings) {
  if (!file.empty()) return {file, settings};
  const fs::path folder = fs::path(log).parent_path(), beside = folder / "config.yaml";
  if (!fs::is_regular_file(beside)) {
    fmt::print(stderr, "No --config, and no config.yaml beside the log: settings have their defaults.\n");
    return {"", settings};
  }
  FlownConfiguration flown{beside.string(), settings_of(folder / "settings.txt")};
  fmt::print(stderr, "With {} and {} settings of settings.txt, both kept beside the log.\n", flown.file,
             flown.settings.size());
  flown.settings.insert(flown.settings.end(), settings.begin(), settings.end());
  return flown;
}

}  // namespace stevedore
