// What came of the missions of a campaign: a JSON line each, in a file that is added to, and their sum.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "runtime/file_descriptor.hpp"

namespace stevedore {

struct MissionLine {
  std::int64_t seed = 0;
  int sea_state = 0;
  int delivered = 0;  ///< by TRUTH
  int of = 0;
  int attempts = 0;
  double duration_s = 0;             ///< of the world
  double flown_s = 0;                ///< of it, since the first set-point
  std::vector<double> drop_error_m;  ///< by TRUTH, of every cargo that was delivered
  std::string cause;                 ///< why not all were; empty: all were
  double wall_s = 0;

  [[nodiscard]] bool all() const { return of > 0 && delivered >= of; }
};

/// Without a line's end.
std::string to_json_line(const MissionLine& line);
/// Nothing: it is none.
std::optional<MissionLine> mission_line_of(const std::string& text);

struct MissionLines {
  std::vector<MissionLine> lines;
  std::size_t sound_bytes = 0;  ///< what follows is a torn last line
  bool is_closed = true;        ///< the last line has its end
  bool is_torn = false;         ///< one line was left out
};

/// name: for messages. Throws std::runtime_error where anything but a torn last line of a campaign can't be
/// read.
MissionLines parse_mission_lines(const std::string& text, const std::string& name);
/// Throws std::runtime_error.
MissionLines read_mission_lines(const std::string& path);

/// A file of lines, for one campaign at a time.
class MissionFile {
 public:
  /// Makes it if it is not there, and takes a torn last line off. Throws std::runtime_error.
  explicit MissionFile(const std::string& path);
  [[nodiscard]] const std::vector<MissionLine>& lines() const { return lines_; }
  void add(const MissionLine& line);

 private:
  void write(const std::string& text);

  std::string path_;
  FileDescriptor file_;
  std::vector<MissionLine> lines_;
};

/// Every count-th of the missions, beginning with the number-th.
struct Shard {
  int number = 1;
  int count = 1;
};

/// "2/4". Throws UsageError.
Shard parse_shard(const std::string& text);

/// first, first + 1 and so on, of them the shard's, of those what has no line yet.
std::vector<std::int64_t> seeds_to_fly(std::int64_t first, int missions, const Shard& shard,
                                       const std::vector<MissionLine>& done);

struct Interval {
  double low = 0;
  double high = 1;
};

/// Of a share: E. B. Wilson, Probable inference, the law of succession, and statistical inference, J. Am.
/// Stat. Assoc. 22 (1927), 209-212; 95 %.
Interval wilson_interval(int successes, int trials);

/// What causes are counted by: without the particulars of one mission, which stand in parentheses.
std::string kind_of_cause(const std::string& cause);

/// For people. A seed that is there twice counts once.
std::string summary_of(const std::vector<MissionLine>& lines);

}  // namespace stevedore
