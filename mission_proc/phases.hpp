// The mission's phases, and what leads from one to another: one table.
#pragma once

#include <span>
#include <string>

namespace stevedore {

enum class Phase {
  idle,
  take_off,
  search,       ///< for the platform that comes next, and on it for a cargo or a free circle
  approach,     ///< over the target, until the hook hangs still above it
  descend,      ///< to just above the handle, or the deck
  load,         ///< the last decimetres, and the jaws
  verify_load,  ///< up again: does it hang, is its circle empty
  transit,      ///< to the other platform
  drop,         ///< the last decimetres, and the jaws
  verify_drop,  ///< up again: does it stand in its circle
  go_home,
  land,
  retry,      ///< up to the clear height after a step that failed
  hold,       ///< by the operator
  suspended,  ///< somebody else flies
  abort,      ///< by the operator: nothing more is carried
  complete
};
constexpr int phase_count = 17;

enum class Event {
  start,       ///< the operator's word
  airborne,    ///< high enough to fly on
  chosen,      ///< there is a target
  unchosen,    ///< the target is none any more
  aligned,     ///< the gate over the target has held
  misaligned,  ///< far off the target's axis
  low,         ///< just above it, with an empty hook
  low_loaded,  ///< just above it, with a cargo
  gripped,     ///< the jaws are closed on something
  loaded,      ///< a cargo hangs
  slipped,     ///< none does
  released,    ///< the jaws are open
  placed,      ///< the cargo stands in its circle
  misplaced,   ///< it does not
  cargo_gone,  ///< what hung on the hook hangs there no more
  arrived,     ///< near the platform, over the pad
  none_left,   ///< nothing to carry, or nowhere to put it
  blind,       ///< the target was not seen for too long
  late,        ///< the phase has taken too long
  clear,       ///< at the clear height
  landed,
  must_go_home,  ///< battery or fence
  hold,          ///< the operator's word
  resume,        ///< the same
  resume_home,   ///< the same, of a mission that was on its way home
  abort,         ///< the same
  other_pilot    ///< the autopilot is in another mode than guided
};
constexpr int event_count = 27;

struct Transition {
  Phase from;
  Event event;
  Phase to;
};

/// Every pair that leads somewhere. A pair that is not in it changes nothing.
std::span<const Transition> transitions();

/// Where an event leads.
Phase after(Phase phase, Event event);

const char* name_of(Phase phase);
const char* name_of(Event event);

/// The table as a Mermaid state diagram: events that lead from every phase of flight are said once.
std::string phase_diagram();

}  // namespace stevedore
