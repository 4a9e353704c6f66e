// Every stage's code over the golden log gives what the recorded processes gave. Payloads are equal to the
// bit with the compiler that recorded it; other compilers and the sanitizers' builds round differently, hence
// the tolerances.
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <string>
#include <vector>

#include "geometry/ellipse.hpp"
#include "runtime/event_log.hpp"
#include "tests/support/film.hpp"
#include "tools/replay_core.hpp"

using namespace stevedore;

namespace {

const std::string golden_log = std::string(STEVEDORE_SOURCE_DIR) + "/logs/film.lcm";
const std::string config_file = std::string(STEVEDORE_SOURCE_DIR) + "/config/film.yaml";

// Rounding moves an edge pixel now and then, never an ellipse: a hundredth of the detector's noise on this
// film.
constexpr double tolerance_px = 0.01;
constexpr double tolerance_m = 0.001;

template <class M>
std::map<int64_t, M> messages(const std::vector<LogEvent>& events, const Channel<M>& channel) {
  std::map<int64_t, M> by_seq;
  for (const LogEvent& event : events) {
    if (const auto message = decode(event, channel)) by_seq[message->header.seq] = *message;
  }
  return by_seq;
}

std::vector<LogEvent> read(const std::string& path) {
  LogReader reader(path);
  std::vector<LogEvent> events;
  while (auto event = reader.next()) events.push_back(*std::move(event));
  return events;
}

std::vector<LogEvent> replayed(ReplayMode mode, std::set<std::string> stages,
                               ReplayResult* result = nullptr) {
  ReplayOptions options;
  options.mode = mode;
  options.stages = std::move(stages);
  options.config = Config::load(config_file);
  std::vector<LogEvent> events;
  const auto outcome =
      replay(golden_log, options, [&events](const LogEvent& event) { events.push_back(event); });
  if (result) *result = outcome;
  return events;
}

}  // namespace

TEST_CASE("detector: the golden log's ellipses") {
  const auto was = messages(read(golden_log), channels::ellipses);
  const auto is = messages(replayed(ReplayMode::as_flown, {"detector_proc"}), channels::ellipses);
  REQUIRE(was.size() > 40);
  REQUIRE(is.size() == was.size());
  for (const auto& [seq, expected] : was) {
    const auto& got = is.at(seq);
    REQUIRE(got.ellipses.size() == expected.ellipses.size());
    for (size_t i = 0; i < got.ellipses.size(); ++i) {
      const auto &a = got.ellipses[i].outer, &b = expected.ellipses[i].outer;
      CHECK(std::hypot(a.u_px - b.u_px, a.v_px - b.v_px) < tolerance_px);
      CHECK(std::abs(a.a_px - b.a_px) < tolerance_px);
      CHECK(std::abs(a.b_px - b.b_px) < tolerance_px);
      CHECK(got.ellipses[i].label == expected.ellipses[i].label);
    }
  }
}

TEST_CASE("tracker: the golden log's ids and target") {
  const auto was = messages(read(golden_log), channels::tracks);
  const auto is = messages(replayed(ReplayMode::as_flown, {"tracker_proc"}), channels::tracks);
  REQUIRE(was.size() > 40);
  REQUIRE(is.size() == was.size());
  for (const auto& [seq, expected] : was) {
    const auto& got = is.at(seq);
    CHECK(got.target_id == expected.target_id);
    CHECK(got.target_status == expected.target_status);
    REQUIRE(got.tracks.size() == expected.tracks.size());
    for (size_t i = 0; i < got.tracks.size(); ++i) CHECK(got.tracks[i].id == expected.tracks[i].id);
  }
}

TEST_CASE("pose: the golden log's centres") {
  const auto was = messages(read(golden_log), channels::poses);
  const auto is = messages(replayed(ReplayMode::as_flown, {"pose_proc"}), channels::poses);
  REQUIRE(was.size() > 40);
  REQUIRE(is.size() == was.size());
  int solutions = 0;
  for (const auto& [seq, expected] : was) {
    const auto& got = is.at(seq);
    REQUIRE(got.poses.size() == expected.poses.size());
    for (size_t i = 0; i < got.poses.size(); ++i) {
      REQUIRE(got.poses[i].solutions.size() == expected.poses[i].solutions.size());
      CHECK(got.poses[i].chosen_by == expected.poses[i].chosen_by);
      for (size_t s = 0; s < got.poses[i].solutions.size(); ++s, ++solutions) {
        for (int axis = 0; axis < 3; ++axis) {
          CHECK(std::abs(got.poses[i].solutions[s].center_camera_m[axis] -
                         expected.poses[i].solutions[s].center_camera_m[axis]) < tolerance_m);
        }
      }
    }
  }
  CHECK(solutions > 100);
}

TEST_CASE("mission: the golden log's decisions") {
  const auto was = messages(read(golden_log), channels::mission);
  const auto is = messages(replayed(ReplayMode::as_flown, {"mission_proc"}), channels::mission);
  REQUIRE(was.size() > 40);
  REQUIRE(is.size() == was.size());
  for (const auto& [seq, expected] : was) {
    const auto& got = is.at(seq);
    CHECK(got.phase == expected.phase);
    CHECK(got.target_id == expected.target_id);
    CHECK(got.reason == expected.reason);
    CHECK(got.emergencies.size() == expected.emergencies.size());
    CHECK(got.circles_in_view == expected.circles_in_view);
  }
}

TEST_CASE("the whole line as flown answers every frame, twice the same to the byte") {
  ReplayResult result;
  const auto once = replayed(ReplayMode::as_flown, ReplayOptions{}.stages, &result);
  const auto twice = replayed(ReplayMode::as_flown, ReplayOptions{}.stages);
  CHECK(result.missing_inputs == 0);
  REQUIRE(once.size() == twice.size());
  for (size_t i = 0; i < once.size(); ++i) CHECK(once[i].bytes == twice[i].bytes);
  for (const char* channel : {"ELLIPSES", "TRACKS", "POSES", "MISSION"}) {
    CHECK(result.channels.at(channel).equal + result.channels.at(channel).different > 40);
    CHECK(result.channels.at(channel).only_logged == 0);
    CHECK(result.channels.at(channel).only_replayed == 0);
  }
}

TEST_CASE("every frame: one answer of each stage a frame, and the target is a ring of the film") {
  const auto events = replayed(ReplayMode::every_frame, ReplayOptions{}.stages);
  const auto frames = messages(events, channels::frame);
  const auto ellipses = messages(events, channels::ellipses);
  const auto missions = messages(events, channels::mission);
  CHECK(ellipses.size() == frames.size());
  int right = 0;
  for (const auto& [seq, message] : ellipses) {
    const auto truth = film_frame(static_cast<int>(message.header.frame_seq)).outer_edges;
    for (const Ellipse& edge : truth) {
      for (const auto& e : message.ellipses) {
        const bool same_place = std::hypot(e.outer.u_px - edge.u_px, e.outer.v_px - edge.v_px) < 1.5;
        if (same_place && std::abs(e.outer.a_px - edge.a_px) < 1.5) ++right;
      }
    }
  }
  CHECK(right >= 0.95 * 4 * static_cast<double>(frames.size()));  // each ring once in nearly every frame
  CHECK(right <= 4 * static_cast<int>(frames.size()));
}
