// What a ray meets first: for the laser, and for what hides what.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "sim_proc/world/scene.hpp"

namespace stevedore::world {

struct Hit {
  double range_m = 0;
  enum class What { surroundings, deck, bucket, tyre, capsule, strand };
  What what = What::surroundings;
  int index = -1;  ///< into the scene's list; -1 for the surroundings
};

/// direction_ned: unit. Strands have their true thickness here. Nothing: it meets nothing at all.
std::optional<Hit> first_hit(const Scene& scene, const Eigen::Vector3d& origin_ned_m,
                             const Eigen::Vector3d& direction_ned);

}  // namespace stevedore::world
