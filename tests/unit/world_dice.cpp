#include "sim_proc/world/dice.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

using stevedore::world::Dice;

TEST_CASE("a stream depends on its seed and name alone, the same on every machine") {
  Dice wind(1, "wind"), waves(1, "waves"), other(2, "wind");
  // from a separate implementation of splitmix64 and FNV-1a
  CHECK(wind.next() == 18003052374921721777ULL);
  CHECK(wind.next() == 15041735233532973783ULL);
  CHECK(waves.next() == 14612720679978388645ULL);
  CHECK(other.next() == 12403849402162815428ULL);
}

TEST_CASE("dice keep their ranges and reach both ends of whole numbers") {
  Dice dice(3, "ranges");
  std::set<int> seen;
  for (int i = 0; i < 1000; ++i) {
    seen.insert(dice.whole(-1, 2));
    const double x = dice.uniform(2, 3);
    REQUIRE(x >= 2);
    REQUIRE(x < 3);
  }
  CHECK(seen == std::set{-1, 0, 1, 2});
}

TEST_CASE("means, deviations and chances are as asked for") {
  Dice dice(4, "moments");
  constexpr int draws = 20000;
  double sum = 0, squares = 0, middle = 0, hits = 0;
  for (int i = 0; i < draws; ++i) {
    const double x = dice.normal(2);
    sum += x;
    squares += x * x;
    middle += std::abs(x) < 2;
    hits += dice.chance(0.3);
  }
  // four standard errors
  CHECK(sum / draws == Approx(0).margin(4 * 2 / std::sqrt(draws)));
  CHECK(std::sqrt(squares / draws) == Approx(2).margin(4 * 2 / std::sqrt(2.0 * draws)));
  CHECK(middle / draws == Approx(0.6827).margin(4 * 0.47 / std::sqrt(draws)));
  CHECK(hits / draws == Approx(0.3).margin(4 * 0.46 / std::sqrt(draws)));
}
