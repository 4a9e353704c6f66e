#include "mission_proc/mission.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <numbers>

using namespace stevedore;

namespace {

Mark circle(int64_t id, double semi_major_px, std::optional<double> range_m = std::nullopt) {
  Mark mark;
  mark.track_id = id;
  mark.label = Label::circle;
  mark.measured = true;
  mark.center_px = {100.0 * static_cast<double>(id), 50};
  mark.semi_major_px = semi_major_px;
  mark.coverage = 0.9;
  mark.age_frames = 10;
  mark.range_m = range_m;
  return mark;
}

View view(double time_s, std::vector<Mark> marks, std::optional<int64_t> target = std::nullopt,
          TargetStatus status = TargetStatus::searching) {
  return {time_s, std::move(marks), target, status};
}

CameraHold level(double time_s, double off_level_deg, GimbalCondition gimbal = GimbalCondition::ok) {
  return {time_s, off_level_deg * std::numbers::pi / 180, gimbal};
}

std::string cause_of(const Mission& mission, Emergency kind) {
  for (const RaisedEmergency& e : mission.decision().emergencies) {
    if (e.kind == kind) return e.cause;
  }
  return {};
}

bool has(const Mission& mission, Emergency kind) {
  const auto& raised = mission.decision().emergencies;
  return std::any_of(raised.begin(), raised.end(),
                     [kind](const RaisedEmergency& e) { return e.kind == kind; });
}

}  // namespace

TEST_CASE("without metres the largest circle is wanted, with them the nearest") {
  Mission in_pixels{MissionSettings{}};
  in_pixels.see(view(10, {circle(1, 12), circle(2, 31), circle(3, 20)}));
  REQUIRE(in_pixels.decision().wanted);
  CHECK(in_pixels.decision().wanted->track_id == 2);
  CHECK(in_pixels.decision().wanted->last_seen_px.x() == 200);

  Mission in_metres{MissionSettings{}};
  in_metres.see(view(10, {circle(1, 12, 3.0), circle(2, 31, 4.0)}));
  CHECK(in_metres.decision().wanted->track_id == 1);
}

TEST_CASE("every candidate has its reason, and what is no good is not chosen") {
  Mark cargo = circle(1, 60), hidden = circle(2, 50), young = circle(3, 40), predicted = circle(4, 30);
  cargo.label = Label::cargo;
  hidden.coverage = 0.3;
  young.age_frames = 1;
  predicted.measured = false;
  Mission mission{MissionSettings{}};
  mission.see(view(10, {cargo, hidden, young, predicted}));
  CHECK_FALSE(mission.decision().wanted);
  CHECK(mission.decision().phase == Phase::search);
  REQUIRE(mission.decision().candidates.size() == 4);
  CHECK(mission.decision().candidates[0].reason == "is a cargo");
  CHECK(mission.decision().candidates[1].reason == "shows 30 % of its edge, 60 wanted");
  CHECK(mission.decision().candidates[2].reason == "followed for 1 frames, 3 wanted");
  CHECK(mission.decision().candidates[3].reason == "is only predicted");
  mission.see(view(10.1, {cargo, circle(5, 20)}));
  CHECK(mission.decision().wanted->track_id == 5);
  CHECK(mission.decision().candidates[1].chosen);
}

TEST_CASE("a target is kept though a better one comes, and given up only after a while") {
  Mission mission{MissionSettings{}};
  mission.see(view(10, {circle(1, 12)}));
  mission.see(view(10.1, {circle(1, 12), circle(2, 40)}, 1, TargetStatus::tracking));
  CHECK(mission.decision().wanted->track_id == 1);
  CHECK(mission.decision().phase == Phase::approach);
  mission.see(view(10.6, {circle(2, 40)}, 1, TargetStatus::predicted));
  CHECK(mission.decision().wanted->track_id == 1);
  CHECK_FALSE(has(mission, Emergency::target_lost));
  mission.see(view(11.2, {circle(2, 40)}, 1, TargetStatus::lost));
  CHECK(has(mission, Emergency::target_lost));
  mission.see(view(11.3, {circle(2, 40)}, 2, TargetStatus::tracking));
  CHECK(mission.decision().wanted->track_id == 2);
  CHECK_FALSE(has(mission, Emergency::target_lost));
}

TEST_CASE("a restarted tracker's new id is the same choice") {
  Mission mission{MissionSettings{}};
  mission.see(view(10, {circle(7, 12)}));
  const auto choice = mission.decision().wanted->choice;
  mission.see(view(11, {circle(7, 12)}, 7, TargetStatus::tracking));
  mission.see(view(11.1, {circle(1, 12)}));  // restarted: follows nothing yet
  mission.see(view(11.2, {circle(1, 12)}, 1, TargetStatus::tracking));
  CHECK(mission.decision().wanted->track_id == 1);
  CHECK(mission.decision().wanted->choice == choice);
}

TEST_CASE("a choice stands while the tracker still follows the one before") {
  Mission mission{MissionSettings{}};
  mission.see(view(10, {circle(3, 40), circle(5, 12)}, 3, TargetStatus::tracking));
  mission.choose(5);
  mission.see(view(12, {circle(3, 40), circle(5, 12)}, 3, TargetStatus::tracking));
  const auto choice = mission.decision().wanted->choice;
  mission.see(view(12.6, {circle(3, 40), circle(5, 12)}, 3, TargetStatus::tracking));  // the command was lost
  CHECK(mission.decision().wanted->track_id == 5);
  CHECK(mission.decision().wanted->choice == choice);
  CHECK(mission.decision().phase == Phase::search);
}

TEST_CASE("emergencies are raised with their delay and cleared when the cause goes") {
  Mission mission{MissionSettings{}};
  mission.tick(100);
  CHECK(mission.decision().emergencies.empty());
  mission.tick(100.6);
  CHECK(has(mission, Emergency::vision_stale));
  CHECK_FALSE(has(mission, Emergency::all_out_of_view));
  mission.see(view(100.7, {circle(1, 12)}));
  CHECK(mission.decision().emergencies.empty());
  for (double t = 100.8; t < 101.6; t += 0.1) mission.see(view(t, {}));
  CHECK(mission.decision().emergencies.empty());
  for (double t = 101.6; t < 102; t += 0.1) mission.see(view(t, {}));
  CHECK(has(mission, Emergency::all_out_of_view));
  CHECK_FALSE(has(mission, Emergency::vision_stale));
  mission.see(view(102, {circle(2, 12)}));
  CHECK_FALSE(has(mission, Emergency::all_out_of_view));
}

TEST_CASE("a camera off level for a while is an emergency, and over when it was level for a while") {
  Mission mission{MissionSettings{}};
  double t = 10;
  const auto hold = [&](double for_s, double off_level_deg, GimbalCondition gimbal = GimbalCondition::ok) {
    for (const double until = t + for_s; t < until; t += 0.02) mission.hear(level(t, off_level_deg, gimbal));
    return has(mission, Emergency::gimbal_not_level);
  };
  CHECK_FALSE(hold(2, 5.9));
  CHECK_FALSE(hold(0.48, 8));
  CHECK_FALSE(hold(0.1, 1));  // a swing that was over in time
  CHECK_FALSE(hold(0.48, 8));
  CHECK(hold(0.1, 8, GimbalCondition::at_limit));
  CHECK(cause_of(mission, Emergency::gimbal_not_level) ==
        "the camera is more than 6.0 deg off level: the pan-tilt is at its limit");
  CHECK(hold(0.9, 1));
  CHECK(hold(0.1, 8));
  CHECK(hold(0.9, 1));  // the time counts from the last fault
  CHECK_FALSE(hold(0.2, 1));
}

TEST_CASE("a stuck, late or silent gimbal is an emergency at once") {
  for (const auto gimbal : {GimbalCondition::stuck, GimbalCondition::late}) {
    Mission mission{MissionSettings{}};
    mission.hear(level(10, 0));
    mission.hear({10.02, std::nullopt, gimbal});
    CHECK(has(mission, Emergency::gimbal_not_level));
  }
  Mission without{MissionSettings{}}, with{MissionSettings{}};
  with.hear(level(10, 0));
  for (Mission* mission : {&without, &with}) {
    mission->tick(10.4);
    CHECK_FALSE(has(*mission, Emergency::gimbal_not_level));
    mission->tick(10.6);
  }
  CHECK_FALSE(has(without, Emergency::gimbal_not_level));  // an aircraft whose camera is fixed
  CHECK(cause_of(with, Emergency::gimbal_not_level) == "no GIMBAL_LEVEL for more than 0.5 s");
}

TEST_CASE("the operator chooses, holds, resumes and aborts") {
  Mission mission{MissionSettings{}};
  mission.hold();
  mission.see(view(10, {circle(1, 12), circle(2, 40)}));
  CHECK_FALSE(mission.decision().wanted);
  mission.choose(1);
  mission.see(view(10.1, {circle(1, 12), circle(2, 40)}));
  CHECK(mission.decision().wanted->track_id == 1);
  CHECK(mission.decision().phase == Phase::hold);
  mission.resume();
  mission.see(view(10.2, {circle(1, 12)}, 1, TargetStatus::tracking));
  CHECK(mission.decision().phase == Phase::approach);
  mission.abort();
  mission.see(view(10.3, {circle(1, 12)}, 1, TargetStatus::tracking));
  CHECK(mission.decision().phase == Phase::abort);
  CHECK_FALSE(mission.decision().wanted);
}

TEST_CASE("time that goes back starts the clock anew") {
  Mission mission{MissionSettings{}};
  mission.see(view(1000, {circle(1, 12)}));
  mission.tick(1002);
  CHECK(has(mission, Emergency::vision_stale));
  mission.see(view(10, {circle(1, 12)}));
  CHECK(mission.decision().emergencies.empty());
  mission.tick(10.6);
  CHECK(has(mission, Emergency::vision_stale));
}

TEST_CASE("vision that comes late stays stale") {
  Mission mission{MissionSettings{}};
  mission.see(view(100, {circle(1, 12)}));
  mission.tick(100.7);
  REQUIRE(has(mission, Emergency::vision_stale));
  mission.see(view(100.1, {circle(1, 12)}));
  CHECK(has(mission, Emergency::vision_stale));
  mission.see(view(100.5, {circle(1, 12)}));
  CHECK_FALSE(has(mission, Emergency::vision_stale));
}

TEST_CASE("an operator's choice that is not there does not stop the mission, and an abort forgets it") {
  Mission mission{MissionSettings{}};
  mission.choose(77);
  mission.see(view(10, {circle(1, 12)}));
  CHECK(mission.decision().wanted->track_id == 1);
  mission.abort();
  mission.see(view(10.1, {circle(77, 12)}));
  CHECK_FALSE(mission.decision().wanted);
  mission.choose(-1);
  CHECK(mission.decision().reason == "the operator's choice names no track");
}

TEST_CASE("a restarted mission does not repeat the numbers of its choices") {
  Mission first{MissionSettings{}}, second{MissionSettings{}};
  first.see(view(10, {circle(1, 12)}));
  second.see(view(11, {circle(2, 12)}));
  CHECK(second.decision().wanted->choice != first.decision().wanted->choice);
}

TEST_CASE("a target is not approached while vision is stale") {
  Mission mission{MissionSettings{}};
  mission.see(view(10, {circle(1, 12)}));
  mission.see(view(10.1, {circle(1, 12)}, 1, TargetStatus::tracking));
  REQUIRE(mission.decision().phase == Phase::approach);
  mission.tick(10.5);
  CHECK(mission.decision().phase == Phase::approach);
  mission.tick(10.7);
  CHECK(has(mission, Emergency::vision_stale));
  CHECK(mission.decision().phase == Phase::search);
  mission.see(view(10.8, {circle(1, 12)}, 1, TargetStatus::tracking));
  CHECK(mission.decision().phase == Phase::approach);
}
