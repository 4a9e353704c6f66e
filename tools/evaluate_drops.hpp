// Where cargoes that were brought came to stand, and how long before they were let go their circle was last
// measured.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "tools/evaluate_log.hpp"
#include "tools/evaluate_poses.hpp"

namespace stevedore {

/// A cargo that was let go over another platform than the one it stood on.
struct Drop {
  std::int64_t utime = 0;  ///< first TRUTH without it on the hook
  int cargo = 0;
  int platform = 0, slot = 0;  ///< of the circle nearest to where it stands
  double off_m = 0;  ///< of its rim from that circle's middle, along the ground, three seconds later
  bool tipped = false;
  std::optional<double> unseen_s;  ///< since a pose of that circle was measured; nothing: never was
};

std::vector<Drop> find_drops(const std::vector<truth_t>& truth, const PoseComparison& poses);

}  // namespace stevedore
