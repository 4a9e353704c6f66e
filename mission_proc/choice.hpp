// Which cargo next, and which circle for it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "mission_proc/cargo_places.hpp"
#include "mission_proc/deck_path.hpp"

namespace stevedore {

struct SlotCandidate {
  SlotId slot;
  bool eligible = false;
  bool chosen = false;
  double cost = 0;  ///< metres, or what is worth as many; the lowest wins
  std::string reason;
};

struct ChoiceInputs {
  const DeckPath* deck = nullptr;
  std::int64_t utime = 0;
  Eigen::Vector2d hook_odometry_m;
  bool loaded = false;           ///< a free circle is wanted, not a cargo
  std::optional<SlotId> kept;    ///< chosen before
  std::optional<SlotId> wished;  ///< the operator's
  std::vector<int> failures;     ///< by slot
  int most_failures = 4;
  std::vector<bool> done;  ///< by slot: a cargo was set down there, or taken away, whatever it looks like now
  /// Every circle was looked at from near, and none is told to be what is wanted. Then any is taken that is
  /// not done: what lies in it is painted there, more likely than not, and a cargo can't be landed with; or a
  /// cargo is there that can't be told from its ground, since each circle had one.
  bool last_resort = false;
};

/// Every circle of the platform, with its cost, what that is made of, and the reason for or against it; one
/// is chosen, if any can be.
///
/// cost = horizontal way of the hook [m]
///      + 3 m a failure (a second way there and back)
///      + 0.5 m for each occupied circle next to it (a rope that swings, a bucket that tips)
///      + 0.2 m a second since it was seen, up to 2 m, and 2 m x (1 - confidence); as the last resort
///        20 m x the chance that it is not what is wanted
///      - 1 m for what was chosen before
std::vector<SlotCandidate> weigh_slots(const ChoiceInputs& inputs);

}  // namespace stevedore
