// The flat things of a scene: the surroundings and the upper sides of decks.
#pragma once

#include <vector>

#include "sim_proc/world/marks.hpp"
#include "sim_proc/world/plane_row.hpp"
#include "sim_proc/world/shadows.hpp"
#include "sim_proc/world/solids.hpp"
#include "sim_proc/world/texture.hpp"

namespace stevedore::world {

/// A deck's upper side and its body under it.
class DeckLayer {
 public:
  DeckLayer(const View& view, const Scene& scene, size_t index, std::uint8_t motion);

  /// Fills where the row's pixels meet the deck and how much of each it covers. False: none of them.
  bool meet(int v, PlaneRow& row) const;
  /// Lays the body over what rows first..last-1 show already, then the upper side over one row after meet().
  void draw_body(const Textures& textures, int first, int last, Picture& picture,
                 Solid::Scratch& scratch) const;
  void draw_top(const Textures& textures, PlaneRow& row, const PictureRow& picture) const;

 private:
  [[nodiscard]] float cover_at(const PlaneRow& row, int u) const;

  const LensRays& rays_;
  const Deck& deck_;
  const Light& light_;
  PlaneView plane_;
  Marks marks_;
  Shadows shadows_;
  Solid body_;
  Eigen::Vector3f to_sun_;  ///< in the deck's axes
  float half_x_m_, half_y_m_;
  std::uint8_t motion_;
};

class GroundLayer {
 public:
  GroundLayer(const View& view, const Scene& scene);

  /// Draws columns row.first..row.last-1; above the horizon the sky.
  void draw(const Textures& textures, PlaneRow& row, const PictureRow& picture) const;

 private:
  void draw_sky(const PlaneRow& row, const PictureRow& picture) const;

  const Surroundings& surroundings_;
  const Light& light_;
  Rigid level_;  ///< world z = 0, and its axes
  PlaneView plane_;
  Shadows shadows_;
};

/// Grey of the air before everything.
void add_haze(const Scene& scene, int width, const PictureRow& picture);

}  // namespace stevedore::world
