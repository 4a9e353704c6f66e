// The mission's table of phases: every pair of phase and event.
#include "mission_proc/phases.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <iterator>
#include <set>
#include <string>
#include <utility>
#include <vector>

using namespace stevedore;

namespace {

std::vector<Phase> all_phases() {
  std::vector<Phase> all;
  for (int i = 0; i < phase_count; ++i) all.push_back(static_cast<Phase>(i));
  return all;
}

std::vector<Event> all_events() {
  std::vector<Event> all;
  for (int i = 0; i < event_count; ++i) all.push_back(static_cast<Event>(i));
  return all;
}

/// What can be reached from a phase, itself included.
std::set<Phase> reached_from(Phase start) {
  std::set<Phase> reached{start};
  std::vector<Phase> left{start};
  while (!left.empty()) {
    const Phase phase = left.back();
    left.pop_back();
    for (const Event event : all_events())
      if (reached.insert(after(phase, event)).second) left.push_back(after(phase, event));
  }
  return reached;
}

bool is_on_the_ground(Phase phase) {
  return phase == Phase::idle || phase == Phase::complete;
}

}  // namespace

TEST_CASE("phases: each pair of phase and event leads to one phase, and is told once") {
  std::set<std::pair<Phase, Event>> told;
  for (const Transition& t : transitions()) {
    INFO(name_of(t.from) << " " << name_of(t.event));
    CHECK(told.insert({t.from, t.event}).second);
    CHECK(after(t.from, t.event) == t.to);
    CHECK(t.from != t.to);
  }
  for (const Phase phase : all_phases()) {
    for (const Event event : all_events()) {
      INFO(name_of(phase) << " " << name_of(event));
      if (!told.contains({phase, event})) CHECK(after(phase, event) == phase);
    }
  }
}

TEST_CASE("phases: every one can come about, and from every one the ground is reached") {
  const std::set<Phase> from_idle = reached_from(Phase::idle);
  for (const Phase phase : all_phases()) {
    INFO(name_of(phase));
    CHECK(from_idle.contains(phase));
    const std::set<Phase> ahead = reached_from(phase);
    CHECK(std::any_of(ahead.begin(), ahead.end(), is_on_the_ground));
  }
}

TEST_CASE(
    "phases: the operator, another pilot and the battery come first, wherever the aircraft is in the air") {
  for (const Phase phase : all_phases()) {
    if (is_on_the_ground(phase) || phase == Phase::suspended) continue;
    INFO(name_of(phase));
    CHECK(after(phase, Event::abort) == Phase::abort);
    CHECK(after(phase, Event::other_pilot) == Phase::suspended);
    CHECK(after(phase, Event::hold) == (phase == Phase::abort ? Phase::abort : Phase::hold));
    const bool lands_already = phase == Phase::land;
    CHECK(after(phase, Event::must_go_home) == (lands_already ? Phase::land : Phase::go_home));
  }
  // while another pilot flies, nothing but his handing back or landing counts
  for (const Event event : all_events())
    if (event != Event::resume && event != Event::resume_home && event != Event::landed)
      CHECK(after(Phase::suspended, event) == Phase::suspended);
}

TEST_CASE("phases: on the ground nothing but the word to start begins anything") {
  for (const Event event : all_events()) {
    INFO(name_of(event));
    CHECK(after(Phase::idle, event) == (event == Event::start ? Phase::take_off : Phase::idle));
    CHECK(after(Phase::complete, event) == Phase::complete);
  }
}

TEST_CASE("phases: what was aborted, or is on its way home, never carries again") {
  for (const Phase start : {Phase::abort, Phase::go_home, Phase::land}) {
    std::set<Phase> reached{start};
    std::vector<Phase> left{start};
    while (!left.empty()) {
      const Phase phase = left.back();
      left.pop_back();
      for (const Event event : all_events()) {
        // the mission says resume_home of those, never resume
        if (event == Event::resume && phase != Phase::abort) continue;
        const Phase next = after(phase, event);
        if (next != Phase::idle && reached.insert(next).second) left.push_back(next);
      }
    }
    INFO(name_of(start));
    for (const Phase carries : {Phase::search, Phase::approach, Phase::descend, Phase::load, Phase::drop})
      CHECK_FALSE(reached.contains(carries));
  }
}

TEST_CASE("phases: one cargo, as it goes when it goes well") {
  Phase phase = Phase::idle;
  const auto goes = [&](Event event, Phase to) {
    INFO(name_of(phase) << " " << name_of(event));
    phase = after(phase, event);
    CHECK(phase == to);
  };
  goes(Event::start, Phase::take_off);
  goes(Event::airborne, Phase::search);
  goes(Event::chosen, Phase::approach);
  goes(Event::aligned, Phase::descend);
  goes(Event::low, Phase::load);
  goes(Event::gripped, Phase::verify_load);
  goes(Event::loaded, Phase::transit);
  goes(Event::arrived, Phase::search);
  goes(Event::chosen, Phase::approach);
  goes(Event::aligned, Phase::descend);
  goes(Event::low_loaded, Phase::drop);
  goes(Event::released, Phase::verify_drop);
  goes(Event::placed, Phase::transit);
  goes(Event::none_left, Phase::go_home);
  goes(Event::arrived, Phase::land);
  goes(Event::landed, Phase::complete);
}

TEST_CASE("phases: mission_proc/README.md has the table as a diagram") {
  std::ifstream file(std::string(STEVEDORE_SOURCE_DIR) + "/mission_proc/README.md");
  const std::string page{std::istreambuf_iterator<char>(file), {}};
  CHECK(page.find("```mermaid\n" + phase_diagram() + "```\n") != std::string::npos);
}
