#include "sim_proc/world/scenery.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "sim_proc/world/paints.hpp"

using namespace stevedore::world;
using Eigen::Vector3d;

namespace {

constexpr int draws = 150;

bool is_round(const Mark& mark) {
  return mark.shape != Mark::Shape::bar;
}

/// Furthest that a thing of that radius may be from the deck's middle, along each axis.
bool inside(const Deck& deck, const Eigen::Vector2d& at, double radius_m) {
  return std::abs(at.x()) + radius_m <= deck.half_size_m.x() &&
         std::abs(at.y()) + radius_m <= deck.half_size_m.y();
}

}  // namespace

TEST_CASE("platforms have four circles inside their deck, apart from each other, the pad one in its middle") {
  for (int seed = 0; seed < draws; ++seed) {
    const Scenery scenery = draw_scenery({static_cast<std::uint64_t>(seed), false, 0.503});
    REQUIRE(scenery.decks.size() == 3);
    CHECK(scenery.circle_radius_m == 0.503);
    for (size_t d = 0; d < 3; ++d) {
      const Deck& deck = scenery.decks[d];
      std::set<int> slots;
      std::vector<Eigen::Vector2d> centres;
      for (const Mark& mark : deck.marks) {
        if (mark.slot < 0) continue;
        slots.insert(mark.slot);
        CHECK(mark.radius_m == 0.503);
        CHECK(inside(deck, mark.center_deck_m, mark.radius_m));
        for (const auto& other : centres) CHECK((other - mark.center_deck_m).norm() > 1.15);
        centres.push_back(mark.center_deck_m);
      }
      CHECK(slots == (d < 2 ? std::set{0, 1, 2, 3} : std::set{0}));
      if (d == 2) CHECK(centres[0].norm() == 0);
    }
  }
}

TEST_CASE("nothing round has a circle's size, and nothing painted later covers a circle's edge") {
  for (int seed = 0; seed < draws; ++seed) {
    const Scenery scenery = draw_scenery({static_cast<std::uint64_t>(seed), false, 0.5});
    for (const Deck& deck : scenery.decks)
      for (size_t i = 0; i < deck.marks.size(); ++i) {
        const Mark& mark = deck.marks[i];
        if (mark.slot >= 0) continue;
        if (is_round(mark)) CHECK(std::abs(mark.radius_m - 0.5) >= 0.1);
        for (size_t k = 0; k < i; ++k) {
          const Mark& circle = deck.marks[k];
          if (circle.slot < 0) continue;
          const double reach = mark.shape == Mark::Shape::bar ? mark.length_m / 2 : mark.radius_m;
          const double distance = (mark.center_deck_m - circle.center_deck_m).norm();
          const bool clear = distance + reach < circle.radius_m || distance - reach > circle.radius_m;
          CHECK(clear);
        }
      }
    for (const auto& on_deck : scenery.clutter)
      for (const Tyre& tyre : on_deck.tyres) CHECK(tyre.radius_m < 0.4);
  }
}

TEST_CASE("circles differ visibly from their deck, some by colour alone") {
  int by_colour = 0, circles = 0;
  for (int seed = 0; seed < draws; ++seed) {
    const Scenery scenery = draw_scenery({static_cast<std::uint64_t>(seed), false, 0.5});
    for (const Deck& deck : scenery.decks)
      for (const Mark& mark : deck.marks) {
        if (mark.slot < 0) continue;
        CHECK(differ_visibly(mark.paint.colour, deck.ground.colour));
        CHECK(mark.paint.wear < 0.25F);
        ++circles;
        by_colour += contrast_between(mark.paint.colour, deck.ground.colour).luminance < 0.2F;
      }
  }
  CHECK(by_colour > circles / 20);
  CHECK(by_colour < circles / 4);
}

TEST_CASE("a seed always draws the same, another draws something else, easy draws no clutter") {
  const Scenery a = draw_scenery({7, false, 0.5}), b = draw_scenery({7, false, 0.5}),
                c = draw_scenery({8, false, 0.5});
  CHECK(a.decks[0].marks.size() == b.decks[0].marks.size());
  CHECK(a.decks[0].ground.colour == b.decks[0].ground.colour);
  CHECK(a.light.to_sun_ned == b.light.to_sun_ned);
  CHECK(a.light.to_sun_ned != c.light.to_sun_ned);
  const Scenery easy = draw_scenery({7, true, 0.5});
  CHECK(easy.clutter.empty());
  CHECK(easy.decks[0].marks.size() == 4);
  CHECK(easy.surroundings.spray == 0);
}

TEST_CASE("clutter is carried along with its deck") {
  for (int seed = 0; seed < draws; ++seed) {
    const Scenery scenery = draw_scenery({static_cast<std::uint64_t>(seed), false, 0.5});
    std::vector<Rigid> decks(3);
    decks[0].position_ned_m = {10, -4, -1};
    decks[0].ned_from_local = Eigen::AngleAxisd(1.2, Vector3d(0.1, 0.05, 1).normalized());
    decks[0].velocity_ned_mps = {1, 0, 0};
    const Scene scene = scenery.place(decks);
    CHECK(scene.buckets.size() == 4);
    if (scenery.clutter.at(0).tyres.empty()) continue;
    const Tyre& tyre = scene.tyres.at(0);
    const Vector3d before = scenery.clutter[0].tyres[0].rigid.position_ned_m;
    CHECK((tyre.rigid.position_ned_m - decks[0].to_ned(before)).norm() < 1e-12);
    CHECK(tyre.rigid.velocity_ned_mps.x() == 1);
    return;
  }
  FAIL("no scenery with a tyre");
}
