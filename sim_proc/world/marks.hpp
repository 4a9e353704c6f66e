// Paint on a deck: which share of a pixel a mark covers.
#pragma once

#include <optional>
#include <vector>

#include "sim_proc/world/plane_row.hpp"
#include "sim_proc/world/texture.hpp"

namespace stevedore::world {

/// The marks of one deck as seen from one eye.
class Marks {
 public:
  Marks(const View& view, const Deck& deck);

  /// Lays each mark's reflectance over the row's.
  void paint(const PlaneView& plane, const Textures& textures, PlaneRow& row) const;

 private:
  struct Seen {
    const Mark* mark;
    PixelRect rect;
  };
  std::vector<Seen> seen_;
};

}  // namespace stevedore::world
