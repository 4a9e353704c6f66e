// Why a circle was chosen at some instant of a flight, and why the others were not, as MISSION told it.
#pragma once

#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>

#include "lcmtypes/channels.hpp"
#include "runtime/event_log.hpp"

namespace stevedore {

/// The log has no answer; what() says what it has instead.
struct NoAnswer : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// One of the two.
struct Instant {
  std::optional<double> log_s;        ///< from the log's first event
  std::optional<std::int64_t> utime;  ///< us, as in the messages' headers
};

/// "12.5" or "utime:1012500000". Throws UsageError.
Instant parse_instant(const std::string& text);

/// What was said last by then.
struct Said {
  double log_s = 0;  ///< of this MISSION
  mission_t mission;
  double before_s = 0;  ///< it is so much older than the instant
  struct Decision {
    double log_s = 0;
    std::string reason;
  };
  std::optional<Decision> decision;  ///< by which the newest approach began
};

/// Reads as far as it needs to. Throws UsageError for an instant that is not in the log, NoAnswer where
/// nothing was said by then.
Said said_at(LogReader& log, const Instant& instant);

/// Phase, action, target, emergencies, and every candidate with its cost and reason.
std::string explain(const Said& said);
/// One candidate alone, by its slot, or by its track where candidates have no slots. Throws NoAnswer.
std::string explain_one(const Said& said, std::int64_t number);

}  // namespace stevedore
