#include "sim_proc/world/footing.hpp"

#include <cstddef>

namespace stevedore::world {

Footing footing_below(const Floor& floor, const Eigen::Vector3d& point_ned_m) {
  for (std::size_t i = 0; i < floor.decks.size(); ++i) {
    const DeckFloor& deck = floor.decks[i];
    const Eigen::Vector3d local_m = deck.rigid.to_local(point_ned_m);
    const bool over = (local_m.head<2>().cwiseAbs().array() <= deck.half_size_m.array()).all();
    if (over && local_m.z() < deepest_m) return {static_cast<int>(i), deck.rigid};
  }
  return {};
}

}  // namespace stevedore::world
