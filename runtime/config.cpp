#include "runtime/config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <set>

namespace stevedore {
namespace {

/// What may stand at the top of a deployment's file.
constexpr std::array<const char*, 11> known_sections = {"camera_file", "bus",    "camera",  "detector",
                                                        "tracker",     "pose",   "mission", "sim",
                                                        "gimbal",      "record", "platform"};

/// Nodes without a mark are of no file: they came by --set.
std::string location(const YAML::Node& node, const std::string& where) {
  const auto mark = node.Mark();
  return mark.is_null() ? "--set" : fmt::format("{}:{}", where, mark.line + 1);
}

/// The same value; the mark of what was parsed from a --set would be a line of the file.
YAML::Node without_marks(const YAML::Node& node) {
  if (node.IsScalar()) return YAML::Node(node.Scalar());
  YAML::Node copy(node.Type());
  if (node.IsSequence())
    for (const auto& item : node) copy.push_back(without_marks(item));
  if (node.IsMap())
    for (const auto& entry : node) copy[entry.first.Scalar()] = without_marks(entry.second);
  return copy;
}

}  // namespace

SettingsReader::SettingsReader(YAML::Node map, std::string where, std::string prefix)
    : map_(std::move(map)), where_(std::move(where)), prefix_(std::move(prefix)) {
  if (map_ && !map_.IsNull() && !map_.IsMap()) {
    throw ConfigError(fmt::format("{}: {}: is not a map of settings", location(map_, where_), prefix_));
  }
}

void SettingsReader::fail(const YAML::Node& node, const std::string& key, const std::string& why) const {
  throw ConfigError(fmt::format("{}: {}.{}: {}", location(node, where_), prefix_, key, why));
}

YAML::Node SettingsReader::take(const char* key) {
  known_.emplace_back(key);
  return map_ && map_.IsMap() ? map_[key] : YAML::Node(YAML::NodeType::Undefined);
}

double SettingsReader::number(const YAML::Node& node, const char* key, double lowest, double highest,
                              const char* unit) const {
  double value = 0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) || !std::isfinite(value)) {
    fail(node, key, fmt::format("is not a number (in {})", unit));
  }
  if (value < lowest || value > highest) {
    fail(node, key, fmt::format("{} is not between {} and {} {}", node.Scalar(), lowest, highest, unit));
  }
  return value;
}

void SettingsReader::operator()(const char* key, double& value, double lowest, double highest,
                                const char* unit, const char* /*effect*/) {
  if (const YAML::Node node = take(key)) value = number(node, key, lowest, highest, unit);
}

void SettingsReader::operator()(const char* key, int& value, double lowest, double highest, const char* unit,
                                const char* effect) {
  std::int64_t whole = value;
  (*this)(key, whole, lowest, highest, unit, effect);
  value = static_cast<int>(whole);
}

void SettingsReader::operator()(const char* key, std::int64_t& value, double lowest, double highest,
                                const char* unit, const char* /*effect*/) {
  const YAML::Node node = take(key);
  if (!node) return;
  const double read = number(node, key, lowest, highest, unit);
  if (read != std::floor(read)) fail(node, key, fmt::format("{} is not a whole number", node.Scalar()));
  value = static_cast<std::int64_t>(read);
}

void SettingsReader::operator()(const char* key, bool& value, const char* /*effect*/) {
  const YAML::Node node = take(key);
  if (node && (!node.IsScalar() || !YAML::convert<bool>::decode(node, value)))
    fail(node, key, "is not true or false");
}

void SettingsReader::operator()(const char* key, std::string& value, const char* /*effect*/) {
  const YAML::Node node = take(key);
  if (!node) return;
  if (!node.IsScalar()) fail(node, key, "is not a text");
  value = node.Scalar();
}

void SettingsReader::choice(const char* key, std::string& value, std::initializer_list<const char*> options,
                            const char* effect) {
  const YAML::Node node = map_ && map_.IsMap() ? map_[key] : YAML::Node(YAML::NodeType::Undefined);
  (*this)(key, value, effect);
  if (std::find(options.begin(), options.end(), value) == options.end()) {
    fail(node, key, fmt::format("'{}' is not one of: {}", value, fmt::join(options, ", ")));
  }
}

void SettingsReader::finish() const {
  if (!map_ || !map_.IsMap()) return;
  std::set<std::string> seen;
  for (const auto& entry : map_) {
    const std::string key = entry.first.Scalar();
    if (!seen.insert(key).second) fail(entry.first, key, "stands here twice");
    if (std::find(known_.begin(), known_.end(), key) == known_.end()) {
      fail(entry.first, key, fmt::format("is not a setting; there are: {}", fmt::join(known_, ", ")));
    }
  }
}

Config Config::load(const std::string& path, const std::vector<std::string>& overrides) {
  Config config;
  if (!path.empty()) {
    config.where_ = path;
    if (std::filesystem::is_directory(path)) throw ConfigError(path + ": is a folder");
    try {
      config.root_ = YAML::LoadFile(path);
    } catch (const YAML::BadFile&) {
      throw ConfigError(path + ": can't be read");
    } catch (const YAML::ParserException& error) {
      throw ConfigError(fmt::format("{}:{}: {}", path, error.mark.line + 1, error.msg));
    }
    if (config.root_.IsNull()) config.root_ = YAML::Node(YAML::NodeType::Map);
    if (!config.root_.IsMap()) throw ConfigError(path + ":1: is not a map of sections");
  }
  for (const auto& assignment : overrides) config.override_with(assignment);
  config.check_sections();
  return config;
}

void Config::override_with(const std::string& assignment) {
  const auto equals = assignment.find('=');
  const std::string path = assignment.substr(0, equals);
  const auto dot = path.find('.');
  if (equals == std::string::npos || path.empty() || dot == 0 || dot + 1 == path.size()) {
    throw ConfigError("--set " + assignment + ": is not section.key=value");
  }
  YAML::Node value;
  try {
    value = without_marks(YAML::Load(assignment.substr(equals + 1)));
  } catch (const YAML::ParserException& error) {
    throw ConfigError("--set " + assignment + ": " + error.msg);
  }
  if (dot == std::string::npos) {
    root_[path] = value;
    return;
  }
  YAML::Node section = root_[path.substr(0, dot)];
  if (section.IsDefined() && !section.IsNull() && !section.IsMap()) {
    throw ConfigError("--set " + assignment + ": " + path.substr(0, dot) + " is not a map of settings");
  }
  section[path.substr(dot + 1)] = value;
}

void Config::check_sections() const {
  std::set<std::string> seen;
  for (const auto& entry : root_) {
    const std::string name = entry.first.Scalar();
    if (!seen.insert(name).second)
      throw ConfigError(fmt::format("{}: {}: stands here twice", location(entry.first, where_), name));
    if (std::find(known_sections.begin(), known_sections.end(), name) == known_sections.end()) {
      throw ConfigError(fmt::format("{}: {}: is not a section; there are: {}", location(entry.first, where_),
                                    name, fmt::join(known_sections, ", ")));
    }
  }
}

YAML::Node Config::section_node(const std::string& name) const {
  const YAML::Node& root = root_;
  return root[name];
}

std::string Config::camera_file() const {
  const YAML::Node node = section_node("camera_file");
  if (!node || node.IsNull() || (node.IsScalar() && node.Scalar().empty())) return {};
  if (!node.IsScalar()) throw ConfigError(location(node, where_) + ": camera_file: is not a file's name");
  const std::filesystem::path file = node.Scalar();
  if (file.is_absolute()) return file;
  return std::filesystem::path(where_).parent_path() / file;
}

}  // namespace stevedore
