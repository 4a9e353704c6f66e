#include "tools/kept_configuration.hpp"

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

std::optional<KeptConfiguration> configuration_beside(const std::string& log) {
  const fs::path folder = fs::path(log).parent_path();
  if (!fs::is_regular_file(folder / "config.yaml")) return std::nullopt;
  return KeptConfiguration{(folder / "config.yaml").string(), settings_of(folder / "settings.txt")};
}

}  // namespace stevedore
