// Whether a replayed message says what the logged one said.
//
// From lossless frames it must be the same to the bit, header.trace apart. A log whose frames are JPEG may
// have been made from other pixels than it holds (`record --frames jpeg`): then what the control system flies
// by is compared by field. Tolerances, against what JPEG of quality 95 was seen to do over 600 frames, real
// and drawn:
// - ellipses: whole ones within 0.5 px of centre (seen: 0.05 px in 9 of 10, 0.2 px at most) and 1 px of
//   semi-axes (0.05 px in 9 of 10, 0.6 px at most). One in ten, and always two, may come or go: at the
//   detector's gates a grey value decides (seen: two at most). Partial ones rest on a few edge points and are
//   not compared.
// - target: status the same, ellipse as above. Numbers of tracks are not compared: one ellipse more shifts
// all
//   later ones.
// - poses, platforms: the target's chosen centre and a platform's centre within three standard deviations
//   that the flight stated for them: JPEG's rounding is noise of its own, as large as a quiet camera's.
//   Platforms, their slots and their certainty the same.
// - mission: phase, action, target status and kinds of emergencies the same; target as for poses.
// All other channels don't depend on pixels: to the bit.
#pragma once

#include "runtime/event_log.hpp"

namespace stevedore {

enum class Match { equal, within_tolerance, different };

/// Of two events on one channel.
Match match_of(const LogEvent& logged, const LogEvent& replayed, bool frames_are_lossy);

/// One line for people: the tolerances.
extern const char* const lossy_tolerances;

}  // namespace stevedore
