#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "detector_proc/detector_stage.hpp"
#include "gimbal_proc/gimbal_stage.hpp"
#include "mission_proc/mission_stage.hpp"
#include "pose_proc/pose_stage.hpp"
#include "tests/support/film.hpp"
#include "tests/support/memory_bus.hpp"
#include "tracker_proc/tracker_stage.hpp"

using namespace stevedore;

namespace {

constexpr int64_t frame_us = 33'333;

frame_t frame_of(const cv::Mat& image, int64_t k) {
  frame_t frame{};
  frame.header.utime = 1'000'000 + k * frame_us;
  frame.header.frame_seq = k;
  frame.header.seq = k;
  encode_raw(image, frame);
  return frame;
}

ellipse_t circle_message(double u_px, double v_px, double radius_px = 40) {
  ellipse_t ellipse{};
  ellipse.outer.u_px = u_px;
  ellipse.outer.v_px = v_px;
  ellipse.outer.a_px = radius_px;
  ellipse.outer.b_px = radius_px * 0.9;
  for (int i = 0; i < 5; ++i) ellipse.outer.covariance[6 * i] = 0.01;
  ellipse.coverage = 1;
  ellipse.kind = ellipse_t::KIND_WHOLE;
  ellipse.label = ellipse_t::LABEL_CIRCLE;
  return ellipse;
}

ellipses_t ellipses_of(int64_t k, const std::vector<ellipse_t>& found) {
  ellipses_t ellipses{};
  ellipses.header.utime = 1'000'000 + k * frame_us;
  ellipses.header.frame_seq = k;
  ellipses.header.seq = k;
  ellipses.width_px = 640;
  ellipses.height_px = 480;
  ellipses.search = ellipses_t::SEARCH_FULL;
  ellipses.ellipses = found;
  ellipses.count = static_cast<int16_t>(found.size());
  return ellipses;
}

tracks_t tracks_of(int64_t k, const std::vector<ellipse_t>& found) {
  tracks_t tracks{};
  tracks.header = ellipses_of(k, {}).header;
  tracks.width_px = 640;
  tracks.height_px = 480;
  tracks.target_id = -1;
  tracks.target_status = track_t::STATUS_SEARCHING;
  for (const auto& ellipse : found) {
    track_t track{};
    track.id = static_cast<int64_t>(tracks.tracks.size()) + 1;
    track.ellipse = ellipse;
    track.age_frames = 10;
    track.status = track_t::STATUS_TRACKING;
    tracks.tracks.push_back(track);
  }
  tracks.count = static_cast<int16_t>(found.size());
  return tracks;
}

poses_t poses_of(int64_t k, int64_t id) {
  poses_t poses{};
  poses.header = ellipses_of(k, {}).header;
  poses.target_id = -1;
  poses.target_status = track_t::STATUS_SEARCHING;
  pose_t pose{};
  pose.track_id = id;
  pose.age_frames = 10;
  pose.status = track_t::STATUS_TRACKING;
  pose.u_px = 320;
  pose.v_px = 200;
  pose.a_px = pose.b_px = 40;
  pose.coverage = 1;
  pose.kind = ellipse_t::KIND_WHOLE;
  pose.label = ellipse_t::LABEL_CIRCLE;
  poses.poses.push_back(pose);
  poses.count = 1;
  return poses;
}

vehicle_state_t level_vehicle(int64_t utime) {
  vehicle_state_t vehicle{};
  vehicle.header.utime = utime;
  vehicle.ned_from_body[0] = 1;
  return vehicle;
}

gimbal_state_t gimbal_at(int64_t utime, double roll_rad, int8_t status = gimbal_state_t::STATUS_OK) {
  gimbal_state_t gimbal{};
  gimbal.header.utime = utime;
  gimbal.roll_rad = roll_rad;
  gimbal.off_level_rad = -1;
  gimbal.status = status;
  return gimbal;
}

}  // namespace

TEST_CASE("detector stage: a frame gives its ellipses, an unusable one is counted") {
  MemoryBus bus;
  FrameReader frames;
  const DetectorStage stage(DetectorSettings{}, {}, bus, frames, Delivery::every);
  const FilmFrame film = film_frame(0);
  bus.deliver(channels::frame, frame_of(film.image, 0));
  const auto ellipses = bus.published_on(channels::ellipses);
  REQUIRE(ellipses.size() == 1);
  CHECK(ellipses[0].header.utime == 1'000'000);
  CHECK(ellipses[0].header.trace.cause == "FRAME");
  CHECK(ellipses[0].ellipses.size() >= film.outer_edges.size());

  frame_t gone = frame_of(film.image, 1);
  gone.encoding = frame_t::ENCODING_RING;
  gone.ring_name = "no-such-ring";
  gone.ring_generation = 1;
  gone.ring_sequence = 2;
  gone.data.clear();
  gone.size = 0;
  bus.deliver(channels::frame, gone);
  frame_t torn = frame_of(film.image, 2);
  torn.encoding = frame_t::ENCODING_JPEG;
  bus.deliver(channels::frame, torn);
  CHECK(bus.published_on(channels::ellipses).size() == 1);
  CHECK(bus.counters("FRAME").lost_stale == 1);
  CHECK(bus.counters("FRAME").lost_malformed == 1);
}

TEST_CASE(
    "detector stage: region search follows the tracks of an earlier frame, the schedule and what is lost") {
  MemoryBus bus;
  FrameReader frames;
  DetectorSettings settings;
  settings.search = "region";
  settings.full_every_frames = 10;
  const DetectorStage stage(settings, {}, bus, frames, Delivery::every);
  const auto step = [&](int k) {
    bus.deliver(channels::frame, frame_of(film_frame(k).image, k));
    return bus.published_on(channels::ellipses).back();
  };
  const auto tell = [&](const ellipses_t& seen, int frame_seq) {
    tracks_t tracks{};
    tracks.header.frame_seq = frame_seq;
    tracks.header.utime = seen.header.utime;
    for (const ellipse_t& ellipse : seen.ellipses) {
      track_t track{};
      track.ellipse = ellipse;
      track.status = track_t::STATUS_TRACKING;
      tracks.tracks.push_back(track);
    }
    tracks.count = static_cast<int16_t>(tracks.tracks.size());
    tracks.target_status = track_t::STATUS_SEARCHING;
    tracks.target_id = -1;
    tracks.width_px = seen.width_px;
    tracks.height_px = seen.height_px;
    bus.deliver(channels::tracks, tracks);
  };
  const ellipses_t first = step(1);
  CHECK(first.search == ellipses_t::SEARCH_FULL);
  CHECK(first.tracks_frame_seq == -1);
  tell(first, 1);
  const ellipses_t second = step(2);
  CHECK(second.search == ellipses_t::SEARCH_REGION);
  CHECK(second.tracks_frame_seq == 1);
  REQUIRE(second.ellipses.size() == first.ellipses.size());
  for (std::size_t k = 0; k < first.ellipses.size(); ++k) {
    CHECK(second.ellipses[k].outer.u_px == Approx(first.ellipses[k].outer.u_px).margin(10));
  }
  tell(second, 3);  // not of an earlier frame
  CHECK(step(3).search == ellipses_t::SEARCH_FULL);
  ellipses_t elsewhere = second;
  elsewhere.ellipses[0].outer.u_px = 5;
  elsewhere.ellipses[0].outer.v_px = 5;
  tell(elsewhere, 3);  // lost there: the whole frame, in the same frame
  const ellipses_t fourth = step(4);
  CHECK(fourth.search == ellipses_t::SEARCH_FULL);
  CHECK(fourth.ellipses.size() == first.ellipses.size());
  // every second frame is skipped: whole again after ten all the same, whatever their numbers
  ellipses_t newest = fourth;
  for (int k = 6; k < 14; k += 2) {
    tell(newest, k - 2);
    newest = step(k);
    CHECK(newest.search == ellipses_t::SEARCH_REGION);
  }
  tell(newest, 12);
  newest = step(14);
  CHECK(newest.search == ellipses_t::SEARCH_FULL);
  ellipses_t twice = newest;
  twice.ellipses.push_back(twice.ellipses[0]);
  twice.ellipses.back().outer.u_px += 2;
  ++twice.count;
  tell(twice, 14);  // two expected where there is one
  newest = step(15);
  CHECK(newest.search == ellipses_t::SEARCH_FULL);
  CHECK(newest.ellipses.size() == first.ellipses.size());
}

TEST_CASE("tracker stage: a restarted tracker takes the target up where it was last seen, whatever its id") {
  track_command_t command{};
  command.action = track_command_t::ACTION_BY_ID;
  command.choice = 1;
  MemoryBus bus;
  FrameReader frames;
  TrackerStage stage(TrackerSettings{}, std::nullopt, bus, frames);
  const std::vector<ellipse_t> found = {circle_message(100, 100), circle_message(400, 300)};
  bus.deliver(channels::ellipses, ellipses_of(0, found));
  const auto first = bus.published_on(channels::tracks).back();
  REQUIRE(first.tracks.size() == 2);
  CHECK(first.target_status == track_t::STATUS_SEARCHING);

  // the id is another object's here: it was given by an earlier run of the tracker
  command.id = first.tracks[0].id;
  command.u_px = 402;
  command.v_px = 303;
  bus.deliver(channels::track_command, command);
  bus.deliver(channels::ellipses, ellipses_of(1, found));
  const auto second = bus.published_on(channels::tracks).back();
  CHECK(second.target_status == track_t::STATUS_TRACKING);
  CHECK(second.target_id == first.tracks[1].id);

  // the same choice again, later and from elsewhere, changes nothing; another choice does
  command.u_px = command.v_px = 100;
  bus.deliver(channels::track_command, command);
  bus.deliver(channels::ellipses, ellipses_of(2, found));
  CHECK(bus.published_on(channels::tracks).back().target_id == first.tracks[1].id);
  command.choice = 2;
  bus.deliver(channels::track_command, command);
  bus.deliver(channels::ellipses, ellipses_of(3, found));
  CHECK(bus.published_on(channels::tracks).back().target_id == first.tracks[0].id);
}

TEST_CASE("tracker stage: the frame that ELLIPSES names is used though newer ones have come") {
  MemoryBus bus;
  FrameReader frames;
  TrackerStage stage(TrackerSettings{}, std::nullopt, bus, frames);
  track_command_t command{};
  command.action = track_command_t::ACTION_FIRST_CIRCLE;
  command.choice = 1;
  bus.deliver(channels::track_command, command);
  cv::Mat image(480, 640, CV_8UC1, cv::Scalar(40));
  cv::circle(image, {320, 240}, 40, cv::Scalar(220), cv::FILLED);
  const cv::Mat empty(480, 640, CV_8UC1, cv::Scalar(40));
  for (int64_t k = 0; k < 4; ++k) {
    bus.deliver(channels::frame, frame_of(image, 2 * k));
    bus.deliver(channels::frame, frame_of(empty, 2 * k + 1));
    bus.deliver(channels::ellipses, ellipses_of(2 * k, {circle_message(320, 240)}));
  }
  const auto last = bus.published_on(channels::tracks).back();
  CHECK(last.target_status == track_t::STATUS_TRACKING);
  REQUIRE(last.has_window);
  CHECK(std::hypot(last.window_u_px - 320, last.window_v_px - 240) < 5);
}

TEST_CASE("pose stage: metres with a camera, a reason without, attitude where it is there") {
  CameraModel camera;
  camera.given = camera.rectified = film_camera();
  MemoryBus with, without;
  PoseStage stage_with(PoseSettings{}, camera, with), stage_without(PoseSettings{}, std::nullopt, without);
  const tracks_t tracks = tracks_of(0, {circle_message(400, 300)});

  without.deliver(channels::tracks, tracks);
  const auto none = without.published_on(channels::poses).back();
  REQUIRE(none.poses.size() == 1);
  CHECK(none.poses[0].solution_count == 0);
  CHECK(none.poses[0].reason == "no camera file");

  with.deliver(channels::tracks, tracks);
  const auto free = with.published_on(channels::poses).back();
  REQUIRE(free.poses[0].solution_count == 2);
  CHECK(free.poses[0].chosen_by == pose_t::CHOSEN_BY_OPTICAL_AXIS);
  CHECK_FALSE(free.has_gravity);

  vehicle_state_t vehicle{};
  vehicle.header.utime = tracks.header.utime - 10'000;
  vehicle.ned_from_body[0] = 1;
  with.deliver(channels::vehicle_state, vehicle);
  with.deliver(channels::tracks, tracks);
  const auto level = with.published_on(channels::poses).back();
  CHECK(level.has_gravity);
  CHECK(level.gravity_camera[2] == Approx(1));
  CHECK(level.poses[0].chosen_by == pose_t::CHOSEN_BY_ATTITUDE);
  CHECK(level.poses[0].has_level);

  with.deliver(channels::tracks,
               tracks_of(30, {circle_message(400, 300)}));  // a second later the attitude is too old
  CHECK_FALSE(with.published_on(channels::poses).back().has_gravity);
}

TEST_CASE("mission stage: the choice is sent at once and again at 2 Hz") {
  MemoryBus bus;
  MissionStage stage(MissionSettings{}, bus);
  for (int64_t k = 0; k < 33; ++k) bus.deliver(channels::poses, poses_of(k, 5));
  const auto commands = bus.published_on(channels::track_command);
  REQUIRE(commands.size() == 3);  // with frames 0, 16 and 32: the first half a second later
  CHECK(commands[0].id == 5);
  CHECK(commands[0].u_px == 320);
  CHECK(commands[1].choice == commands[0].choice);
  CHECK(commands[2].choice != commands[0].choice);  // never taken up for a second: chosen anew
  CHECK(bus.published_on(channels::mission).size() == 33);
}

TEST_CASE("mission stage: silent vision is an emergency, with TIMEOUT or VEHICLE_STATE as the clock") {
  MemoryBus bus;
  MissionStage stage(MissionSettings{}, bus);
  bus.deliver(channels::poses, poses_of(0, 5));
  timeout_t timeout{};
  timeout.channel = "VEHICLE_STATE";
  timeout.header.utime = 1'000'000 + 400'000;
  bus.deliver(channels::timeout, timeout);
  CHECK(bus.published_on(channels::mission).size() == 1);
  timeout.header.utime += 200'000;
  bus.deliver(channels::timeout, timeout);
  REQUIRE(bus.published_on(channels::mission).size() == 2);
  REQUIRE(bus.published_on(channels::mission).back().emergency_count == 1);
  CHECK(bus.published_on(channels::mission).back().emergencies[0].kind == emergency_t::KIND_VISION_STALE);

  poses_t poses = poses_of(20, 5);
  bus.deliver(channels::poses, poses);
  CHECK(bus.published_on(channels::mission).back().emergency_count == 0);
  vehicle_state_t vehicle{};
  vehicle.ned_from_body[0] = 1;
  vehicle.header.utime = poses.header.utime + 700'000;
  bus.deliver(channels::vehicle_state, vehicle);
  CHECK(bus.published_on(channels::mission).back().emergencies.at(0).kind == emergency_t::KIND_VISION_STALE);
}

TEST_CASE(
    "mission stage: where the aircraft is silent, no set-point of long ago is told as if it were of now") {
  MemoryBus bus;
  MissionSettings settings;
  settings.job = "carry";
  settings.carry.start_at_once = true;
  MissionStage stage(settings, bus);
  autopilot_status_t status{};
  status.mode = autopilot_status_t::MODE_GUIDED;
  status.armed = true;
  status.battery_share = 1;
  bus.deliver(channels::autopilot_status, status);
  bus.deliver(channels::vehicle_state, level_vehicle(1'000'000));
  bus.deliver(channels::vehicle_state, level_vehicle(1'020'000));
  bus.deliver(channels::poses, poses_of(1, 5));
  const auto flown = bus.published_on(channels::mission).back();
  CHECK(flown.has_setpoint);
  CHECK(flown.action == mission_t::ACTION_CLIMB);
  for (int64_t k = 2; k < 30; ++k) bus.deliver(channels::poses, poses_of(k, 5));
  const auto silent = bus.published_on(channels::mission).back();
  CHECK_FALSE(silent.has_setpoint);
  CHECK(silent.action == mission_t::ACTION_HOVER);
}

TEST_CASE("gimbal stage: each VEHICLE_STATE gives a command and how level the camera is") {
  MemoryBus bus;
  GimbalStage stage(GimbalSettings{}, CameraMount{}, bus);
  CHECK(stage.condition().state == health_t::STATE_STARTING);
  bus.deliver(channels::gimbal_state, gimbal_at(990'000, 0.1));
  CHECK(bus.sent.empty());
  bus.deliver(channels::vehicle_state, level_vehicle(1'000'000));
  const auto commands = bus.published_on(channels::gimbal_command);
  const auto levels = bus.published_on(channels::gimbal_level);
  REQUIRE(commands.size() == 1);
  REQUIRE(levels.size() == 1);
  CHECK(commands[0].header.utime == 1'000'000);
  CHECK(commands[0].header.trace.cause == "VEHICLE_STATE");
  CHECK(commands[0].roll_rad < 0.1);  // on its way to level
  CHECK(levels[0].roll_rad == 0.1);
  CHECK(levels[0].off_level_rad == Approx(0.1));
  CHECK(levels[0].status == gimbal_state_t::STATUS_OK);
  CHECK(stage.condition().state == health_t::STATE_OK);
}

TEST_CASE("gimbal stage: a silent and a stuck pan-tilt are in GIMBAL_LEVEL and in HEALTH") {
  MemoryBus bus;
  GimbalStage stage(GimbalSettings{}, CameraMount{}, bus);
  int64_t utime = 1'000'000;
  for (int i = 0; i < 12; ++i, utime += 20'000) bus.deliver(channels::vehicle_state, level_vehicle(utime));
  CHECK(bus.published_on(channels::gimbal_level).back().status == gimbal_state_t::STATUS_LATE);
  CHECK(bus.published_on(channels::gimbal_level).back().off_level_rad == -1);
  CHECK(stage.condition().state == health_t::STATE_DEGRADED);
  CHECK(stage.condition().message == "no GIMBAL_STATE comes: nobody knows how the camera stands");
  for (int i = 0; i < 40; ++i, utime += 20'000) {
    bus.deliver(channels::gimbal_state, gimbal_at(utime, 0.2));  // whatever it is told
    bus.deliver(channels::vehicle_state, level_vehicle(utime));
  }
  CHECK(bus.published_on(channels::gimbal_level).back().status == gimbal_state_t::STATUS_STUCK);
  CHECK(stage.condition().message ==
        "the pan-tilt does not follow: roll 11.5 of 0.0 deg, pitch 0.0 of 0.0 deg");
}

TEST_CASE("mission stage: a gimbal that is not level is told at once, and when it is over") {
  MemoryBus bus;
  MissionStage stage(MissionSettings{}, bus);
  bus.deliver(channels::poses, poses_of(0, 5));
  gimbal_state_t level = gimbal_at(1'020'000, 0, gimbal_state_t::STATUS_STUCK);
  level.off_level_rad = 0.02;
  bus.deliver(channels::gimbal_level, level);
  const auto told = bus.published_on(channels::mission).back();
  REQUIRE(told.emergency_count == 1);
  CHECK(told.emergencies[0].kind == emergency_t::KIND_GIMBAL_NOT_LEVEL);
  CHECK(told.emergencies[0].cause == "the pan-tilt does not follow its commands");
  CHECK(told.emergencies[0].advised_action == mission_t::ACTION_HOVER);
  CHECK(told.header.frame_seq == -1);
  CHECK(told.header.trace.cause == "GIMBAL_LEVEL");
  level.status = gimbal_state_t::STATUS_OK;
  for (int64_t k = 1; k < 40; ++k) {
    level.header.utime = 1'000'000 + k * frame_us;
    bus.deliver(channels::gimbal_level, level);
    bus.deliver(channels::poses, poses_of(k, 5));
  }
  const auto later = bus.published_on(channels::mission).back();
  for (const emergency_t& e : later.emergencies) CHECK(e.kind != emergency_t::KIND_GIMBAL_NOT_LEVEL);
}
