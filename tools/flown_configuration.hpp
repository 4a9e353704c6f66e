// The configuration a flight was flown with: a file that is named, or config.yaml that ./run keeps beside the
// log, with the settings of settings.txt over it.
#pragma once

#include <string>
#include <vector>

namespace stevedore {

struct FlownConfiguration {
  std::string file;                   ///< empty: settings have their defaults
  std::vector<std::string> settings;  ///< section.key=value, over the file
};

/// file: the one that was named; empty: what is beside the log, and stderr says what was found there.
/// settings: over both.
FlownConfiguration flown_configuration(const std::string& log, const std::string& file,
                                       const std::vector<std::string>& settings);

}  // namespace stevedore
