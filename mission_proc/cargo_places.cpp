#include "mission_proc/cargo_places.hpp"

#include <algorithm>

namespace stevedore {

void CargoPlaces::see(SlotId slot, const Eigen::Vector2d& offset_m, double range_m, std::int64_t utime) {
  // A frame's error grows with range, and so the weight with one over its square. Some fifty frames at the
  // range of the best are remembered: a cargo that was pushed is found at its new place within seconds.
  constexpr double remembered_frames = 50;
  const double weight = 1 / std::max(range_m * range_m, 0.25);
  Mean& mean = known_[slot];
  mean.weight = std::min(mean.weight, remembered_frames * weight) + weight;
  if (mean.place.sightings == 0) mean.place.offset_m.setZero();
  mean.place.offset_m += weight / mean.weight * (offset_m - mean.place.offset_m);
  ++mean.place.sightings;
  mean.place.utime = utime;
}

void CargoPlaces::forget_platform(int platform) {
  std::erase_if(known_, [&](const auto& entry) { return entry.first.platform == platform; });
}

std::optional<CargoPlace> CargoPlaces::at(SlotId slot) const {
  const auto found = known_.find(slot);
  return found == known_.end() ? std::nullopt : std::optional(found->second.place);
}

}  // namespace stevedore
