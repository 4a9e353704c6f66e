#include "tools/explain_core.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>

#include "lcmtypes/names.hpp"
#include "runtime/command_line.hpp"

namespace stevedore {
namespace {

constexpr const char* utime_prefix = "utime:";

template <class Number>
std::optional<Number> number_of(const std::string& text) {
  Number number{};
  const char* end = text.data() + text.size();
  const auto [stop, fault] = std::from_chars(text.data(), end, number);
  if (fault != std::errc() || stop != end) return std::nullopt;
  return number;
}

/// Goes through the log with the newest MISSION in hand. Stamps are not in the log's order: one that a
/// VEHICLE_STATE caused may stand before that of an older frame.
class Reading {
 public:
  explicit Reading(const Instant& instant) : instant_(instant) {}

  /// false: nothing from this event on is of the instant.
  bool take(const LogEvent& event) {
    if (!first_utime_) first_utime_ = event.utime;
    log_s_ = static_cast<double>(event.utime - *first_utime_) * 1e-6;
    if (instant_.log_s && log_s_ > *instant_.log_s) return false;
    if (event.channel != channels::mission.name) return true;
    auto mission = decode(event, channels::mission);
    if (!mission) {
      ++unreadable_;
      return true;
    }
    constexpr std::int64_t most_out_of_order_us =
        1'000'000;  // a frame that late is nobody's business any more
    const std::int64_t utime = mission->header.utime;
    first_said_ = std::min(first_said_.value_or(utime), utime);
    last_said_ = std::max(last_said_.value_or(utime), utime);
    const bool approaches = mission->phase == mission_t::PHASE_APPROACH;
    if (approaches && !approached_) decision_ = Said::Decision{log_s_, mission->reason};
    if (mission->phase == mission_t::PHASE_SEARCH) decision_.reset();
    approached_ = approaches;
    if (instant_.utime && utime > *instant_.utime) return utime - *instant_.utime < most_out_of_order_us;
    if (instant_.utime && said_ && utime < said_->mission.header.utime) return true;
    said_ = Said{log_s_, std::move(*mission), 0, decision_};
    return true;
  }

  /// ended: the log did, before the instant.
  Said result(bool ended) {
    if (!first_utime_) throw NoAnswer("the log is empty");
    if (ended && !last_said_) throw NoAnswer(nothing_said("in it"));
    const bool beyond = ended && (instant_.utime ? *last_said_ < *instant_.utime : log_s_ < *instant_.log_s);
    if (beyond) throw UsageError(outside());
    if (!said_ && instant_.utime)
      throw UsageError(
          fmt::format("TIME is before the first MISSION, which is {}{}", utime_prefix, *first_said_));
    if (!said_) throw NoAnswer(nothing_said("by then"));
    const double utime_s =
        instant_.utime ? static_cast<double>(*instant_.utime - said_->mission.header.utime) * 1e-6 : 0;
    said_->before_s = instant_.log_s ? *instant_.log_s - said_->log_s : utime_s;
    return std::move(*said_);
  }

 private:
  [[nodiscard]] std::string outside() const {
    return fmt::format(
        "TIME is beyond the log's end: the log is {:.2f} s long, its last MISSION {}{}; name an instant "
        "within it",
        log_s_, utime_prefix, *last_said_);
  }
  [[nodiscard]] std::string nothing_said(const char* where) const {
    if (unreadable_ > 0)
      return fmt::format(
          "no MISSION can be read {}, {} are damaged or of another version: use the explain of the build "
          "that "
          "wrote the log",
          where, unreadable_);
    return fmt::format(
        "no MISSION is {}: take a log of a flight with mission_proc (record, ./run, campaign --log), and an "
        "instant after its start (report LOG says how long it is)",
        where);
  }

  const Instant instant_;
  std::optional<std::int64_t> first_utime_;
  std::optional<std::int64_t> first_said_, last_said_;  ///< by their stamps
  bool approached_ = false;                             ///< the MISSION before did
  std::optional<Said::Decision> decision_;
  double log_s_ = 0;
  int unreadable_ = 0;
  std::optional<Said> said_;
};

const char* noun_of(std::int8_t label) {
  if (label == ellipse_t::LABEL_CIRCLE) return "circle";
  return label == ellipse_t::LABEL_CARGO ? "cargo" : "mark";
}

/// A slot is a circle of the deck, whatever is looked for in it.
std::string name_of(const candidate_t& candidate) {
  if (candidate.slot >= 0) return fmt::format("circle {} of platform {}", candidate.slot, candidate.platform);
  return fmt::format("{} {}", noun_of(candidate.label), candidate.track_id);
}

std::int64_t number_of(const candidate_t& candidate) {
  return candidate.slot >= 0 ? candidate.slot : candidate.track_id;
}

const candidate_t* chosen_of(const mission_t& mission) {
  const auto found = std::find_if(mission.candidates.begin(), mission.candidates.end(),
                                  [](const candidate_t& c) { return c.chosen != 0; });
  return found == mission.candidates.end() ? nullptr : &*found;
}

std::string verdict(const candidate_t& candidate, const candidate_t* chosen) {
  if (candidate.chosen) return "chosen";
  if (!candidate.eligible) return "cannot be chosen";
  if (!chosen) return "could be chosen";
  const double dearer = candidate.cost - chosen->cost;
  if (dearer < 0) return fmt::format("not chosen though {:.2f} cheaper: what is chosen is kept", -dearer);
  return fmt::format("not chosen: {:.2f} dearer", dearer);
}

std::string line_of(const candidate_t& candidate, const candidate_t* chosen) {
  return fmt::format("{} {:<24} cost {:>6}  {}: {}\n", candidate.chosen ? '>' : ' ', name_of(candidate),
                     candidate.eligible || candidate.cost != 0 ? fmt::format("{:.2f}", candidate.cost) : "-",
                     verdict(candidate, chosen), candidate.reason);
}

std::string place_of(const mission_t& m) {
  std::string text;
  if (m.target_platform >= 0)
    text = fmt::format("circle {} of platform {}", m.target_slot, m.target_platform);
  else if (m.target_id >= 0)
    text = fmt::format("track {}", m.target_id);
  else
    return "none";
  if (m.has_target_level)
    text += fmt::format(", {:.2f} m away and {:.2f} m below the camera",
                        std::hypot(m.target_level_m[0], m.target_level_m[1]), m.target_level_m[2]);
  return text + (m.target_age_s < 0 ? ", not measured now"
                                    : fmt::format(", measured {:.2f} s before", m.target_age_s));
}

std::string heading_of(const Said& said) {
  const mission_t& m = said.mission;
  std::string text = fmt::format("MISSION at {:.2f} s ({}{}), {:.2f} s before the instant asked for\n",
                                 said.log_s, utime_prefix, m.header.utime, said.before_s);
  text += fmt::format("phase:   {} for {:.1f} s, action: {}\n", phase_name(m.phase),
                      static_cast<double>(m.header.utime - m.phase_utime) * 1e-6, action_name(m.action));
  text += fmt::format("target:  {}\n", place_of(m));
  text += fmt::format("because: {}\n", m.reason.empty() ? "-" : m.reason);
  if (said.decision)
    text += fmt::format("decided: at {:.2f} s{}\n", said.decision->log_s,
                        said.decision->reason == m.reason ? ", for that" : ": " + said.decision->reason);
  return text + fmt::format("cargoes: {} delivered, {} attempts, {}\n", m.delivered, m.attempts,
                            m.carrying ? "one on the hook" : "none on the hook");
}

/// Slots are weighed while one is searched for, and told on while it is flown to.
std::string when_weighed(const Said& said) {
  const bool slots = said.mission.candidates.front().slot >= 0;
  if (!slots || said.mission.phase == mission_t::PHASE_SEARCH) return "now";
  return said.decision
             ? fmt::format("when it was decided, {:.2f} s earlier", said.log_s - said.decision->log_s)
             : "in the last search";
}

}  // namespace

Instant parse_instant(const std::string& text) {
  Instant instant;
  const std::string prefix = utime_prefix;
  if (text.starts_with(prefix))
    instant.utime = number_of<std::int64_t>(text.substr(prefix.size()));
  else
    instant.log_s = number_of<double>(text);
  const bool sound = (instant.log_s && *instant.log_s >= 0 && std::isfinite(*instant.log_s)) ||
                     (instant.utime && *instant.utime >= 0);
  if (!sound)
    throw UsageError(fmt::format(
        "TIME {}: give seconds from the log's start, as 12.5, or {}N with N as in the messages' headers",
        text, utime_prefix));
  return instant;
}

Said said_at(LogReader& log, const Instant& instant) {
  Reading reading(instant);
  while (const auto event = log.next())
    if (!reading.take(*event)) return reading.result(false);
  return reading.result(true);
}

std::string explain(const Said& said) {
  const mission_t& m = said.mission;
  std::string text = heading_of(said);
  for (const emergency_t& e : m.emergencies)
    text += fmt::format("wrong:   {}, since {:.1f} s: {} (advised: {})\n", emergency_name(e.kind), e.age_s,
                        e.cause, action_name(e.advised_action));
  if (m.candidates.empty()) return text + "candidates: none was weighed\n";
  text += fmt::format("candidates, the lowest cost wins (weighed {}):\n", when_weighed(said));
  const candidate_t* chosen = chosen_of(m);
  for (const candidate_t& c : m.candidates) text += line_of(c, chosen);
  return text;
}

std::string explain_one(const Said& said, std::int64_t number) {
  const auto& candidates = said.mission.candidates;
  const auto found = std::find_if(candidates.begin(), candidates.end(),
                                  [&](const candidate_t& c) { return number_of(c) == number; });
  if (found == candidates.end()) {
    std::string others;
    for (const candidate_t& c : candidates) others += fmt::format(" {}", number_of(c));
    throw NoAnswer(fmt::format("{} was not among the candidates at {:.2f} s; they were:{}", number,
                               said.log_s, others.empty() ? " none" : others));
  }
  const candidate_t* chosen = chosen_of(said.mission);
  std::string text = fmt::format("At {:.2f} s, phase {}; weighed {}:\n", said.log_s,
                                 phase_name(said.mission.phase), when_weighed(said));
  text += line_of(*found, chosen);
  if (chosen && !found->chosen) text += "instead:\n" + line_of(*chosen, chosen);
  return text;
}

}  // namespace stevedore
