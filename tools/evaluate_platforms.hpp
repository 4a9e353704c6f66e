// PLATFORM_ESTIMATE against TRUTH: where the decks are, how they move, where they will be, and what stands on
// them.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "tools/evaluate_log.hpp"
#include "tools/evaluate_spread.hpp"

namespace stevedore {

/// One PLATFORM_ESTIMATE beside the truth. The autopilot's own position is metres off, by an error that the
/// estimate shares: positions are compared relative to the aircraft.
struct PlatformSample {
  std::int64_t utime = 0;
  int platform = 0;
  bool is_certain = false;
  std::optional<double> in_view_s;  ///< for how long without a gap; nothing: it is not
  double height_m = 0;              ///< of the camera over the deck
  double position_error_m = 0;
  double velocity_error_mps = 0;            ///< over ground, all three axes
  double nees6 = 0;                         ///< NEES / 6 of position and velocity
  std::optional<double> predicted_error_m;  ///< one second ahead; nothing: TRUTH ends before
  std::optional<double> held_error_m;       ///< the same, had the deck stood still
};

/// What was said of slots, one count for each slot of each PLATFORM_ESTIMATE that knew something.
struct SlotCounts {
  std::int64_t right = 0;
  std::int64_t wrong = 0;  ///< empty for occupied, or the other way
  std::int64_t unknown = 0;
  std::int64_t misnumbered = 0;  ///< at the place of another slot
  std::int64_t handled = 0;      ///< not judged: its cargo is just being lifted off or set down
};

struct PlatformComparison {
  std::vector<PlatformSample> samples;
  SlotCounts certain, uncertain;   ///< while identity_certain, and else
  std::int64_t without_truth = 0;  ///< of a platform that TRUTH does not have, or of another time
  std::int64_t in_view = 0, in_view_certain = 0;  ///< estimates of a deck seen in the last half second
  /// Below 6 m and after 3 s in view: what lowering a load needs.
  Spread position_m, velocity_mps, predicted_m, held_m;
  double nees6 = std::numeric_limits<double>::quiet_NaN();  ///< mean of the same; NaN: none
};

PlatformComparison compare_platforms(const FlightLog& flight);

}  // namespace stevedore
