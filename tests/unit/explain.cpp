#include "tools/explain_core.hpp"

#include "mission_proc/choice.hpp"
#include "runtime/command_line.hpp"
#include "tests/support/program.hpp"

using namespace stevedore;
using Catch::Contains;

namespace {

constexpr std::int64_t log_start_utime =
    1'700'000'000'000'000;  // a logger's clock is another one than the stamps'
constexpr std::int64_t start_utime = 50'000'000;

candidate_t circle(int slot, double cost, bool eligible, const std::string& reason) {
  candidate_t c{};
  c.track_id = -1;
  c.platform = 0;
  c.slot = static_cast<std::int16_t>(slot);
  c.label = ellipse_t::LABEL_CARGO;
  c.cost = cost;
  c.eligible = eligible;
  c.reason = reason;
  return c;
}

mission_t mission(int phase, const std::string& reason, std::vector<candidate_t> candidates) {
  mission_t m{};
  m.phase = static_cast<std::int8_t>(phase);
  m.action = mission_t::ACTION_GO_TO;
  m.target_id = m.target_platform = m.target_slot = -1;
  m.target_status = track_t::STATUS_TRACKING;
  m.target_age_s = -1;
  m.reason = reason;
  m.candidates = std::move(candidates);
  m.candidate_count = static_cast<std::int16_t>(m.candidates.size());
  return m;
}

/// A log with MISSIONs at these seconds of it, and something else at its start and at 10 s.
class Flight {
 public:
  Flight() : writer_(path()) { other(0); }
  void say(double log_s, const mission_t& m) { say(log_s, m, log_s); }
  void say(double log_s, mission_t m, double stamp_s) {
    m.header.utime = start_utime + std::llround(stamp_s * 1e6);
    m.phase_utime = m.header.utime - 500'000;
    REQUIRE_FALSE(fault_of(m));
    writer_.write(
        {log_start_utime + static_cast<std::int64_t>(log_s * 1e6), channels::mission.name, encode(m)});
  }
  void other(double log_s) {
    writer_.write({log_start_utime + static_cast<std::int64_t>(log_s * 1e6), "OTHER", {1, 2, 3}});
  }
  void unreadable(double log_s) {
    writer_.write(
        {log_start_utime + static_cast<std::int64_t>(log_s * 1e6), channels::mission.name, {1, 2, 3}});
  }
  [[nodiscard]] std::string path() const { return folder_.file("flight.lcm"); }
  Said at(const std::string& time) {
    writer_.flush();
    LogReader reader(path());
    return said_at(reader, parse_instant(time));
  }
  void flush() { writer_.flush(); }

 private:
  Folder folder_;
  LogWriter writer_;
};

void fly(Flight& flight) {
  auto weighed =
      std::vector{circle(0, 7.25, true, "a cargo stands in it: 7.2 m away"),
                  circle(2, 4.5, true, "a cargo stands in it: 4.0 m away, +0.5 (1 not empty beside it)"),
                  circle(3, 5, false, "no cargo stands in it: 5.0 m away")};
  flight.say(1, mission(mission_t::PHASE_SEARCH, "in the air", weighed));
  weighed[1].chosen = true;
  flight.say(2, mission(mission_t::PHASE_APPROACH, "loads from circle 2 of platform 0", weighed));
  mission_t later = mission(mission_t::PHASE_DESCEND, "aligned: goes down", weighed);
  later.target_platform = 0, later.target_slot = 2;
  emergency_t wrong{};
  wrong.kind = emergency_t::KIND_ALTITUDE_DISAGREES;
  wrong.cause = "laser 1.00 m";
  wrong.age_s = 1.5;
  wrong.confidence = 1;
  wrong.advised_action = mission_t::ACTION_CLIMB;
  later.emergencies = {wrong};
  later.emergency_count = 1;
  flight.say(5, later);
  flight.other(10);
}

}  // namespace

TEST_CASE("what was said last by an instant is explained, with the decision that led there") {
  Flight flight;
  fly(flight);
  const Said said = flight.at("6.5");
  CHECK(said.log_s == Approx(5));
  CHECK(said.before_s == Approx(1.5));
  REQUIRE(said.decision);
  CHECK(said.decision->log_s == Approx(2));
  const std::string text = explain(said);
  CHECK_THAT(text, Contains("phase:   descend for 0.5 s, action: go to"));
  CHECK_THAT(text, Contains("target:  circle 2 of platform 0"));
  CHECK_THAT(text, Contains("because: aligned: goes down"));
  CHECK_THAT(text, Contains("decided: at 2.00 s: loads from circle 2 of platform 0"));
  CHECK_THAT(text, Contains("wrong:   altitude disagrees, since 1.5 s: laser 1.00 m (advised: climb)"));
  CHECK_THAT(text, Contains("> circle 2 of platform 0   cost   4.50  chosen: a cargo stands in it: 4.0 m"));
  CHECK_THAT(text, Contains("circle 0 of platform 0   cost   7.25  not chosen: 2.75 dearer: a cargo"));
  CHECK_THAT(text, Contains("cannot be chosen: no cargo stands in it"));
  CHECK_THAT(text, Contains("when it was decided, 3.00 s earlier"));
}

TEST_CASE("a search has no decision yet, and ends the one before") {
  Flight flight;
  fly(flight);
  CHECK_FALSE(flight.at("1.5").decision);
  CHECK_THAT(explain(flight.at("1.5")), Contains("(weighed now)"));
  flight.say(11, mission(mission_t::PHASE_SEARCH, "clear", {}));
  flight.other(12);
  CHECK_FALSE(flight.at("11.5").decision);
  CHECK_THAT(explain(flight.at("11.5")), Contains("candidates: none was weighed"));
}

TEST_CASE("one circle alone, beside the one that was chosen") {
  Flight flight;
  fly(flight);
  const Said said = flight.at("3");
  const std::string why_not = explain_one(said, 0);
  CHECK_THAT(why_not, Contains("circle 0 of platform 0") && Contains("2.75 dearer") &&
                          Contains("instead:\n> circle 2"));
  CHECK_THAT(why_not, !Contains("circle 3"));
  CHECK_THAT(explain_one(said, 2), Contains("> circle 2") && !Contains("instead"));
  CHECK_THROWS_WITH(explain_one(said, 7), Contains("7 was not among") && Contains("they were: 0 2 3"));
  CHECK_THROWS_AS(explain_one(said, 7), NoAnswer);
}

TEST_CASE("candidates without slots go by their tracks") {
  candidate_t near = circle(-1, 2.5, true, "2.50 m away");
  near.platform = -1, near.track_id = 3, near.label = ellipse_t::LABEL_CIRCLE, near.chosen = true;
  candidate_t cut = near;
  cut.track_id = 4, cut.chosen = cut.eligible = false, cut.cost = 0, cut.reason = "only 40 % of its edge";
  Flight flight;
  flight.say(1, mission(mission_t::PHASE_APPROACH, "follows circle 3", {near, cut}));
  flight.other(2);
  CHECK_THAT(explain_one(flight.at("1"), 4),
             Contains("circle 4") && Contains("cost      -  cannot be chosen: only 40"));
}

TEST_CASE("an instant is in seconds of the log or a stamp of the messages") {
  Flight flight;
  fly(flight);
  CHECK(flight.at("utime:52000000").log_s == Approx(2));
  CHECK(flight.at("utime:54999999").log_s == Approx(2));
  CHECK(flight.at("utime:55000000").log_s == Approx(5));
  CHECK(flight.at("10").log_s == Approx(5));
  for (const char* bad : {"", "abc", "-1", "nan", "inf", "1s", "utime:", "utime:1.5", "utime:-3"}) {
    INFO(bad);
    CHECK_THROWS_AS(parse_instant(bad), UsageError);
  }
}

TEST_CASE("stamps that are not in the log's order: the newest by the instant is found") {
  const auto search = [](const char* reason) { return mission(mission_t::PHASE_SEARCH, reason, {}); };
  Flight flight;
  flight.say(1.00, search("a frame"));
  flight.say(1.01, mission(mission_t::PHASE_APPROACH, "the aircraft", {}), 1.05);
  flight.say(1.02, mission(mission_t::PHASE_APPROACH, "an older frame", {}), 1.03);
  const Said older = flight.at("utime:51040000");
  CHECK(older.mission.reason == "an older frame");
  CHECK(older.before_s == Approx(0.01));
  REQUIRE(older.decision);
  CHECK(older.decision->reason == "the aircraft");
  CHECK(flight.at("utime:51050000").mission.reason == "the aircraft");
  CHECK(flight.at("utime:51029999").mission.reason == "a frame");
  CHECK_THROWS_WITH(flight.at("utime:51050001"), Contains("its last MISSION utime:51050000"));
  CHECK_THROWS_WITH(flight.at("utime:50999999"),
                    Contains("before the first MISSION, which is utime:51000000"));
}

TEST_CASE("an instant outside the log is a mistake, a log without MISSION no answer") {
  Flight flight;
  fly(flight);
  CHECK_THROWS_AS(flight.at("10.1"), UsageError);
  CHECK_THROWS_WITH(flight.at("10.1"), Contains("10.00 s long") && Contains("utime:55000000"));
  CHECK_THROWS_AS(flight.at("utime:55000001"), UsageError);
  CHECK_THROWS_WITH(flight.at("utime:50999999"),
                    Contains("before the first MISSION, which is utime:51000000"));
  CHECK_THROWS_AS(flight.at("0.5"), NoAnswer);
  Flight silent;
  silent.other(5);
  CHECK_THROWS_AS(silent.at("1"), NoAnswer);
  CHECK_THROWS_WITH(silent.at("1"), Contains("no MISSION is by then") && Contains("mission_proc"));
  CHECK_THROWS_WITH(silent.at("utime:1"), Contains("no MISSION is in it"));
  silent.unreadable(6);
  CHECK_THROWS_WITH(silent.at("6"), Contains("1 are damaged or of another version"));
}

TEST_CASE("explain: exit statuses, and a damaged log is told of") {
  Flight flight;
  fly(flight);
  flight.flush();
  const auto good = run_program("$BIN/explain " + flight.path() + " 6.5 --why 2");
  CHECK(good.status == 0);
  CHECK_THAT(good.out, Contains("> circle 2"));
  CHECK(run_program("$BIN/explain " + flight.path() + " 6.5 --why 9").status == 1);
  CHECK(run_program("$BIN/explain " + flight.path() + " 99").status == 2);
  CHECK(run_program("$BIN/explain " + flight.path() + " soon").status == 2);
  CHECK(run_program("$BIN/explain /nowhere 1").status == 2);

  std::string bytes = text_of(flight.path());
  bytes.resize(bytes.size() - 5);
  std::ofstream(flight.path(), std::ios::binary) << bytes;
  const auto cut = run_program("$BIN/explain " + flight.path() + " 5");
  CHECK(cut.status == 1);
  CHECK_THAT(cut.out, Contains("because: aligned: goes down"));
  CHECK_THAT(cut.err, Contains("damaged at byte"));
}

TEST_CASE("the reason of a slot has every part of its cost") {
  DeckNews news;
  news.utime = 10'000'000;
  news.knots.push_back(
      {0, Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), -Eigen::Vector3d::UnitZ(), true});
  for (int i = 0; i < 3; ++i) {
    SlotReport slot;
    slot.center_ned_m = {3, 2.0 * i, 0};
    slot.condition = i < 2 ? SlotCondition::occupied : SlotCondition::empty;
    slot.confidence = 0.9;
    slot.seen_utime = 9'000'000;
    news.slots.push_back(slot);
  }
  const DeckPath deck(news,
                      {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(), Eigen::Quaterniond::Identity()});
  ChoiceInputs inputs;
  inputs.deck = &deck;
  inputs.utime = news.utime;
  inputs.hook_odometry_m = {0, 0};
  inputs.failures = {2, 0, 0};
  const auto slots = weigh_slots(inputs);
  REQUIRE(slots.size() == 3);
  // 3 m of way + 6 m for two failures + 0.5 m for its neighbour + 0.2 m a second + 2 m x 0.1
  CHECK(slots[0].cost == Approx(9.9));
  CHECK(slots[0].reason ==
        "a cargo stands in it: 3.0 m away, +6.0 (2 failures), +0.5 (1 not empty beside it), +0.2 (seen 1.0 s "
        "ago), "
        "+0.2 (90 % sure)");
  CHECK(slots[1].chosen);
  CHECK(slots[2].reason.starts_with("no cargo stands in it: 5.0 m away, "));
  CHECK_FALSE(slots[2].eligible);
}
