// What comes between the steps of the carrying: an operator, another pilot, silence, a restart.
#include <catch2/catch.hpp>
#include <map>

#include "mission_proc/carry_messages.hpp"
#include "tests/support/carry_bench.hpp"

using namespace stevedore;
using Catch::Contains;

namespace {

bool releases(const Bench& bench) {
  return bench.carry().action() == Action::release;
}

/// Goes up with a cargo on its hook.
void take_cargo(Bench& bench) {
  REQUIRE(bench.run_to(Phase::load));
  bench.run(1);
  bench.close();
  REQUIRE(bench.run_to(Phase::verify_load));
  bench.run(5);
}

/// Has let go of a cargo over its circle.
void drop_cargo(Bench& bench) {
  REQUIRE(bench.run_to(Phase::drop));
  bench.stands = true;
  REQUIRE(bench.run_to(Phase::verify_drop));
  bench.stands = false;
}

}  // namespace

TEST_CASE("carry: whoever comes between while a cargo is lifted, it is held") {
  Bench bench(false);
  take_cargo(bench);
  bool let_go = false;
  const auto watch = [&] {
    let_go = let_go || releases(bench);
    return false;
  };
  SECTION("the operator's hold") {
    bench.told().hold();
    bench.run_until(watch, 2);
    CHECK(bench.carry().reason() == "held by the operator");
    bench.told().resume();
  }
  SECTION("the battery") {
    bench.battery_share = 0.01;
  }
  SECTION("another pilot") {
    bench.guided = false;
    bench.run_until(watch, 2);
    CHECK_FALSE(bench.carry().setpoint());
    bench.guided = true;
    bench.run_until(watch, 1);
    bench.told().resume();
  }
  bench.run_until(watch, 5);
  CHECK_FALSE(let_go);
  CHECK(bench.carry().record().loaded);
  CHECK(bench.carry().record().taken.size() == 1);
}

TEST_CASE("carry: a cargo that was let go counts, whatever keeps it from being looked at") {
  Bench bench(true);
  drop_cargo(bench);
  SECTION("the operator") {
    bench.told().hold();
    bench.run(1);
    bench.told().resume();
  }
  SECTION("another pilot") {
    bench.guided = false;
    bench.run(1);
    bench.guided = true;
    bench.run(1);
    bench.told().resume();
  }
  bench.run(2);
  CHECK(bench.carry().record().delivered.size() == 1);
  CHECK(bench.carry().record().written_off == 0);
}

TEST_CASE("carry: killed after the jaws opened and before that was written down") {
  CarryRecord record = Bench::record(true);
  record.phase = Phase::drop;
  record.target = SlotId{1, 1};
  SECTION("the cargo is not thought to hang") {
    Bench bench(record);
    bench.told().hear(HookReport{0, false});
    CHECK(bench.carry().phase() == Phase::verify_drop);
    CHECK_FALSE(bench.carry().record().loaded);
  }
  SECTION("but where the jaws are closed it hangs") {
    Bench bench(record);
    bench.told().hear(HookReport{15, true});
    CHECK(bench.carry().phase() == Phase::retry);
    bench.told().hear(HookReport{0, false});
    CHECK(bench.carry().phase() == Phase::retry);
  }
}

TEST_CASE("carry: a platform whose circles are forgotten keeps nobody, and the climb ends") {
  Bench bench(true);
  drop_cargo(bench);
  bench.circles_known = false;
  double highest_m = 0;
  CHECK(bench.run_until(
      [&] {
        highest_m = std::max(highest_m, bench.height_m());
        return bench.carry().phase() != Phase::verify_drop;
      },
      25));
  CHECK(highest_m < 8);
}

TEST_CASE("carry: a hook that tells nothing lowers, takes and lets go nothing") {
  SECTION("on the way down") {
    Bench bench(false);
    REQUIRE(bench.run_to(Phase::descend));
    bench.hook_tells = false;
    CHECK(bench.run_until([&] { return bench.carry().phase() == Phase::retry; }, 2));
    CHECK_THAT(bench.carry().reason(), Contains("hook tells nothing"));
  }
  SECTION("at the handle: what the jaws may have taken is left there") {
    Bench bench(false);
    REQUIRE(bench.run_to(Phase::load));
    bench.hook_tells = false;
    REQUIRE(bench.run_until([&] { return bench.carry().phase() == Phase::retry; }, 2));
    bench.run(0.1);
    CHECK(releases(bench));
  }
  SECTION("with a cargo it is neither lost nor let go, and felt again later") {
    Bench bench(true);
    REQUIRE(bench.run_to(Phase::descend));
    bench.hook_tells = false;
    bench.run(10);
    CHECK(bench.carry().record().loaded);
    CHECK_FALSE(releases(bench));
    bench.hook_tells = true;
    CHECK(bench.run_to(Phase::drop));
  }
}

TEST_CASE("carry: no set-point where the autopilot's mode is not known") {
  Bench bench(false);
  REQUIRE(bench.run_to(Phase::approach));
  bench.autopilot_tells = false;
  REQUIRE(bench.run_until([&] { return bench.carry().phase() == Phase::suspended; }, 3.2));
  bench.run(0.1);
  CHECK_FALSE(bench.carry().setpoint());
  CHECK_THAT(bench.carry().reason(), Contains("not known"));
}

TEST_CASE("carry: nothing starts before the autopilot tells that it obeys") {
  CarryRecord on_ground = Bench::record(false);
  on_ground.phase = Phase::idle;
  Bench bench(on_ground);
  const bool tells = GENERATE(false, true);  // nothing at all; that somebody else flies
  bench.autopilot_tells = tells;
  bench.guided = false;
  bench.run(1);
  bench.told().start();
  bench.run(1);
  CHECK(bench.carry().phase() == Phase::idle);
  CHECK_FALSE(bench.carry().setpoint());
  CHECK_THAT(bench.carry().reason(), Contains("not started"));
  bench.autopilot_tells = bench.guided = true;
  CHECK(bench.run_to(Phase::take_off));
}

TEST_CASE("carry: a clock that is set back moves nobody") {
  Bench bench(false);
  REQUIRE(bench.run_to(Phase::approach));
  bench.gps_off_m = {4, 0, 0};  // the place that is told wanders off from the velocities' sum
  bench.run(1);
  bench.told().hold();
  bench.run(1);
  const Eigen::Vector2d before_m = bench.place_m();
  bench.set_back(GENERATE(5.0, 600.0));
  bench.run(5);
  CHECK((bench.place_m() - before_m).norm() < 0.5);
  bench.told().resume();
  CHECK(bench.run_to(Phase::descend));
  CHECK(bench.height_m() < 12);
}

TEST_CASE("carry: an abort on the ground, or of the mission before, turns no mission back") {
  CarryRecord on_ground = Bench::record(false);
  on_ground.phase = Phase::idle;
  SECTION("told while idle") {
    Bench bench(on_ground);
    bench.told().abort();
    REQUIRE(bench.run_to(Phase::take_off));
    bench.told().hold();
    bench.told().resume();
    CHECK(bench.carry().phase() == Phase::search);
  }
  SECTION("of the mission before") {
    on_ground.homeward = true;
    Bench bench(on_ground);
    REQUIRE(bench.run_to(Phase::take_off));
    bench.told().hold();
    bench.told().resume();
    CHECK(bench.carry().phase() == Phase::search);
  }
}

TEST_CASE("carry: after a restart the heading is kept") {
  CarryRecord record = Bench::record(false);
  record.phase = Phase::hold;
  Bench bench(record);
  bench.turn_to(1.5);
  bench.run(1);
  CHECK(bench.heading_rad() == Approx(1.5).margin(0.01));
}

TEST_CASE("carry: what a laser contradicted is over when it tells nothing") {
  Bench bench(false);
  REQUIRE(bench.run_to(Phase::approach));
  bench.push_to_middle();
  bench.run(5);
  bench.laser_off_m = 0.8;
  REQUIRE(bench.seconds_until(Emergency::altitude_disagrees, true, 10));
  bench.laser_tells = false;
  const auto over_s = bench.seconds_until(Emergency::altitude_disagrees, false, 10);
  REQUIRE(over_s);
  CHECK(*over_s < 1.5);
}

TEST_CASE("carry: a circle wished for is kept while a cargo is fetched for it") {
  Bench bench(false);
  bench.told().wish({1, 3});
  bench.told().wish({-1, -1});  // names no circle: the one before stands
  take_cargo(bench);
  REQUIRE(bench.run_until([&] { return bench.carry().record().loaded; }, 40));
  REQUIRE(bench.run_to(Phase::approach));
  CHECK(bench.carry().record().target == SlotId{1, 3});
}

TEST_CASE("carry: circles that get other numbers keep what was done in them") {
  CarryRecord record = Bench::record(true);
  record.delivered = {{{1, 2}, 0.1}};
  record.taken = {{0, 3}};
  record.failures = {{{1, 3}, 2}, {{0, 1}, 1}};
  Bench bench(record);
  bench.told().wish({1, 1});
  bench.run(1);
  const bool forgotten_between = GENERATE(false, true);
  if (forgotten_between) {
    bench.circles_known = false;
    bench.run(1);
    bench.circles_known = true;
  }
  const auto number = bench.carry().record_number();
  bench.renumbered = 1;
  bench.run(0.2);
  CHECK(bench.carry().record().delivered.front().slot == SlotId{1, 1});
  CHECK(bench.carry().record().taken.front() == SlotId{0, 2});
  CHECK(bench.carry().record().failures == std::map<SlotId, int>{{{1, 2}, 2}, {{0, 0}, 1}});
  CHECK(bench.carry().record_number() > number);
  REQUIRE(bench.run_to(Phase::approach));
  CHECK(bench.carry().record().target == SlotId{1, 0});  // the wish, under its new number
}

TEST_CASE("carry: the set-point that is told with a frame is that of the frame's time") {
  Bench bench(false);
  REQUIRE(bench.run_to(Phase::descend));
  bench.run(1);
  const auto setpoint = bench.carry().setpoint().value();
  REQUIRE(setpoint.velocity_ned_mps.norm() > 0.2);
  constexpr double before_s = 0.06;
  mission_t told{};
  describe(bench.carry(), bench.carry().utime() - static_cast<std::int64_t>(before_s * 1e6), told);
  const Eigen::Map<const Eigen::Vector3d> place_m(told.setpoint_ned_m);
  CHECK((place_m + before_s * setpoint.velocity_ned_mps - setpoint.position_ned_m).norm() < 1e-9);
}

TEST_CASE("carry: a deck that is found elsewhere than it was thought to be keeps its numbers") {
  CarryRecord record = Bench::record(true);
  record.delivered = {{{1, 2}, 0.1}, {{1, 3}, 0.1}};
  Bench bench(record);
  bench.run(1);
  bench.decks_off_m = {2, 0, 0};  // as far as two circles are apart
  bench.run(1);
  CHECK(bench.carry().record().delivered[0].slot == SlotId{1, 2});
  CHECK(bench.carry().record().delivered[1].slot == SlotId{1, 3});
}

TEST_CASE("carry: a platform that is never found is not looked for until the battery is empty") {
  Bench bench(false);
  bench.in_view = false;
  REQUIRE(bench.run_until([&] { return bench.carry().phase() == Phase::go_home; }, 250));
  CHECK_THAT(bench.carry().reason(), Contains("search took more than"));
}

TEST_CASE("carry: a gap in what the aircraft tells makes no swing") {
  Hanging hanging(CarrySettings{});
  const auto hear = [&](double time_s, double speed_mps) {
    hanging.hear(sample(time_s, {0, 0, 0}, {speed_mps, 0, 0}), false);
  };
  hear(10, 0);
  for (int k = 1; k < 25; ++k) hear(10 + 0.02 * k, 0.01 * k);  // it swings a little
  const double swung_m = hanging.swing_ned_m().norm();
  REQUIRE(swung_m > 0.005);
  SECTION("a gap") {
    hear(11.3, 0.25);
    CHECK(hanging.swing_ned_m().norm() < 0.1);
    for (int k = 1; k < 50; ++k) hear(11.3 + 0.02 * k, 0.25);
    CHECK(hanging.swing_ned_m().norm() < 0.1);
  }
  SECTION("one that comes late") {
    hear(10.3, 0);
    CHECK(hanging.swing_ned_m().norm() == swung_m);
  }
}
