#include "tools/evaluate_core.hpp"

#include <catch2/catch.hpp>
#include <filesystem>
#include <numbers>

#include "tests/support/program.hpp"
#include "tools/evaluate_page.hpp"

using namespace stevedore;

namespace {

constexpr std::int64_t frame_us = 66'667;
constexpr double half_turn_rad = std::numbers::pi;

template <std::size_t N>
void put(const Eigen::Vector3d& from, double (&to)[N]) {
  static_assert(N == 3);
  for (int i = 0; i < 3; ++i) to[i] = from[i];
}

/// A camera 4 m over a square of four circles that moves north, cargoes in slots 1 and 2.
truth_t truth_at(std::int64_t utime) {
  const double north_m = 0.5 * static_cast<double>(utime) * 1e-6;
  const std::vector<Eigen::Vector3d> places_m{{0.8, -0.8, 0}, {0.8, 0.8, 0}, {-0.8, 0.8, 0}, {-0.8, -0.8, 0}};
  truth_t truth{};
  truth.header.utime = utime;
  for (std::size_t slot = 0; slot < places_m.size(); ++slot) {
    truth_circle_t circle{};
    circle.slot = static_cast<std::int16_t>(slot);
    circle.occupied = slot == 1 || slot == 2;
    put(places_m[slot] + Eigen::Vector3d(north_m, 0, 0), circle.center_ned_m);
    put({0, 0, -1}, circle.normal_ned);
    circle.radius_m = 0.5;
    circle.in_view = true;
    circle.visible_share = 1;
    truth.circles.push_back(circle);
    if (!circle.occupied) continue;
    truth_cargo_t cargo{};
    cargo.index = cargo.slot = circle.slot;
    put(Eigen::Vector3d(circle.center_ned_m) - Eigen::Vector3d(0, 0, 0.3), cargo.center_ned_m);
    put({0, 0, -1}, cargo.axis_ned);
    cargo.radius_m = 0.16;
    truth.cargoes.push_back(cargo);
  }
  truth.circle_count = static_cast<std::int16_t>(truth.circles.size());
  truth.cargo_count = static_cast<std::int16_t>(truth.cargoes.size());
  put({-0.8, 0, -4.25}, truth.position_ned_m);
  put({0, 0, -4}, truth.camera_ned_m);
  truth.ned_from_body[0] = 1;
  truth.ned_from_camera[0] = truth.ned_from_camera[3] = std::sqrt(0.5);  // top of the image northwards
  return truth;
}

/// What is exactly right: the second solution leans to the other side.
pose_t pose_of(const Mark& mark, std::int64_t track_id) {
  pose_t pose{};
  pose.track_id = track_id;
  pose.status = track_t::STATUS_TRACKING;
  pose.a_px = pose.b_px = 20;
  pose.coverage = 1;
  pose.kind = ellipse_t::KIND_WHOLE;
  pose.label = mark.kind == Mark::Kind::circle ? ellipse_t::LABEL_CIRCLE : ellipse_t::LABEL_CARGO;
  pose.radius_m = mark.radius_m;
  const Eigen::Vector3d sight = mark.center_camera_m.normalized();
  const Eigen::Vector3d mirrored = 2 * sight.dot(mark.normal_camera) * sight - mark.normal_camera;
  for (const auto& [normal, probability] : {std::pair(mark.normal_camera, 0.95), std::pair(mirrored, 0.05)}) {
    circle_solution_t solution{};
    put(mark.center_camera_m, solution.center_camera_m);
    put(normal, solution.normal_camera);
    solution.covariance_m2[0] = solution.covariance_m2[4] = solution.covariance_m2[8] = 0.01;
    solution.probability = probability;
    pose.solutions.push_back(solution);
  }
  pose.solution_count = 2;
  pose.has_level = true;  // the camera looks straight down
  put(mark.center_camera_m, pose.center_level_m);
  return pose;
}

/// Track ids are the marks' numbers: circles 0 to 3, cargoes 4 and 5.
poses_t poses_at(std::int64_t utime) {
  poses_t poses{};
  poses.header.utime = utime;
  std::int64_t track_id = 0;
  const std::vector<truth_t> truth{truth_at(utime)};
  const MarksByTime marks = marks_of(truth);
  for (const Mark& mark : marks.begin()->second) poses.poses.push_back(pose_of(mark, track_id++));
  poses.count = static_cast<std::int16_t>(poses.poses.size());
  poses.target_status = track_t::STATUS_SEARCHING;
  poses.has_gravity = true;
  poses.gravity_camera[2] = 1;
  return poses;
}

vehicle_state_t vehicle_at(std::int64_t utime) {
  vehicle_state_t vehicle{};
  vehicle.header.utime = utime;
  put({-0.8 + 1.5, 0 - 1.5, -4.25}, vehicle.position_ned_m);  // GPS: 1.5 m north and west
  vehicle.ned_from_body[0] = 1;
  return vehicle;
}

platform_estimate_t estimate_at(std::int64_t utime) {
  const Eigen::Vector3d told_m(1.5, -1.5, 0), velocity_mps(0.5, 0, 0);
  const Eigen::Vector3d middle_m = told_m + velocity_mps * static_cast<double>(utime) * 1e-6;
  platform_estimate_t estimate{};
  estimate.header.utime = estimate.seen_utime = estimate.measured_utime = utime;
  put(middle_m, estimate.center_ned_m);
  put(velocity_mps, estimate.velocity_ned_mps);
  for (int i = 0; i < 6; ++i) estimate.covariance[7 * i] = 0.01;
  estimate.identity_certain = true;
  for (const truth_circle_t& circle : truth_at(utime).circles) {
    slot_t slot{};
    slot.index = circle.slot;
    put(Eigen::Vector3d(circle.center_ned_m) + told_m, slot.center_ned_m);
    slot.state = circle.occupied ? slot_t::STATE_OCCUPIED : slot_t::STATE_EMPTY;
    slot.seen_utime = utime;
    estimate.slots.push_back(slot);
  }
  deck_prediction_t prediction{};
  prediction.ahead_s = 1;
  put(middle_m + velocity_mps, prediction.center_ned_m);
  prediction.normal_ned[2] = -1;
  estimate.predictions.push_back(prediction);
  estimate.slot_count = static_cast<std::int16_t>(estimate.slots.size());
  estimate.prediction_count = 1;
  return estimate;
}

/// As high as the camera.
altimeter_t laser_at(std::int64_t utime) {
  altimeter_t laser{};
  laser.header.utime = utime;
  laser.valid = true;
  laser.range_m = 4;
  laser.variance_m2 = 0.0009;
  return laser;
}

FlightLog flight_of(int frames) {
  FlightLog flight;
  for (int k = 0; k < frames; ++k) {
    const std::int64_t utime = 1'000'000 + k * frame_us;
    flight.truth.push_back(truth_at(utime));
    flight.poses.push_back(poses_at(utime));
    flight.vehicle.push_back(vehicle_at(utime));
    flight.estimates.push_back(estimate_at(utime));
    flight.altimeter.push_back(laser_at(utime));
  }
  return flight;
}

PoseComparison compare(const FlightLog& flight) {
  return compare_poses(flight.poses, marks_of(flight.truth), std::nullopt);
}

void shift(pose_t& pose, double scale) {
  for (circle_solution_t& solution : pose.solutions)
    put(Eigen::Vector3d(solution.center_camera_m) * scale, solution.center_camera_m);
}

template <class M>
void write_all(LogWriter& writer, const Channel<M>& channel, const std::vector<M>& messages) {
  for (const M& message : messages) {
    REQUIRE_FALSE(fault_of(message));
    writer.write({message.header.utime, channel.name, encode(message)});
  }
}

void write_log(const std::string& path, const FlightLog& flight) {
  LogWriter writer(path);
  write_all(writer, channels::truth, flight.truth);
  write_all(writer, channels::vehicle_state, flight.vehicle);
  write_all(writer, channels::altimeter, flight.altimeter);
  write_all(writer, channels::poses, flight.poses);
  write_all(writer, channels::platform_estimate, flight.estimates);
  writer.flush();
}

}  // namespace

TEST_CASE("Exact poses have no error and every mark its own") {
  const PoseComparison result = compare(flight_of(10));
  CHECK(result.frames == 10);
  CHECK(result.poses == 60);
  CHECK(result.samples.size() == 60);
  CHECK(result.of_nothing + result.ambiguous + result.doubled + result.other_size == 0);
  CHECK(result.whole_circles == 40);
  CHECK(result.whole_found == 40);
  CHECK(result.marks == 6);
  CHECK(result.switches + result.after_exit + result.taken_over == 0);
  const PoseRow all = row_of("all", result.samples);
  CHECK(all.range_m.worst == Approx(0).margin(1e-12));
  CHECK(all.center_m.worst == Approx(0).margin(1e-12));
  CHECK(all.nees3 == Approx(0).margin(1e-12));
  CHECK(all.judged > 0);
  CHECK(all.wrong == 0);
  CHECK(calibration_error(result) == Approx(0.05));  // said 0.95, and always right
  CHECK(result.samples.front().theta_rad == Approx(std::atan(std::hypot(0.8 + 0.5, 0.8) / 4)));
}

TEST_CASE("A pose too far away by a tenth of a metre shows as that") {
  FlightLog flight = flight_of(1);
  pose_t& pose = flight.poses[0].poses[0];
  const double range_m = Eigen::Vector3d(pose.solutions[0].center_camera_m).norm();
  shift(pose, (range_m + 0.1) / range_m);
  const PoseComparison result = compare(flight);
  REQUIRE(result.samples.size() == 6);
  CHECK(result.samples[0].range_error_m == Approx(0.1));
  CHECK(result.samples[0].center_error_m == Approx(0.1));
  CHECK(*result.samples[0].nees3 == Approx(0.1 * 0.1 / 0.01 / 3));
  CHECK(row_of("all", result.samples).range_m.worst == Approx(0.1));
  CHECK(rows_by_mark(result).size() == 6);
  const auto near = table_one(result);
  CHECK(near[2].ours.range_m.count == 6 - 2);  // (c), 4.22 m; the cargoes are not circles
  CHECK(near[0].ours.range_m.count == 0);
}

TEST_CASE("The wrong solution is told from the right one by its normal") {
  FlightLog flight = flight_of(1);
  auto& solutions = flight.poses[0].poses[0].solutions;
  std::swap(solutions[0], solutions[1]);
  solutions[0].probability = 0.999;
  solutions[1].probability = 0.001;
  const PoseRow all = row_of("all", compare(flight).samples);
  CHECK(all.judged == 6);
  CHECK(all.wrong == 1);
  CHECK(all.wrong_above_99 == 1);

  // of a single one nothing is chosen
  for (std::size_t i = 1; i < 6; ++i) flight.poses[0].poses[i].solutions.pop_back();
  CHECK(row_of("all", compare(flight).samples).judged == 1);
}

TEST_CASE("Track ids that change places, or change after an absence") {
  FlightLog flight = flight_of(60);  // four seconds
  for (std::size_t k = 30; k < 60; ++k)
    std::swap(flight.poses[k].poses[0].track_id, flight.poses[k].poses[1].track_id);
  PoseComparison result = compare(flight);
  CHECK(result.switches == 2);
  CHECK(result.taken_over == 2);

  flight = flight_of(60);
  for (std::size_t k = 10; k < 50; ++k) flight.poses[k].poses.erase(flight.poses[k].poses.begin());
  for (std::size_t k = 50; k < 60; ++k) flight.poses[k].poses[0].track_id = 77;
  result = compare(flight);
  CHECK(result.switches == 0);
  CHECK(result.after_exit == 1);
  CHECK(result.whole_found == 4 * 60 - 40);
}

TEST_CASE("Of two tracks on a mark the one that was its before keeps it while it is there") {
  FlightLog flight = flight_of(60);
  for (std::size_t k = 0; k < 60; ++k) {
    auto& poses = flight.poses[k].poses;
    pose_t second = poses[4];
    second.track_id = 40;
    shift(k % 2 == 0 ? second : poses[4], 1.01);  // by turns nearer
    for (circle_solution_t& solution : (k % 2 == 0 ? second : poses[4]).solutions)
      solution.center_camera_m[1] += 0.01;
    poses.push_back(second);
    if (k >= 30) poses.erase(poses.begin() + 4);  // the first one is gone
  }
  const PoseComparison result = compare(flight);
  CHECK(result.doubled == 30);
  CHECK(result.switches == 1);
}

TEST_CASE("Poses that belong to no mark, to two, or to one twice") {
  FlightLog flight = flight_of(1);
  auto& poses = flight.poses[0].poses;
  pose_t beside = poses[0];
  for (circle_solution_t& solution : beside.solutions) solution.center_camera_m[0] += 0.6;
  pose_t predicted = poses[1];
  predicted.ellipse_index = -1;
  pose_t without = poses[1];
  without.solutions.clear();
  pose_t twice = poses[2];
  shift(twice, 1.01);
  twice.solutions[0].center_camera_m[1] += 0.01;
  poses.insert(poses.end(), {beside, predicted, without, twice});
  poses[3].radius_m = 0.16;  // a circle taken for a cargo's rim: as large in the image, and a third as far
  shift(poses[3], 0.16 / 0.5);
  const PoseComparison result = compare(flight);
  CHECK(result.of_nothing == 1);
  CHECK(result.predicted == 1);
  CHECK(result.without_solution == 1);
  CHECK(result.doubled == 1);
  CHECK(result.other_size == 1);
  CHECK(result.samples.size() == 5);

  truth_circle_t close = flight.truth[0].circles[0];
  close.slot = 9;
  close.center_ned_m[0] += 0.05;
  flight.truth[0].circles.push_back(close);
  CHECK(compare(flight).ambiguous == 1);
}

TEST_CASE("Frames without POSES are told, and their circles are missed") {
  FlightLog flight = flight_of(10);
  flight.poses.erase(flight.poses.begin() + 4, flight.poses.begin() + 6);
  flight.poses.erase(flight.poses.begin());  // before the first one nobody was there yet
  flight.poses.pop_back();
  const PoseComparison result = compare(flight);
  CHECK(result.frames == 6);
  CHECK(result.frames_unanswered == 2);
  CHECK(result.whole_found == 4 * 6);
  CHECK(result.whole_circles == 4 * 8);
}

TEST_CASE("Platforms are compared relative to the aircraft, whose own position is off") {
  FlightLog flight = flight_of(120);
  PlatformComparison result = compare_platforms(flight);
  CHECK(result.velocity_mps.count > 50);
  CHECK(result.position_m.worst == Approx(0).margin(1e-9));
  CHECK(result.velocity_mps.worst == Approx(0).margin(1e-6));
  CHECK(result.predicted_m.worst == Approx(0).margin(1e-6));
  CHECK(result.held_m.rms == Approx(0.5));
  CHECK(result.certain.right == 4 * 120);
  CHECK(result.certain.wrong + result.certain.unknown + result.certain.misnumbered == 0);
  CHECK(result.in_view_certain == 120);

  flight.estimates[5].slots[0].state = slot_t::STATE_OCCUPIED;
  std::swap(flight.estimates[7].slots[0].index, flight.estimates[7].slots[1].index);
  flight.estimates[9].identity_certain = false;
  flight.estimates[9].slots[3].state = slot_t::STATE_UNKNOWN;
  for (platform_estimate_t& estimate : flight.estimates) estimate.velocity_ned_mps[2] += 0.1;
  result = compare_platforms(flight);
  CHECK(result.certain.wrong == 1);
  CHECK(result.certain.misnumbered == 2);
  CHECK(result.uncertain.right == 3);
  CHECK(result.uncertain.unknown == 1);
  CHECK(result.velocity_mps.rms == Approx(0.1));

  // what is still over its circle when the hook has it looks as before
  truth_t& lifted = flight.truth[20];
  lifted.cargoes[0].on_hook = true;
  lifted.circles[1].occupied = false;
  result = compare_platforms(flight);
  CHECK(result.certain.wrong == 1);
  CHECK(result.certain.handled == 1);
}

TEST_CASE("A covariance that no estimate was held against has no figure, which is not 0") {
  const Folder folder;
  write_log(folder.file("flight.lcm"), flight_of(20));  // 1.3 s: no deck is in view for 3 s
  const Evaluation evaluation = evaluate(folder.file("flight.lcm"), {}, "");
  CHECK(nlohmann::json::parse(to_json(evaluation).dump())["platforms"]["nees6"].is_null());
  CHECK(to_html(evaluation).find("NEES / 6 of position and velocity: - (") != std::string::npos);
}

TEST_CASE("Altitude by vision and laser, after lever arm and tilt, and with a cargo below the beam") {
  LaserMount mount;
  mount.from_camera_body_m = {-0.3, -0.8, 0};  // over slot 3, when the deck has moved on by half a metre
  FlightLog flight = flight_of(3);
  AltitudeComparison result = compare_altitudes(flight, mount);
  CHECK(result.vision_less_laser_m.count == 3);
  CHECK(result.vision_less_laser_m.worst == Approx(0).margin(1e-9));
  CHECK(result.vision_less_truth_m.count == 3);
  CHECK(result.vision_less_truth_m.worst == Approx(0).margin(1e-9));
  CHECK(result.on_thing == 0);

  for (altimeter_t& laser : flight.altimeter) laser.range_m = 4 - 0.3;
  result = compare_altitudes(flight, mount);
  CHECK(result.on_thing == 3);
  CHECK(result.vision_less_laser_m.count == 0);

  // the aircraft leans, its camera with it: the laser is higher up and its beam longer
  const auto leaning_by = [&](double roll_deg) {
    const double roll_rad = roll_deg * half_turn_rad / 180;
    for (poses_t& poses : flight.poses) {
      poses.gravity_camera[0] = std::sin(roll_rad);
      poses.gravity_camera[2] = std::cos(roll_rad);
    }
    for (altimeter_t& laser : flight.altimeter)
      laser.range_m = (4 + 0.8 * std::sin(roll_rad)) / std::cos(roll_rad);
    return compare_altitudes(flight, mount);
  };
  result = leaning_by(5);
  CHECK(result.vision_less_laser_m.count == 3);
  CHECK(result.vision_less_laser_m.worst == Approx(0).margin(1e-9));

  // by 10 degrees the beam ends beside the circle, which may be beside the deck
  result = leaning_by(10);
  CHECK(result.vision_less_laser_m.count == 0);
  CHECK(result.on_thing == 0);
}

TEST_CASE("Vision that reads high is vision's error where TRUTH says so, and else told as left out") {
  FlightLog flight = flight_of(20);
  for (poses_t& poses : flight.poses)
    for (pose_t& pose : poses.poses) put(Eigen::Vector3d(pose.center_level_m) * 1.2, pose.center_level_m);
  const auto verdict = [](const FlightLog& seen) {
    const Folder folder;
    write_log(folder.file("flight.lcm"), seen);
    const FlownConfiguration over_slot_3{"", {"pose.altimeter_right_m=-0.8"}};
    const auto verdicts = verdicts_of(evaluate(folder.file("flight.lcm"), over_slot_3, ""));
    const auto found = std::find_if(verdicts.begin(), verdicts.end(), [](const Verdict& each) {
      return each.subject == "Altitude at all heights, vision against laser";
    });
    REQUIRE(found != verdicts.end());
    return *found;
  };
  const Verdict with_truth = verdict(flight);
  CHECK(with_truth.says == Verdict::Says::poor);
  CHECK(with_truth.text == "95 % within 0.80 m, worst 0.80 m (20 frames)");

  flight.truth.clear();
  CHECK(verdict(flight).text ==
        "no data; left out: 20 in which the laser is short of vision, on a thing or not");
}

TEST_CASE("Through two circles a level plane lies midway between them") {
  FlightLog flight = flight_of(1);
  auto& poses = flight.poses[0].poses;
  poses.resize(2);
  poses[0].center_level_m[2] = 4.00;
  poses[1].center_level_m[2] = 4.06;
  const AltitudeComparison result = compare_altitudes(flight, {});
  REQUIRE(result.samples.size() == 1);
  CHECK(result.samples[0].vision_m == Approx(4.03));
}

TEST_CASE("Latencies are good only where nearly all frames have one") {
  const auto verdict = [](int answered) {
    Evaluation evaluation;
    evaluation.flight.report.frames = 1000;
    evaluation.flight.report.answered = answered;
    evaluation.to_mission_ms = spread_of(std::vector<double>(static_cast<std::size_t>(answered), 30.0));
    return verdicts_of(evaluation).back();
  };
  CHECK(verdict(990).says == Verdict::Says::good);
  CHECK(verdict(989).says == Verdict::Says::poor);
  CHECK(verdict(989).text.ends_with("worst 30 ms; 989 of 1000 frames answered"));
}

TEST_CASE("A drop is off its circle as it comes to rest, and its circle was last seen so long before") {
  FlightLog flight = flight_of(120);
  // cargo 2 hangs, is let go over a circle of another platform at 3 s, and stands there 0.3 m north of the
  // middle
  constexpr std::int64_t let_go_us = 3'000'000, covered_us = 2'500'000;
  for (truth_t& truth : flight.truth) {
    truth.circles[3].platform = 1;
    truth_cargo_t& cargo = truth.cargoes[1];
    const bool stands = truth.header.utime >= let_go_us;
    cargo.on_hook = truth.header.utime > 1'500'000 && !stands;
    if (stands) cargo.platform = 1;
    if (stands)
      put(Eigen::Vector3d(truth.circles[3].center_ned_m) + Eigen::Vector3d(0.3, 0, -0.3), cargo.center_ned_m);
  }
  for (poses_t& poses : flight.poses)  // of that circle
    if (poses.header.utime > covered_us)
      poses.poses[3].ellipse_index = -1, poses.poses[3].status = track_t::STATUS_PREDICTED;
  const auto drops = find_drops(flight.truth, compare(flight));
  REQUIRE(drops.size() == 1);
  CHECK(drops[0].cargo == 2);
  CHECK(drops[0].platform == 1);
  CHECK(drops[0].slot == 3);
  CHECK(drops[0].off_m == Approx(0.3));
  REQUIRE(drops[0].unseen_s);
  CHECK(*drops[0].unseen_s == Approx(0.5).margin(0.1));
}

TEST_CASE("evaluate writes a page that needs nothing else, and JSON") {
  const Folder folder;
  write_log(folder.file("flight.lcm"), flight_of(120));
  const ProgramRun run = run_program("$BIN/evaluate " + folder.file("flight.lcm"));
  CHECK(run.status == 0);
  CHECK(run.err.starts_with("No --config, and no config.yaml beside the log"));
  CHECK(run.out.find("good     Track ids") != std::string::npos);
  const auto json = nlohmann::json::parse(text_of(folder.file("evaluation.json")));
  CHECK(json["has_truth"] == true);
  CHECK(json["poses"]["compared"] == 6 * 120);
  CHECK(json["poses"]["all"]["center_error_m"]["worst"].get<double>() < 1e-9);
  const std::string page = text_of(folder.file("evaluation.html"));
  for (const char* loaded : {"http", "<script", "<link", "src=", "nan", "inf"})
    CHECK(page.find(loaded) == std::string::npos);
  CHECK(page.find("<svg") != std::string::npos);
  CHECK(page.find("No cargo was brought") != std::string::npos);

  const ProgramRun twice =
      run_program("$BIN/evaluate " + folder.file("flight.lcm") + " --reference " + folder.file("flight.lcm"));
  CHECK(twice.status == 0);
  const auto both = nlohmann::json::parse(text_of(folder.file("evaluation.json")));
  CHECK(both["reference"]["compared"] == 6 * 120);
  CHECK(both["reference"]["all"]["center_error_m"]["worst"] == 0);
}

TEST_CASE("evaluate tells errors that a camera shares over a flight from others, if it is told which flew") {
  const Folder folder;
  write_log(folder.file("flight.lcm"), flight_of(20));
  const std::string evaluate = "$BIN/evaluate " + folder.file("flight.lcm");
  const auto with_common = [&] {
    return nlohmann::json::parse(
        text_of(folder.file("evaluation.json")))["poses"]["all"]["nees3_with_common_errors"];
  };
  CHECK(run_program(evaluate).status == 0);
  CHECK(with_common().is_null());
  const std::string config = " --config " STEVEDORE_SOURCE_DIR "/config/world.yaml";
  CHECK(run_program(evaluate + config).status == 0);
  CHECK(with_common().is_number());
  CHECK(run_program(evaluate + config + " --set sim.easy=true").status == 0);
  CHECK(with_common().is_null());
  const ProgramRun wrong = run_program(evaluate + config + " --set pose.altimeter_down_m=far");
  CHECK(wrong.status == 2);
  CHECK(wrong.err.find("altimeter_down_m") != std::string::npos);
}

TEST_CASE("A log with PLATFORM_ESTIMATE and no POSES is evaluated, its time from the log's first message") {
  const Folder folder;
  FlightLog flight = flight_of(120);
  flight.poses.clear();
  flight.vehicle.front().header.utime = 0;  // no stamp: no beginning
  LogWriter writer(folder.file("flight.lcm"));
  writer.write({1, "OTHER", std::vector<std::uint8_t>(64, 1)});
  write_all(writer, channels::vehicle_state, flight.vehicle);
  write_all(writer, channels::truth, flight.truth);
  write_all(writer, channels::platform_estimate, flight.estimates);
  writer.flush();
  const Evaluation evaluation = evaluate(folder.file("flight.lcm"), {}, "");
  CHECK(evaluation.flight.start_utime == flight.vehicle[1].header.utime);
  CHECK(to_html(evaluation).ends_with("</html>\n"));
}

TEST_CASE(
    "Of errors that a flight shares only what its covariances lack is added, and an easy world has none") {
  const std::string world = STEVEDORE_SOURCE_DIR "/config/world.yaml";
  const PoseSettings all = aircraft_of({world, {}}).common.value().sigmas;
  CHECK(all.radius_sigma_percent == Approx(0.5));
  CHECK(all.focal_sigma_percent == Approx(0.3));
  CHECK(all.principal_point_sigma_px == Approx(2));
  const PoseSettings rest = aircraft_of({world,
                                         {"pose.radius_sigma_percent=0.3", "pose.focal_sigma_percent=0.3",
                                          "pose.principal_point_sigma_px=3"}})
                                .common.value()
                                .sigmas;
  CHECK(rest.radius_sigma_percent == Approx(0.4));
  CHECK(rest.focal_sigma_percent == 0);
  CHECK(rest.principal_point_sigma_px == 0);

  const Folder folder;
  std::ofstream(folder.file("easy.yaml"))
      << "camera_file: " STEVEDORE_SOURCE_DIR "/config/cameras/world_640x480.yaml\nsim: {easy: true}\n";
  CHECK_FALSE(aircraft_of({folder.file("easy.yaml"), {}}).common);
  CHECK(aircraft_of({folder.file("easy.yaml"), {"sim.easy=false"}}).common);
}

TEST_CASE("Without TRUTH there is the laser, and evaluate says so") {
  const Folder folder;
  FlightLog flight = flight_of(20);
  flight.truth.clear();
  write_log(folder.file("flight.lcm"), flight);
  const ProgramRun run = run_program("$BIN/evaluate " + folder.file("flight.lcm"));
  CHECK(run.status == 0);
  CHECK(run.out.find("No TRUTH") != std::string::npos);
  const std::string page = text_of(folder.file("evaluation.html"));
  CHECK(page.find("no TRUTH") != std::string::npos);
  CHECK(page.find("Altitude: vision against the laser") != std::string::npos);
  CHECK(page.find("Table 1") == std::string::npos);
}

TEST_CASE("evaluate and report write JSON of a log whose name is not UTF-8") {
  const Folder folder;
  const std::string log = folder.file("fl\xffight.lcm");
  write_log(log, flight_of(20));
  CHECK(run_program("$BIN/evaluate " + log).status == 0);
  CHECK_NOTHROW(nlohmann::json::parse(text_of(folder.file("evaluation.json"))));
  const ProgramRun report = run_program("$BIN/report --json " + log);
  CHECK(report.status == 0);
  CHECK_NOTHROW(nlohmann::json::parse(report.out));
}

TEST_CASE("Messages of another version are told") {
  const Folder folder;
  write_log(folder.file("flight.lcm"), flight_of(20));
  const std::string whole = text_of(folder.file("flight.lcm"));
  {
    LogWriter writer(folder.file("flight.lcm"));
    for (const char* channel : {channels::poses.name, channels::altimeter.name, channels::gimbal_state.name})
      writer.write({500'000, channel, {1, 2, 3}});
    writer.flush();
  }
  std::ofstream(folder.file("flight.lcm"), std::ios::binary | std::ios::app) << whole;
  const ProgramRun run = run_program("$BIN/evaluate " + folder.file("flight.lcm"));
  CHECK(run.status == 0);
  CHECK(run.out.find("3 messages in the log can't be read") != std::string::npos);
  CHECK(text_of(folder.file("evaluation.html")).find("3 messages in the log can't") != std::string::npos);
  CHECK(nlohmann::json::parse(text_of(folder.file("evaluation.json")))["unreadable"] == 3);
}

TEST_CASE("A damaged reference is told as a damaged log is") {
  const Folder folder;
  write_log(folder.file("flight.lcm"), flight_of(20));
  write_log(folder.file("other.lcm"), flight_of(20));
  std::filesystem::resize_file(folder.file("other.lcm"),
                               std::filesystem::file_size(folder.file("other.lcm")) - 100);
  const ProgramRun run =
      run_program("$BIN/evaluate " + folder.file("flight.lcm") + " --reference " + folder.file("other.lcm"));
  CHECK(run.status == 1);
  CHECK(run.err.find("other.lcm: ") != std::string::npos);
  CHECK(run.err.find("flight.lcm: ") == std::string::npos);
}

TEST_CASE("A damaged log is evaluated as far as it can be read, with exit status 1") {
  const Folder folder;
  write_log(folder.file("flight.lcm"), flight_of(20));
  std::filesystem::resize_file(folder.file("flight.lcm"),
                               std::filesystem::file_size(folder.file("flight.lcm")) - 100);
  const ProgramRun run = run_program("$BIN/evaluate " + folder.file("flight.lcm"));
  CHECK(run.status == 1);
  CHECK(run.err.find("flight.lcm") != std::string::npos);
  CHECK(text_of(folder.file("evaluation.html")).find("</html>") != std::string::npos);

  std::ofstream(folder.file("nothing.lcm")) << "no log";
  CHECK_THROWS_AS(read_flight(folder.file("nothing.lcm")), std::runtime_error);
  CHECK(run_program("$BIN/evaluate " + folder.file("nothing.lcm")).status == 1);
}
