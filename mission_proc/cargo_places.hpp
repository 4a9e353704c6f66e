// Where on its deck each cargo stands: the mean of what frames show, by their variances.
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>

namespace stevedore {

/// One circle: number of its platform, and its own there.
struct SlotId {
  int platform = -1;
  int slot = -1;
  auto operator<=>(const SlotId&) const = default;
};

struct CargoPlace {
  Eigen::Vector2d offset_m;  ///< of its axis from the circle's centre, deck axes (forward, right)
  int sightings = 0;
};

class CargoPlaces {
 public:
  /// variance_m2: of the offset, in each direction.
  void see(SlotId slot, const Eigen::Vector2d& offset_m, double variance_m2);
  void forget(SlotId slot) { known_.erase(slot); }
  void forget_platform(int platform);
  [[nodiscard]] std::optional<CargoPlace> at(SlotId slot) const;

 private:
  struct Mean {
    CargoPlace place;
    double weight = 0;
  };
  std::map<SlotId, Mean> known_;
};

}  // namespace stevedore
