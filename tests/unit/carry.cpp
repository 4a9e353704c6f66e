// The carrying of cargoes on an aircraft that does what it is told: what is decided near the handle and the
// deck.
#include "mission_proc/carry.hpp"

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <optional>

#include "mission_proc/carry_messages.hpp"
#include "mission_proc/hanging.hpp"
#include "tests/support/carry_bench.hpp"

using namespace stevedore;
using Catch::Contains;

TEST_CASE("carry: the swing of a rope whose upper end is pulled along is reckoned to three centimetres") {
  const bool loaded = GENERATE(false, true);
  CarrySettings settings;
  settings.hook_down_m = 0;  // the upper end then does not move as the aircraft tilts
  Hanging hanging(settings);
  const double length_m = loaded ? 0.8 + 0.12 + 0.15 : 0.8;
  double top_m = 0, top_mps = 0, weight_m = 0, weight_mps = 0;
  double predicted_m = 0, largest_m = 0;
  for (int i = 0; i < 400; ++i) {
    const double time_s = 10 + i * step_s;
    const double pull_mps2 = i < 50 || i >= 80 ? 0 : i < 65 ? 1.5 : -1.5;  // to a place beside
    for (int fine = 0; fine < 100; ++fine) {  // a pendulum, without what makes it die out
      constexpr double fine_s = step_s / 100;
      top_mps += fine_s * pull_mps2;
      top_m += fine_s * top_mps;
      weight_mps += fine_s * gravity_mps2 / length_m * (top_m - weight_m);
      weight_m += fine_s * weight_mps;
    }
    const Eigen::Quaterniond leaning(
        Eigen::AngleAxisd(-std::atan(pull_mps2 / gravity_mps2), Eigen::Vector3d::UnitY()));
    hanging.hear(sample(time_s, {top_m, 0, 0}, {top_mps, 0, 0}, leaning), loaded);
    const double swing_m = 0.8 / length_m * (weight_m - top_m);
    largest_m = std::max(largest_m, std::abs(swing_m));
    if (i == 100) predicted_m = hanging.swing_ned_m(0.5).x();
    if (i == 125) CHECK(predicted_m == Approx(swing_m).margin(0.03));
    if (i >= 80 && i < 125) CHECK(hanging.swing_ned_m().x() == Approx(swing_m).margin(0.03));
  }
  CHECK(largest_m > 0.08);
}

TEST_CASE("carry: a cargo is let go where it touched, and lifted again when that was too far off") {
  Bench bench(true);
  REQUIRE(bench.run_to(Phase::drop));
  bench.push_m = {0.15, 0, 0};
  bool let_go = false;
  REQUIRE(bench.run_until([&] { return bench.beside_target_m().norm() > 0.14; }, 10));
  bench.stands = true;
  bench.step();
  bench.push_m.setZero();  // the aircraft goes back, and the cargo stays on its slack rope
  REQUIRE(bench.run_until(
      [&] {
        let_go |= bench.carry().action() == Action::release;
        return bench.carry().phase() == Phase::descend;
      },
      1));
  CHECK_FALSE(let_go);
  CHECK_THAT(bench.carry().reason(), Contains("goes up a little"));
  CHECK(bench.carry().record().failures.empty());
  // it hangs on the deck for a moment yet: not lost
  for (int i = 0; i < 50; ++i) bench.step();
  CHECK(bench.carry().phase() == Phase::descend);
  bench.stands = false;
  REQUIRE(bench.run_to(Phase::drop));
  REQUIRE(bench.run_until([&] { return bench.beside_target_m().norm() < 0.02; }, 10));
  bench.stands = true;
  REQUIRE(bench.run_until([&] { return bench.carry().phase() == Phase::verify_drop; }, 0.3));
  CHECK(bench.carry().record().loaded == false);
}

TEST_CASE("carry: a cargo that does not touch is not let go above the deck") {
  Bench bench(true);
  REQUIRE(bench.run_to(Phase::drop));
  REQUIRE(bench.run_until([&] { return bench.carry().action() == Action::release; }, 15));
  CHECK(bench.hook_over_goal_m() < -0.05);  // lower than what is known of the height allows
}

TEST_CASE("carry: jaws are told to close near the handle only, and to open when they have swung away") {
  Bench bench(false);
  REQUIRE(bench.run_to(Phase::load));
  const auto grabs = [&] { return bench.carry().action() == Action::grab; };
  REQUIRE(bench.run_until(grabs, 10));
  CHECK(bench.beside_target_m().norm() < 0.045);
  bench.push_m = {0, 0.25, 0};
  REQUIRE(bench.run_until([&] { return !grabs(); }, 3));
  CHECK(bench.carry().action() == Action::release);
  CHECK(bench.carry().phase() == Phase::load);
  bench.push_m.setZero();
  CHECK(bench.run_until(grabs, 10));
}

TEST_CASE("carry: where a cargo stands is told against the circles of its frame, whatever the camera leans") {
  Bench bench(false);
  bench.leans_rad = 0.04;
  for (int slot = 0; slot < 4; ++slot) bench.lone_circles_m.push_back(Bench::circle_m(0, slot));
  REQUIRE(bench.run_to(Phase::load));
  REQUIRE(bench.run_until([&] { return bench.carry().action() == Action::grab; }, 30));
  CHECK(bench.beside_target_m().norm() < 0.045);
}

TEST_CASE(
    "carry: a cargo is held low over its circle before it is taken away, and taken again when it slips off") {
  Bench bench(false);
  REQUIRE(bench.run_to(Phase::load));
  REQUIRE(bench.run_until([&] { return bench.carry().action() == Action::grab; }, 10));
  bench.close();
  REQUIRE(bench.run_to(Phase::verify_load));
  double highest_m = 0;
  const auto watched = [&](Phase phase) {
    highest_m = std::max(highest_m, bench.hook_over_goal_m());
    return bench.carry().phase() == phase;
  };
  CHECK_FALSE(bench.run_until([&] { return watched(Phase::transit); }, 14));
  CHECK(highest_m > 0.2);
  CHECK(highest_m < 0.35);
  bench.stands = true;  // it fell off
  REQUIRE(bench.run_until([&] { return bench.carry().phase() == Phase::retry; }, 2));
  CHECK(bench.carry().record().written_off == 0);
  CHECK(bench.carry().record().failures.size() == 1);
  bench.stands = false;
  REQUIRE(bench.run_until([&] { return bench.carry().action() == Action::grab; }));
  bench.close();
  REQUIRE(bench.run_to(Phase::verify_load));
  CHECK(bench.run_until([&] { return bench.carry().phase() == Phase::transit; }, 30));
}

TEST_CASE("carry: where a cargo came to stand tells where the hook hangs") {
  Bench bench(true);
  REQUIRE(bench.run_to(Phase::drop));
  REQUIRE(bench.run_until([&] { return std::abs(bench.hook_over_goal_m()) < 0.02; }, 10));
  bench.stands = true;
  bench.put_m = {0.06, 0};  // it was set down over the middle, and stands 6 cm north of it
  REQUIRE(bench.run_to(Phase::transit));
  REQUIRE(bench.run_to(Phase::approach));  // over a cargo that lies as far north
  REQUIRE(bench.run_to(Phase::descend));
  for (int i = 0; i < 50; ++i) bench.step();
  const double from_cargo_m = (bench.beside_target_m() - bench.put_m).norm();
  CHECK(from_cargo_m > 0.015);  // half of 6 cm is believed, to the 3 cm that a swing is known to here
  CHECK(from_cargo_m < 0.06);
  // and the journal tells it to a mission that goes on after a restart
  const CarryRecord& record = bench.carry().record();
  CHECK(record.hook_off_m.norm() > 0.015);
  const CarryRecord restored = from_message(to_message(record));
  CHECK(restored.hook_off_m == record.hook_off_m);
  CHECK(restored.hook_lessons == 1);
  CarryRecord with_taken = record;
  with_taken.taken = {{0, 3}, {0, 1}};
  CHECK(from_message(to_message(with_taken)).taken == with_taken.taken);
}

TEST_CASE("carry: what was chosen before counts when the platform comes into view again") {
  Bench bench(false);
  REQUIRE(bench.run_to(Phase::approach));
  const SlotId before = bench.carry().record().target.value();
  bench.in_view = false;
  REQUIRE(bench.run_to(Phase::search));
  bench.in_view = true;
  REQUIRE(bench.run_to(Phase::approach));
  CHECK(bench.carry().record().target == before);
  CHECK_THAT(bench.carry().reason(), Contains("chosen before"));
}

TEST_CASE(
    "carry: a search goes where circles are seen, and on after ten seconds in which they make no platform") {
  Bench bench(false);
  REQUIRE(bench.run_to(Phase::approach));
  const SlotId target = bench.carry().record().target.value();
  bench.in_view = false;
  REQUIRE(bench.run_to(Phase::search));
  const Eigen::Vector2d circles_m = Eigen::Vector2d(10.0 * target.platform, 7);
  bench.lone_circles_m = {{circles_m.x() - 1, circles_m.y(), 0}, {circles_m.x() + 1, circles_m.y(), 0}};
  const auto away_m = [&] { return (bench.camera_m() - circles_m).norm(); };
  CHECK(bench.run_until([&] { return away_m() < 0.3; }, 8));
  bench.run_until([] { return false; }, 2);
  CHECK(away_m() < 0.3);
  CHECK(bench.run_until([&] { return away_m() > 3; }, 15));
}

TEST_CASE("carry: emergencies are told within their delays, and over when their causes are") {
  // at most as long: the delay of the board, and of what is looked at ten times a second
  struct Provoked {
    Emergency kind;
    Phase phase;
    bool loaded;
    std::function<void(Bench&, bool)> cause;
    double earliest_s, latest_s, over_latest_s;
  };
  const CarrySettings defaults;
  const auto provoked = GENERATE_REF(values<Provoked>({
      {Emergency::platform_not_found, Phase::search, false, [](Bench& b, bool on) { b.in_view = !on; }, 29.5,
       30.5, 0.3},
      {Emergency::target_lost, Phase::approach, false, [](Bench& b, bool on) { b.in_view = !on; },
       defaults.oldest_s - 0.2, defaults.oldest_s + 0.2, 0.6},
      {Emergency::identity_uncertain, Phase::approach, false,
       [](Bench& b, bool on) { b.numbers_certain = !on; }, 1, 1.3, 1.3},
      {Emergency::camera_frozen, Phase::approach, false, [](Bench& b, bool on) { b.frozen = on; }, 0.4, 0.8,
       0.3},
      {Emergency::cargo_lost, Phase::approach, true, [](Bench& b, bool on) { b.stands = on; }, 0.4, 0.7,
       10.3},
  }));
  CAPTURE(static_cast<int>(provoked.kind));
  Bench bench(provoked.loaded);
  if (provoked.phase == Phase::search) bench.in_view = false;
  REQUIRE(bench.run_to(provoked.phase));
  CHECK_FALSE(bench.raised(provoked.kind));
  provoked.cause(bench, true);
  const auto after_s = bench.seconds_until(provoked.kind, true, 60);
  REQUIRE(after_s);
  CHECK(*after_s >= provoked.earliest_s);
  CHECK(*after_s <= provoked.latest_s);
  provoked.cause(bench, false);
  const auto over_after_s = bench.seconds_until(provoked.kind, false, 60);
  REQUIRE(over_after_s);
  CHECK(*over_after_s <= provoked.over_latest_s);
}

TEST_CASE(
    "carry: a laser that contradicts vision over the deck is told, and over when it does not any more") {
  Bench bench(false);
  REQUIRE(bench.run_to(Phase::approach));
  bench.push_to_middle();
  for (int i = 0; i < 250; ++i) bench.step();
  CHECK_FALSE(bench.raised(Emergency::altitude_disagrees));
  bench.laser_off_m = 0.8;
  const auto after_s = bench.seconds_until(Emergency::altitude_disagrees, true, 10);
  REQUIRE(after_s);
  CHECK(*after_s >= 1);
  CHECK(*after_s < 1.2);
  double latest_s = 1.2;
  SECTION("when it agrees") {
    bench.laser_off_m = 0;
  }
  SECTION("when there is nothing any more that it could contradict") {
    bench.in_view = false;
    latest_s = 1.6;  // 0.3 s later: for so long what was seen last counts
  }
  const auto over_after_s = bench.seconds_until(Emergency::altitude_disagrees, false, 10);
  REQUIRE(over_after_s);
  CHECK(*over_after_s < latest_s);
}

TEST_CASE("carry: when there is nothing to choose each circle is looked at from nearer by") {
  Bench bench(false);
  SECTION("a cargo that is told from there only is taken") {
    bench.told_within_m = 3;
    CHECK(bench.run_until([&] { return bench.carry().phase() == Phase::approach; }, 45));
  }
  SECTION("it goes home when all of them are empty, having been over each") {
    bench.all_empty = true;
    std::array<bool, 4> seen{};
    const auto looks_closely = [&] {
      for (std::size_t k = 0; k < 4; ++k) {
        const Eigen::Vector2d circle_m(k < 2 ? 1.0 : -1.0, k % 2 == 0 ? 1.0 : -1.0);
        const bool is_low = bench.camera_height_m() < 2.3;
        seen[k] = seen[k] || (is_low && (bench.camera_m() - circle_m).norm() < 0.3);
      }
      return bench.carry().phase() == Phase::go_home;
    };
    CHECK(bench.run_until(looks_closely, 60));
    CHECK(std::all_of(seen.begin(), seen.end(), [](bool s) { return s; }));
  }
}

TEST_CASE("carry: where every circle looks occupied one is taken at last that nobody brought a cargo to") {
  CarryRecord record = Bench::record(true);
  record.delivered = {{{1, 0}, 0.1}, {{1, 2}, 0.1}};
  SECTION("there is one") {
    Bench bench(record);
    bench.none_free = true;
    REQUIRE(bench.run_to(Phase::approach));
    const SlotId target = bench.carry().record().target.value();
    CHECK(target.platform == 1);
    CHECK((target.slot == 1 || target.slot == 3));
    CHECK_THAT(bench.carry().reason(), Contains("no circle is told free"));
  }
  SECTION("also one that looks free is none when a cargo was brought there") {
    record.delivered.push_back({{1, 1}, 0.1});
    Bench bench(record);
    REQUIRE(bench.run_to(Phase::approach));
    CHECK(bench.carry().record().target == SlotId{1, 3});
  }
  SECTION("there is none") {
    record.delivered.push_back({{1, 1}, 0.1});
    record.delivered.push_back({{1, 3}, 0.1});
    Bench bench(record);
    bench.none_free = true;
    REQUIRE(bench.run_to(Phase::go_home));
    CHECK_THAT(bench.carry().reason(), Contains("no free circle"));
  }
}

TEST_CASE("carry: a cargo that nobody sees is felt for in the circle that none was taken from") {
  CarryRecord record = Bench::record(false);
  record.taken = {{0, 0}, {0, 1}, {0, 3}};
  Bench bench(record);
  bench.all_empty = true;
  REQUIRE(bench.run_to(Phase::approach));
  CHECK(bench.carry().record().target == SlotId{0, 2});
  CHECK_THAT(bench.carry().reason(), Contains("nobody took it away"));
  REQUIRE(bench.run_to(Phase::load));
  double widest_m = 0;
  CHECK_FALSE(bench.run_until(
      [&] {
        widest_m = std::max(widest_m, bench.beside_target_m().norm());
        return bench.carry().phase() != Phase::load;
      },
      38));
  CHECK(widest_m > 0.17);
  // after two times in vain it is left alone
  REQUIRE(bench.run_until([&] { return bench.carry().phase() == Phase::go_home; }, 300));
  CHECK(bench.carry().record().failures.at({0, 2}) == 2);
}

TEST_CASE("carry: a platform that tells its height wrongly is not looked for under the ground") {
  Bench bench(true);
  bench.second_told_low_m = 6;
  double lowest_m = 1e9;
  CHECK_FALSE(bench.run_until(
      [&] {
        lowest_m = std::min(lowest_m, bench.camera_height_m());
        return false;
      },
      40));
  CHECK(bench.carry().phase() == Phase::search);
  CHECK(lowest_m > 4);
}

TEST_CASE("carry: a circle that is seen once on the way home is not the pad for good") {
  CarryRecord homeward = Bench::record(false);
  homeward.phase = Phase::go_home;
  homeward.homeward = true;
  homeward.home_ned_m = {4, 20, -0.5};
  Bench bench(homeward);
  const Eigen::Vector3d pad_m(4.5, 20.3, 0), false_m(8, 20, 0);
  REQUIRE(bench.run_until([&] { return (bench.place_m() - pad_m.head<2>()).norm() < 6; }));
  SECTION("it is given up when another one is there") {
    bench.lone_circles_m = {false_m};
    for (int k = 0; k < 5; ++k) bench.step();
    bench.lone_circles_m = {pad_m};
    REQUIRE(bench.run_to(Phase::land));
    CHECK((bench.place_m() - pad_m.head<2>()).norm() < 0.4);
  }
  SECTION("a piece of an edge, taken for a whole circle far below, never is the pad") {
    bench.lone_circles_m = {{4, 16, 6}};
    REQUIRE(bench.run_to(Phase::land));
    CHECK((bench.place_m() - homeward.home_ned_m.head<2>()).norm() < 1);
  }
}

TEST_CASE("carry: a cargo's place is the mean of what was seen, doubtful sights hardly counting") {
  CargoPlaces places;
  const SlotId slot{0, 1};
  for (int i = 0; i < 30; ++i) places.see(slot, {0.1, 0}, 1e-4);
  for (int i = 0; i < 30; ++i) places.see(slot, {0.3, 0}, 0.08 * 0.08);  // cut by the border
  CHECK(places.at(slot)->offset_m.x() == Approx(0.1).margin(0.02));
  for (int i = 0; i < 100; ++i) places.see(slot, {0.2, 0.1}, 4e-4);  // it was pushed
  CHECK((places.at(slot)->offset_m - Eigen::Vector2d(0.2, 0.1)).norm() < 0.04);
}
