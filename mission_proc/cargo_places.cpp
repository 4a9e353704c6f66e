#include "mission_proc/cargo_places.hpp"

namespace stevedore {

void CargoPlaces::see(SlotId slot, const Eigen::Vector2d& offset_m, double variance_m2) {
  // some fifty frames are remembered: a cargo that was pushed is found at its new place within seconds
  constexpr double remembered_frames = 50, least_m = 0.005;
  const double weight = 1 / (variance_m2 + least_m * least_m);
  Mean& mean = known_[slot];
  mean.weight = (1 - 1 / remembered_frames) * mean.weight + weight;
  if (mean.place.sightings == 0) mean.place.offset_m.setZero();
  mean.place.offset_m += weight / mean.weight * (offset_m - mean.place.offset_m);
  ++mean.place.sightings;
}

void CargoPlaces::forget_platform(int platform) {
  std::erase_if(known_, [&](const auto& entry) { return entry.first.platform == platform; });
}

std::optional<CargoPlace> CargoPlaces::at(SlotId slot) const {
  const auto found = known_.find(slot);
  return found == known_.end() ? std::nullopt : std::optional(found->second.place);
}

}  // namespace stevedore
