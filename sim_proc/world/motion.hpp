// How things move across the image while the shutter is open.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "sim_proc/world/view.hpp"

namespace stevedore::world {

/// What a thing moves like as the eye sees it: velocity of a point P in camera axes is drift + turn x P.
struct Motion {
  Eigen::Vector3f drift_mps, turn_radps;
};

/// The list that Picture::motion points into: surroundings, then decks, then what hangs from the aircraft,
/// then buckets.
class Motions {
 public:
  explicit Motions(const Scene& scene);

  static constexpr std::uint8_t surroundings = 0;
  [[nodiscard]] std::uint8_t deck(size_t index) const { return static_cast<std::uint8_t>(1 + index); }
  [[nodiscard]] std::uint8_t bucket(size_t index) const {
    return static_cast<std::uint8_t>(2 + decks_ + index);
  }
  /// Of the deck it is over by no more than that, else of the ground it stands on, else of the aircraft.
  [[nodiscard]] std::uint8_t of_place(const Scene& scene, const Eigen::Vector3d& ned_m,
                                      double height_m) const;

  [[nodiscard]] const Motion& at(std::uint8_t index) const { return list_[index]; }
  [[nodiscard]] bool is_still() const;

 private:
  size_t decks_;
  std::vector<Motion> list_;
};

/// Pixels a second, at column u of row v.
Eigen::Vector2f flow_at(const LensRays& rays, const Motion& motion, int u, int v, float depth_m);

/// One row of the picture as the open shutter takes it: the mean along each pixel's path from half of the
/// exposure before to half of it after. out: three arrays of the picture's width.
struct RowOut {
  float *red, *green, *blue;
};
void blur_row(const LensRays& rays, const Motions& motions, const Picture& picture, float exposure_s, int v,
              const RowOut& out);

}  // namespace stevedore::world
