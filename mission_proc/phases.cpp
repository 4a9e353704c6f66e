#include "mission_proc/phases.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <vector>

namespace stevedore {
namespace {

/// One thing after another, as it goes when it goes well, and what can go wrong with it.
constexpr std::array steps{
    Transition{Phase::idle, Event::start, Phase::take_off},
    Transition{Phase::take_off, Event::airborne, Phase::search},
    Transition{Phase::take_off, Event::late, Phase::go_home},
    Transition{Phase::search, Event::chosen, Phase::approach},
    Transition{Phase::search, Event::none_left, Phase::go_home},
    Transition{Phase::search, Event::late, Phase::go_home},
    Transition{Phase::approach, Event::aligned, Phase::descend},
    Transition{Phase::approach, Event::unchosen, Phase::search},
    Transition{Phase::approach, Event::blind, Phase::search},
    Transition{Phase::approach, Event::cargo_gone, Phase::search},
    Transition{Phase::approach, Event::late, Phase::retry},
    Transition{Phase::descend, Event::low, Phase::load},
    Transition{Phase::descend, Event::low_loaded, Phase::drop},
    Transition{Phase::descend, Event::misaligned, Phase::retry},
    Transition{Phase::descend, Event::blind, Phase::retry},
    Transition{Phase::descend, Event::cargo_gone, Phase::verify_drop},
    Transition{Phase::descend, Event::late, Phase::retry},
    Transition{Phase::load, Event::gripped, Phase::verify_load},
    Transition{Phase::load, Event::blind, Phase::retry},
    Transition{Phase::load, Event::late, Phase::retry},
    Transition{Phase::verify_load, Event::loaded, Phase::transit},
    Transition{Phase::verify_load, Event::slipped, Phase::retry},
    Transition{Phase::verify_load, Event::late, Phase::retry},
    Transition{Phase::transit, Event::arrived, Phase::search},
    Transition{Phase::transit, Event::cargo_gone, Phase::search},
    Transition{Phase::transit, Event::none_left, Phase::go_home},
    Transition{Phase::transit, Event::late, Phase::search},
    Transition{Phase::drop, Event::released, Phase::verify_drop},
    Transition{Phase::drop, Event::cargo_gone, Phase::verify_drop},
    Transition{Phase::drop, Event::misaligned, Phase::descend},
    Transition{Phase::drop, Event::blind, Phase::retry},
    Transition{Phase::drop, Event::late, Phase::retry},
    Transition{Phase::verify_drop, Event::placed, Phase::transit},
    Transition{Phase::verify_drop, Event::misplaced, Phase::transit},
    Transition{Phase::verify_drop, Event::none_left, Phase::go_home},
    Transition{Phase::retry, Event::clear, Phase::search},
    Transition{Phase::retry, Event::late, Phase::search},
    Transition{Phase::go_home, Event::arrived, Phase::land},
    Transition{Phase::go_home, Event::late, Phase::land},
    Transition{Phase::land, Event::landed, Phase::complete},
    Transition{Phase::hold, Event::resume, Phase::search},
    Transition{Phase::hold, Event::resume_home, Phase::go_home},
    Transition{Phase::suspended, Event::resume, Phase::search},
    Transition{Phase::suspended, Event::resume_home, Phase::go_home},
    Transition{Phase::suspended, Event::landed, Phase::idle},
    Transition{Phase::abort, Event::resume, Phase::go_home},
    Transition{Phase::abort, Event::resume_home, Phase::go_home},
    Transition{Phase::abort, Event::landed, Phase::complete},
};

constexpr std::array in_flight{Phase::take_off,    Phase::search,      Phase::approach, Phase::descend,
                               Phase::load,        Phase::verify_load, Phase::transit,  Phase::drop,
                               Phase::verify_drop, Phase::go_home,     Phase::land,     Phase::retry,
                               Phase::hold,        Phase::abort};

/// The operator, the other pilot and the battery come first, whatever is being done.
constexpr std::array from_anywhere{
    Transition{Phase::idle, Event::hold, Phase::hold},
    Transition{Phase::idle, Event::abort, Phase::abort},
    Transition{Phase::idle, Event::must_go_home, Phase::go_home},
    Transition{Phase::idle, Event::other_pilot, Phase::suspended},
};

std::vector<Transition> whole_table() {
  std::vector<Transition> table(steps.begin(), steps.end());
  for (const Phase phase : in_flight) {
    for (const Transition& rule : from_anywhere) {
      if (phase == rule.to || (rule.event == Event::must_go_home && phase == Phase::land)) continue;
      if (rule.event == Event::hold && phase == Phase::abort) continue;  // what was aborted stays so
      table.push_back({phase, rule.event, rule.to});
    }
  }
  return table;
}

}  // namespace

std::span<const Transition> transitions() {
  static const std::vector<Transition> table = whole_table();
  return table;
}

Phase after(Phase phase, Event event) {
  const auto table = transitions();
  const auto rule = std::find_if(table.begin(), table.end(), [&](const Transition& each) {
    return each.from == phase && each.event == event;
  });
  return rule == table.end() ? phase : rule->to;
}

const char* name_of(Phase phase) {
  static constexpr std::array<const char*, phase_count> names{
      "idle",        "take_off", "search",    "approach",    "descend", "load",
      "verify_load", "transit",  "drop",      "verify_drop", "go_home", "land",
      "retry",       "hold",     "suspended", "abort",       "complete"};
  return names.at(static_cast<std::size_t>(phase));
}

const char* name_of(Event event) {
  static constexpr std::array<const char*, event_count> names{
      "start",        "airborne", "chosen",    "unchosen",    "aligned",  "misaligned", "low",
      "low_loaded",   "gripped",  "loaded",    "slipped",     "released", "placed",     "misplaced",
      "cargo_gone",   "arrived",  "none_left", "blind",       "late",     "clear",      "landed",
      "must_go_home", "hold",     "resume",    "resume_home", "abort",    "other_pilot"};
  return names.at(static_cast<std::size_t>(event));
}

std::string phase_diagram() {
  std::string text = "stateDiagram-v2\n    [*] --> idle\n";
  for (const Transition& rule : steps) {
    text += fmt::format("    {} --> {}: {}\n", name_of(rule.from), name_of(rule.to), name_of(rule.event));
  }
  for (const Transition& rule : from_anywhere) {
    text += fmt::format("    flight --> {}: {}\n", name_of(rule.to), name_of(rule.event));
  }
  return text + "    complete --> [*]\n";
}

}  // namespace stevedore
