// The configuration that ./run keeps beside a log: config.yaml, with the settings of settings.txt over it.
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace stevedore {

struct KeptConfiguration {
  std::string file;
  std::vector<std::string> settings;  ///< section.key=value, over the file
};

/// Nothing where no config.yaml is beside the log.
std::optional<KeptConfiguration> configuration_beside(const std::string& log);

}  // namespace stevedore
