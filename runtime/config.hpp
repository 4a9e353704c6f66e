// Strict YAML configuration: one file a deployment, one section a process. Unknown keys and values out of
// range stop the process with file, line and key.
//
// A settings struct is described once, next to it:
//   template <class Visitor> void describe(FooSettings& s, Visitor& visit) {
//     visit("gate_px", s.gate_px, 1.0, 100.0, "px", "raise: ...");
//     visit("use_hull", s.use_hull, "...");                          // bool or std::string
//     visit.choice("method", s.method, {"paper"}, "...");
//     visit.list("colors", s.colors, "...");                         // std::vector of described structs
//   }
#pragma once

#include <yaml-cpp/yaml.h>

#include <cstdint>
#include <initializer_list>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace stevedore {

/// "FILE:LINE: KEY: what is wrong and what would be right".
struct ConfigError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Reads the values of one YAML map into a described settings struct.
class SettingsReader {
 public:
  /// where: the file's name for messages; prefix: path of the map, e.g. "detector".
  SettingsReader(YAML::Node map, std::string where, std::string prefix);

  void operator()(const char* key, double& value, double lowest, double highest, const char* unit,
                  const char* effect);
  void operator()(const char* key, int& value, double lowest, double highest, const char* unit,
                  const char* effect);
  /// Whole numbers beyond an int's: exact up to 2^53.
  void operator()(const char* key, std::int64_t& value, double lowest, double highest, const char* unit,
                  const char* effect);
  void operator()(const char* key, bool& value, const char* effect);
  void operator()(const char* key, std::string& value, const char* effect);
  void choice(const char* key, std::string& value, std::initializer_list<const char*> options,
              const char* effect);
  template <class T>
  void list(const char* key, std::vector<T>& values, const char* /*effect*/) {
    const YAML::Node node = take(key);
    if (!node) return;
    if (!node.IsSequence()) fail(node, key, "is not a list");
    values.clear();
    for (std::size_t i = 0; i < node.size(); ++i) {
      SettingsReader reader(node[i], where_, prefix_ + "." + key + "[" + std::to_string(i) + "]");
      describe(values.emplace_back(), reader);
      reader.finish();
    }
  }

  /// Throws if a key of the map was not asked for.
  void finish() const;

 private:
  YAML::Node take(const char* key);
  double number(const YAML::Node& node, const char* key, double lowest, double highest,
                const char* unit) const;
  [[noreturn]] void fail(const YAML::Node& node, const std::string& key, const std::string& why) const;

  YAML::Node map_;
  std::string where_;
  std::string prefix_;
  std::vector<std::string> known_;
};

class Config {
 public:
  /// An empty configuration: every setting has its default.
  Config() = default;
  /// overrides: "section.key=value", as of --set; the value is YAML. Throws ConfigError.
  static Config load(const std::string& path, const std::vector<std::string>& overrides = {});

  /// The section's values over the defaults of Settings. Throws ConfigError.
  template <class Settings>
  [[nodiscard]] Settings section(const std::string& name) const {
    Settings settings{};
    SettingsReader reader(section_node(name), where_, name);
    describe(settings, reader);
    reader.finish();
    return settings;
  }

  /// `camera_file` at the top of the file, relative to the file's folder; empty: none.
  [[nodiscard]] std::string camera_file() const;

 private:
  void override_with(const std::string& assignment);
  void check_sections() const;
  [[nodiscard]] YAML::Node section_node(const std::string& name) const;

  YAML::Node root_{YAML::NodeType::Map};
  std::string where_ = "(command line)";
};

}  // namespace stevedore
