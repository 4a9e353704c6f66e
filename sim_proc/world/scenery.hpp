// How things look and lie about: drawn once from the seed. The motion of platforms, cargoes and aircraft is
// not its business.
#pragma once

#include <cstdint>
#include <vector>

#include "sim_proc/world/scene.hpp"

namespace stevedore::world {

enum class Layout { square, row };

struct SceneryDraw {
  std::uint64_t seed = 1;
  bool easy = false;             ///< clean paint, no clutter, no spray: for a first look only
  double circle_radius_m = 0.5;  ///< outer edge, as painted: nobody paints to the millimetre
};

/// A scene with two platforms (decks 0 and 1) and the take-off pad (deck 2, one circle at its centre), each
/// at its own origin with level axes; clutter placed relative to the deck that it stands on.
struct Scenery {
  Layout layout = Layout::square;
  double circle_radius_m = 0.5;  ///< as drawn for
  std::vector<Deck> decks;       ///< 0, 1: platforms with slots 0..3; 2: the pad with slot 0
  std::vector<Bucket> buckets;   ///< four, looks only; index 0..3
  Light light;
  Surroundings surroundings;
  double exposure_s = 0.004;
  float noise_levels = 2;
  float lens_blur_sigma_px = 0.6F;

  struct OnDeck {
    int deck = 0;
    std::vector<Tyre> tyres;        ///< rigids relative to the deck
    std::vector<Capsule> capsules;  ///< people, poles: points relative to the deck's axes
    std::vector<Strand> strands;    ///< ropes that lie about
  };
  std::vector<OnDeck> clutter;

  /// The scene with decks where `deck_rigids` says (same order as `decks`) and clutter carried along; eye,
  /// aircraft and buckets' places are left to the caller.
  [[nodiscard]] Scene place(const std::vector<Rigid>& deck_rigids) const;
};

Scenery draw_scenery(const SceneryDraw& draw);

}  // namespace stevedore::world
