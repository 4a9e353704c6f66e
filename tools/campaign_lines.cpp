#include "tools/campaign_lines.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "runtime/command_line.hpp"

namespace stevedore {
namespace {

/// Whether a line that can't be read may be one of ours that was torn.
bool begins_as_ours(const std::string& text) {
  const std::string beginning = "{\"seed\":";
  return text.starts_with(beginning) || beginning.starts_with(text);
}

/// Finer than anything is measured, and short.
double to_four_digits(double value) {
  return std::round(value * 1e4) / 1e4;
}

std::string share_text(int successes, int trials) {
  const Interval interval = wilson_interval(successes, trials);
  return fmt::format("{} of {} ({:.1f} %; Wilson 95 %: {:.1f} to {:.1f} %)", successes, trials,
                     100.0 * successes / trials, 100 * interval.low, 100 * interval.high);
}

std::string drop_error_text(const std::vector<MissionLine>& lines) {
  double sum_m = 0, worst_m = 0;
  int count = 0;
  for (const MissionLine& line : lines)
    for (const double error_m : line.drop_error_m) {
      sum_m += error_m, ++count;
      worst_m = std::max(worst_m, error_m);
    }
  if (count == 0) return "drop error: nothing was delivered\n";
  return fmt::format("drop error: mean {:.3f} m, worst {:.3f} m\n", sum_m / count, worst_m);
}

std::string sea_state_text(const std::vector<MissionLine>& lines) {
  std::map<int, std::pair<int, int>> by_sea_state;  // all delivered, missions
  for (const MissionLine& line : lines) {
    auto& [all, missions] = by_sea_state[line.sea_state];
    ++missions;
    if (line.all()) ++all;
  }
  std::string text;
  for (const auto& [sea_state, counts] : by_sea_state)
    text += fmt::format("  sea state {}: {} of {}\n", sea_state, counts.first, counts.second);
  return text;
}

std::string cause_text(const std::vector<MissionLine>& lines) {
  std::map<std::string, std::string> seeds_by_kind;
  std::map<std::string, int> count_by_kind;
  for (const MissionLine& line : lines) {
    if (line.all()) continue;
    const std::string kind = kind_of_cause(line.cause);
    ++count_by_kind[kind];
    seeds_by_kind[kind] += fmt::format(" {}", line.seed);
  }
  std::string text = count_by_kind.empty() ? "" : "causes of the others:\n";
  for (const auto& [kind, count] : count_by_kind)
    text += fmt::format("  {:3} x {}: seed{}\n", count, kind, seeds_by_kind[kind]);
  return text;
}

std::string time_text(const std::vector<MissionLine>& lines) {
  double wall_s = 0, flown_s = 0;
  for (const MissionLine& line : lines) wall_s += line.wall_s, flown_s += line.flown_s;
  const auto count = static_cast<double>(lines.size());
  return fmt::format(
      "flown {:.0f} s a mission, in {:.0f} s of a worker: {:.1f} missions an hour with one worker\n",
      flown_s / count, wall_s / count, wall_s > 0 ? 3600 * count / wall_s : 0);
}

}  // namespace

std::string to_json_line(const MissionLine& line) {
  nlohmann::ordered_json errors = nlohmann::ordered_json::array();
  for (const double error_m : line.drop_error_m) errors.push_back(to_four_digits(error_m));
  return nlohmann::ordered_json{{"seed", line.seed},
                                {"sea_state", line.sea_state},
                                {"delivered", line.delivered},
                                {"of", line.of},
                                {"attempts", line.attempts},
                                {"duration_s", to_four_digits(line.duration_s)},
                                {"flown_s", to_four_digits(line.flown_s)},
                                {"drop_error_m", errors},
                                {"cause", line.cause},
                                {"wall_s", to_four_digits(line.wall_s)}}
      .dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

std::optional<MissionLine> mission_line_of(const std::string& text) {
  try {
    const auto json = nlohmann::json::parse(text);
    MissionLine line;
    json.at("seed").get_to(line.seed);
    json.at("sea_state").get_to(line.sea_state);
    json.at("delivered").get_to(line.delivered);
    json.at("of").get_to(line.of);
    json.at("attempts").get_to(line.attempts);
    json.at("duration_s").get_to(line.duration_s);
    json.at("flown_s").get_to(line.flown_s);
    json.at("drop_error_m").get_to(line.drop_error_m);
    json.at("cause").get_to(line.cause);
    json.at("wall_s").get_to(line.wall_s);
    return line;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;
  }
}

MissionLines parse_mission_lines(const std::string& text, const std::string& name) {
  MissionLines result;
  int number = 0;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const bool is_last = end + 1 >= text.size();
    ++number;
    if (auto line = mission_line_of(text.substr(begin, end - begin)))
      result.lines.push_back(std::move(*line));
    else if (is_last && begins_as_ours(text.substr(begin, end - begin))) {
      result.is_torn = true;
      return result;
    } else if (is_last)
      throw std::runtime_error(
          fmt::format("{}:{}: not a campaign's line, so this is another file, or a damaged one: name "
                      "another, or take the "
                      "line out",
                      name, number));
    else
      throw std::runtime_error(fmt::format(
          "{}:{}: not a campaign's line; take the line out, and its mission is flown again", name, number));
    result.is_closed = end < text.size();
    begin = result.sound_bytes = std::min(end + 1, text.size());
  }
  return result;
}

MissionLines read_mission_lines(const std::string& path) {
  const std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(fmt::format("{}: can't be read: {}", path, std::strerror(errno)));
  std::ostringstream text;
  text << file.rdbuf();
  return parse_mission_lines(text.str(), path);
}

MissionFile::MissionFile(const std::string& path)
    : path_(path), file_(open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666)) {
  if (file_.get() < 0)
    throw std::runtime_error(fmt::format("{}: can't be written: {}", path, std::strerror(errno)));
  if (flock(file_.get(), LOCK_EX | LOCK_NB) != 0)
    throw std::runtime_error(path + ": another campaign writes to it; name another file with --out");
  MissionLines there = read_mission_lines(path);
  if (ftruncate(file_.get(), static_cast<off_t>(there.sound_bytes)) != 0)
    throw std::runtime_error(fmt::format("{}: can't be written: {}", path, std::strerror(errno)));
  if (!there.is_closed) write("\n");
  lines_ = std::move(there.lines);
}

void MissionFile::add(const MissionLine& line) {
  write(to_json_line(line) + "\n");
  lines_.push_back(line);
}

void MissionFile::write(const std::string& text) {
  const ssize_t written = ::write(file_.get(), text.data(), text.size());
  if (written != static_cast<ssize_t>(text.size()))
    throw std::runtime_error(fmt::format("{}: can't be written: {}", path_,
                                         written < 0 ? std::strerror(errno) : "the disk is full"));
}

Shard parse_shard(const std::string& text) {
  Shard shard;
  const char* const end = text.data() + text.size();
  const auto number = std::from_chars(text.data(), end, shard.number);
  const bool has_both = number.ec == std::errc() && number.ptr != end && *number.ptr == '/';
  const auto count = has_both ? std::from_chars(number.ptr + 1, end, shard.count) : number;
  if (!has_both || count.ec != std::errc() || count.ptr != end || shard.number < 1 ||
      shard.number > shard.count)
    throw UsageError("--shard " + text + ": give I/K, the I-th of K shards, as 1/4 to 4/4");
  return shard;
}

std::vector<std::int64_t> seeds_to_fly(std::int64_t first, int missions, const Shard& shard,
                                       const std::vector<MissionLine>& done) {
  std::set<std::int64_t> flown;
  for (const MissionLine& line : done) flown.insert(line.seed);
  std::vector<std::int64_t> seeds;
  for (int i = shard.number - 1; i < missions; i += shard.count)
    if (!flown.contains(first + i)) seeds.push_back(first + i);
  return seeds;
}

Interval wilson_interval(int successes, int trials) {
  if (trials <= 0) return {};
  constexpr double z = 1.959964;  // 97.5 % of a normal distribution lie below it
  const double n = trials, p = successes / n, z2_n = z * z / n;
  const double middle = (p + z2_n / 2) / (1 + z2_n);
  const double half = z / (1 + z2_n) * std::sqrt(p * (1 - p) / n + z2_n / (4 * n));
  return {std::max(0.0, middle - half), std::min(1.0, middle + half)};
}

std::string kind_of_cause(const std::string& cause) {
  return cause.empty() ? "not told" : cause.substr(0, cause.find(" ("));
}

std::string summary_of(const std::vector<MissionLine>& lines) {
  std::vector<MissionLine> once;
  std::set<std::int64_t> seeds;
  for (const MissionLine& line : lines)
    if (seeds.insert(line.seed).second) once.push_back(line);
  std::sort(once.begin(), once.end(), [](const auto& a, const auto& b) { return a.seed < b.seed; });
  if (once.empty()) return "no mission was flown\n";
  int all = 0, delivered = 0, of = 0, attempts = 0;
  for (const MissionLine& line : once) {
    if (line.all()) ++all;
    delivered += line.delivered, of += line.of, attempts += line.attempts;
  }
  std::string text =
      fmt::format("missions with all delivered: {}\n", share_text(all, static_cast<int>(once.size())));
  text += sea_state_text(once);
  text += fmt::format("cargoes: {} of {} delivered, in {} attempts\n", delivered, of, attempts);
  text += drop_error_text(once) + cause_text(once) + time_text(once);
  if (once.size() < lines.size())
    text += fmt::format("left out: {} lines of seeds that were there already\n", lines.size() - once.size());
  return text;
}

}  // namespace stevedore
