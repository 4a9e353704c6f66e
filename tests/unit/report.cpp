#include "tools/report_core.hpp"

#include <unistd.h>
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <map>
#include <sstream>

#include "tools/watch_view.hpp"

using namespace stevedore;

namespace {

/// Publishes the way a process does, into a log: numbered by run and channel, stamped.
class SyntheticLog {
 public:
  SyntheticLog()
      : path_(std::filesystem::temp_directory_path() / ("report-test-" + std::to_string(getpid()))) {}
  ~SyntheticLog() { std::filesystem::remove(path_); }
  SyntheticLog(const SyntheticLog&) = delete;
  SyntheticLog& operator=(const SyntheticLog&) = delete;

  template <class M>
  void publish(const Channel<M>& channel, M message, int64_t run_id, int64_t utime, int64_t frame_seq,
               int64_t publish_utime, bool logged = true) {
    message.header.utime = utime;
    message.header.frame_seq = frame_seq;
    message.header.seq = seq_[{channel.name, run_id}]++;
    message.header.trace.run_id = run_id;
    message.header.trace.publish_utime = publish_utime;
    if (!logged) return;
    REQUIRE_FALSE(fault_of(message));
    LogEvent event{publish_utime, channel.name, {}};
    event.bytes.resize(static_cast<size_t>(message.getEncodedSize()));
    message.encode(event.bytes.data(), 0, static_cast<int>(event.bytes.size()));
    events_.push_back(event);
  }
  void add(const LogEvent& event) { events_.push_back(event); }

  [[nodiscard]] Report report() const {
    {
      LogWriter writer(path_.string());
      for (const LogEvent& event : events_) writer.write(event);
    }
    LogSummary summary;
    LogReader reader(path_.string());
    while (const auto event = reader.next()) summary.add(*event);
    return summary.report();
  }

 private:
  std::filesystem::path path_;
  std::map<std::pair<std::string, int64_t>, int64_t> seq_;
  std::vector<LogEvent> events_;
};

frame_t frame() {
  frame_t message{};
  message.width_px = message.height_px = 1;
  message.format = frame_t::FORMAT_GRAY8;
  message.encoding = frame_t::ENCODING_RAW;
  message.data = {0};
  message.size = 1;
  return message;
}

ellipses_t ellipses() {
  ellipses_t message{};
  message.width_px = message.height_px = 1;
  message.search = ellipses_t::SEARCH_FULL;
  return message;
}

tracks_t tracks(int8_t status) {
  tracks_t message{};
  message.width_px = message.height_px = 1;
  message.target_id = -1;
  message.target_status = status;
  return message;
}

poses_t poses() {
  poses_t message{};
  message.target_id = -1;
  message.target_status = track_t::STATUS_TRACKING;
  return message;
}

mission_t mission() {
  mission_t message{};
  message.target_id = message.target_platform = message.target_slot = -1;
  message.target_status = track_t::STATUS_TRACKING;
  message.target_age_s = -1;
  return message;
}

input_health_t input(const std::string& channel, int64_t received) {
  input_health_t health{};
  health.channel = channel;
  health.received = health.handled = received;
  health.age_p50_ms = health.age_p99_ms = -1;
  return health;
}

health_t health(const std::string& process, std::vector<input_health_t> inputs,
                const std::string& output_channel, int64_t published, int8_t state = health_t::STATE_OK) {
  health_t message{};
  message.process = process;
  message.state = state;
  message.inputs = std::move(inputs);
  message.input_count = static_cast<int16_t>(message.inputs.size());
  output_health_t output{};
  output.channel = output_channel;
  output.published = published;
  message.outputs = {output};
  message.output_count = 1;
  return message;
}

enum Run : int64_t { camera = 11, detector = 12, tracker = 13, pose = 14, mission_run = 15, again = 99 };

/// Microseconds that each stage takes with frame k; all different, so that a mix-up shows.
constexpr int64_t camera_us = 200, detector_us = 5000, tracker_us = 2000, pose_us = 300, mission_us = 100;
constexpr int64_t line_us = camera_us + detector_us + tracker_us + pose_us + mission_us;
constexpr int64_t period_us = 33'000;

int64_t capture_utime(int64_t k) {
  return 1'000'000 + k * period_us;
}

void publish_line(SyntheticLog& log, int64_t k, int8_t status = track_t::STATUS_TRACKING) {
  const int64_t utime = capture_utime(k);
  int64_t now = utime + camera_us;
  log.publish(channels::frame, frame(), camera, utime, k, now);
  log.publish(channels::ellipses, ellipses(), detector, utime, k, now += detector_us);
  log.publish(channels::tracks, tracks(status), tracker, utime, k, now += tracker_us);
  log.publish(channels::poses, poses(), pose, utime, k, now += pose_us);
  log.publish(channels::mission, mission(), mission_run, utime, k, now += mission_us);
}

void publish_health(SyntheticLog& log, const health_t& message, int64_t run_id, int64_t utime) {
  log.publish(channels::health, message, run_id, utime, -1, utime);
}

const StageReport& stage(const Report& report, const std::string& process) {
  for (const StageReport& s : report.stages) {
    if (s.process == process) return s;
  }
  FAIL("no stage " << process);
  throw 0;
}

void check_latency(const std::optional<Percentiles>& latency, double p50_ms, double p99_ms) {
  REQUIRE(latency);
  CHECK(latency->p50_ms == Approx(p50_ms));
  CHECK(latency->p99_ms == Approx(p99_ms));
}

}  // namespace

TEST_CASE("percentiles are nearest ranks") {
  CHECK_FALSE(percentiles_of({}));
  check_latency(percentiles_of({7000}), 7, 7);
  std::vector<int64_t> values_us;
  for (int i = 100; i >= 0; --i) values_us.push_back(i * 1000);
  check_latency(percentiles_of(values_us), 50, 99);
}

TEST_CASE("a clean run: every frame answered, stage latencies add up to the whole") {
  SyntheticLog log;
  for (int64_t k = 0; k < 10; ++k)
    publish_line(log, k, k < 3 ? track_t::STATUS_SEARCHING : track_t::STATUS_TRACKING);
  const int64_t end = capture_utime(10);
  publish_health(log, health("camera_proc", {}, "FRAME", 10, health_t::STATE_FINISHED), camera, end);
  publish_health(log, health("detector_proc", {input("FRAME", 10)}, "ELLIPSES", 10), detector, end);
  publish_health(log, health("tracker_proc", {input("ELLIPSES", 10), input("FRAME", 10)}, "TRACKS", 10),
                 tracker, end);
  publish_health(log, health("pose_proc", {input("TRACKS", 10)}, "POSES", 10), pose, end);
  publish_health(log, health("mission_proc", {input("POSES", 10)}, "MISSION", 10), mission_run, end);
  const Report report = log.report();
  CHECK(report.frames == 10);
  CHECK(report.answered == 10);
  CHECK(report.tracked == 7);
  CHECK(report.frames_lost == 0);
  CHECK(report.frames_skipped == 0);
  CHECK(report.missing_in_log == 0);
  CHECK(report.unreadable == 0);
  CHECK(report.duration_s == Approx(static_cast<double>(10 * period_us - camera_us) * 1e-6));
  check_latency(report.latency, line_us * 1e-3, line_us * 1e-3);
  double sum_ms = 0;
  for (const StageReport& s : report.stages) {
    INFO(s.process);
    CHECK(s.in == 10);
    CHECK(s.out == 10);
    CHECK(s.lost == 0);
    CHECK(s.restarts == 0);
    REQUIRE(s.latency);
    sum_ms += s.latency->p50_ms;
  }
  CHECK(sum_ms == Approx(line_us * 1e-3));
  check_latency(stage(report, "detector_proc").latency, 5, 5);
  check_latency(stage(report, "camera_proc").latency, 0.2, 0.2);
}

TEST_CASE("losses and skips are those of the newest HEALTH, on the inputs that carry frames") {
  SyntheticLog log;
  for (int64_t k = 0; k < 5; ++k) publish_line(log, k);
  auto in = input("FRAME", 4);
  in.lost_gap = 1;
  publish_health(log, health("detector_proc", {in}, "ELLIPSES", 3), detector, capture_utime(4));
  in = input("FRAME", 8);
  in.lost_gap = 1;
  in.lost_malformed = 2;
  in.skipped = 3;
  auto newest = health("detector_proc", {in}, "ELLIPSES", 5);
  newest.kernel_drops = 4;
  publish_health(log, newest, detector, capture_utime(5));
  auto overwritten = input("FRAME", 5);
  overwritten.lost_overwritten = 1;
  auto stale = input("ELLIPSES", 5);
  stale.lost_stale = 1;
  auto command = input("TRACK_COMMAND", 5);  // carries no frame
  command.lost_gap = 50;
  publish_health(log, health("tracker_proc", {stale, overwritten, command}, "TRACKS", 5), tracker,
                 capture_utime(5));
  const Report report = log.report();
  CHECK(stage(report, "detector_proc").in == 8);
  CHECK(stage(report, "detector_proc").out == 5);
  CHECK(stage(report, "detector_proc").lost == 3);
  CHECK(stage(report, "detector_proc").skipped == 3);
  CHECK(stage(report, "detector_proc").kernel_drops == 4);
  CHECK(stage(report, "tracker_proc").in == 5);
  CHECK(stage(report, "tracker_proc").lost == 2);
  CHECK(report.frames_lost == 5);
  CHECK(report.frames_skipped == 3);
  CHECK(stage(report, "tracker_proc").missed == 1);  // without its frame it answers all the same
}

TEST_CASE("the camera's own input: what could not be read is lost, what came too fast is skipped") {
  SyntheticLog log;
  for (int64_t k = 0; k < 5; ++k) publish_line(log, k);
  auto source = input("camera", 9);
  source.handled = 5;
  source.lost_malformed = 1;
  source.skipped = 3;
  publish_health(log, health("camera_proc", {source}, "FRAME", 5), camera, capture_utime(5));
  const Report report = log.report();
  CHECK(stage(report, "camera_proc").in == 9);
  CHECK(stage(report, "camera_proc").out == 5);
  CHECK(stage(report, "camera_proc").lost == 1);
  CHECK(stage(report, "camera_proc").skipped == 3);
  CHECK(report.frames == 5);
  CHECK(to_text(report).find("1 images could not be read or sent") != std::string::npos);
}

TEST_CASE("a restarted process is the sum of its runs, with what it did after its last HEALTH") {
  SyntheticLog log;
  const auto ellipses_of = [&log](int64_t run_id, int64_t k) {
    log.publish(channels::ellipses, ellipses(), run_id, capture_utime(k), k,
                capture_utime(k) + camera_us + detector_us);
  };
  for (int64_t k = 0; k < 10; ++k) {
    log.publish(channels::frame, frame(), camera, capture_utime(k), k, capture_utime(k) + camera_us);
  }
  for (int64_t k = 0; k < 4; ++k) ellipses_of(detector, k);
  publish_health(log, health("detector_proc", {input("FRAME", 4)}, "ELLIPSES", 4), detector,
                 capture_utime(4));
  for (int64_t k = 4; k < 6; ++k) ellipses_of(detector, k);  // then it is killed
  for (int64_t k = 8; k < 10; ++k) ellipses_of(again, k);
  auto in = input("FRAME", 2);
  in.lost_gap = 1;
  publish_health(log, health("detector_proc", {in}, "ELLIPSES", 2), again, capture_utime(10));
  const Report report = log.report();
  const StageReport& s = stage(report, "detector_proc");
  CHECK(s.restarts == 1);
  CHECK(s.in == 8);
  CHECK(s.out == 8);
  CHECK(s.lost == 1);
  CHECK(stage(report, "tracker_proc").restarts == 0);
  CHECK(report.frames == 10);
  CHECK(report.unexplained == 9);  // nothing came out of the line, one is explained
  check_latency(s.latency, 5, 5);
}

TEST_CASE("a restarted camera counts its frames from zero again, logged or not") {
  SyntheticLog log;
  for (int64_t k = 0; k < 3; ++k) {
    log.publish(channels::frame, frame(), camera, capture_utime(k), k, capture_utime(k) + 1, k != 1);
  }
  for (int64_t k = 0; k < 4; ++k) {
    log.publish(channels::frame, frame(), again, capture_utime(9 + k), k, capture_utime(9 + k) + 1, k != 1);
  }
  const Report report = log.report();
  CHECK(report.frames == 7);
  CHECK(report.missing_in_log == 2);
  CHECK(stage(report, "camera_proc").restarts == 1);
}

TEST_CASE("without HEALTH the log is counted and losses are unknown, not zero") {
  SyntheticLog log;
  for (int64_t k = 0; k < 3; ++k) publish_line(log, k);
  log.publish(channels::frame, frame(), camera, capture_utime(3), 3, capture_utime(3) + camera_us);
  const Report report = log.report();
  CHECK(stage(report, "detector_proc").in == 4);
  CHECK(stage(report, "detector_proc").out == 3);
  CHECK_FALSE(stage(report, "detector_proc").lost);
  CHECK(stage(report, "camera_proc").in == 4);
  const auto json = to_json(report, "a.log");
  CHECK(json["stages"]["detector_proc"]["lost"].is_null());
  CHECK(to_text(report).find("No HEALTH, so losses not known: camera_proc, detector_proc") !=
        std::string::npos);
}

TEST_CASE("a MISSION that time alone caused answers no frame") {
  SyntheticLog log;
  publish_line(log, 0);
  log.publish(channels::mission, mission(), mission_run, capture_utime(40), -1, capture_utime(40) + 900'000);
  publish_health(log, health("mission_proc", {input("POSES", 1)}, "MISSION", 2), mission_run,
                 capture_utime(41));
  log.publish(channels::mission, mission(), mission_run, capture_utime(80), -1, capture_utime(80) + 900'000);
  const Report report = log.report();
  CHECK(report.answered == 1);
  CHECK(stage(report, "mission_proc").in == 1);
  CHECK(stage(report, "mission_proc").out == 1);
  check_latency(report.latency, line_us * 1e-3, line_us * 1e-3);
}

TEST_CASE("what the log lacks and what can't be read is said") {
  SyntheticLog log;
  for (int64_t k = 0; k < 6; ++k) {
    log.publish(channels::frame, frame(), camera, capture_utime(k), k, capture_utime(k) + camera_us,
                k != 2 && k != 3);
  }
  log.add({capture_utime(7), "POSES", {1, 2, 3}});
  log.add({capture_utime(7), "SOMETHING_ELSE", {1, 2, 3}});
  const Report report = log.report();
  CHECK(report.frames == 6);
  CHECK(report.missing_in_log == 2);
  CHECK(report.unreadable == 1);
}

TEST_CASE("the world in place of the camera: its drops, and the processes beside the line") {
  SyntheticLog log;
  for (const int64_t tick : {0, 1, 4, 5, 7}) {
    log.publish(channels::frame, frame(), camera, capture_utime(tick), tick, capture_utime(tick) + camera_us);
  }
  log.publish(channels::frame, frame(), again, capture_utime(20), 1, capture_utime(20) + camera_us);
  auto sim = health("sim_proc", {input("GIMBAL_COMMAND", 9)}, "FRAME", 5);
  sim.inputs[0].lost_gap = 2;
  sim.cpu_share = 0.9;
  publish_health(log, sim, camera, capture_utime(8));  // the first has no second behind it
  sim.cpu_share = 0.4;
  publish_health(log, sim, camera, capture_utime(9));
  sim.cpu_share = 0.6;
  publish_health(log, sim, camera, capture_utime(10));
  publish_health(log, health("gimbal_proc", {input("VEHICLE_STATE", 50)}, "GIMBAL_LEVEL", 50), mission_run,
                 capture_utime(10));
  const Report report = log.report();
  CHECK(report.camera_drops == 3 + 1);
  CHECK(report.messages_lost == 2);
  CHECK(report.frames_lost == 0);
  CHECK(stage(report, "sim_proc").out == 6);
  CHECK(stage(report, "sim_proc").cpu_share.value() == Approx(0.5));
  REQUIRE(report.beside.size() == 1);
  CHECK(report.beside[0].process == "gimbal_proc");
  CHECK(report.beside[0].in == 50);
  CHECK(report.beside[0].out == 50);
  const auto json = to_json(report, "a.log");
  CHECK(json["camera_drops"] == 4);
  CHECK(json["cpu_share"]["sim_proc"] == Approx(0.5));
  CHECK(json["beside"]["gimbal_proc"]["restarts"] == 0);
  CHECK_FALSE(json["stages"].contains("camera_proc"));
  CHECK(to_text(report).find("4 camera drops") != std::string::npos);
  CHECK(to_text(report).find("2 messages that carry no frame were lost") != std::string::npos);
}

TEST_CASE("an empty log is a report of nothing") {
  const Report report = SyntheticLog().report();
  CHECK(report.frames == 0);
  CHECK(report.duration_s == 0);
  CHECK_FALSE(report.latency);
  CHECK(to_json(report, "a.log")["latency_ms"]["p50"].is_null());
}

TEST_CASE("report.json has the promised fields, the table fits 100 columns") {
  SyntheticLog log;
  for (int64_t k = 0; k < 3; ++k) publish_line(log, k);
  log.add({capture_utime(3), "POSES", {1}});
  const Report report = log.report();
  const auto json = to_json(report, "a.log");
  for (const char* key :
       {"frames", "frames_lost", "frames_skipped", "tracked", "latency_ms", "stages", "duration_s", "log"}) {
    CHECK(json.contains(key));
  }
  for (const StageLine& line : stage_lines) {
    for (const char* key : {"in", "out", "lost", "skipped", "restarts", "latency_ms"}) {
      CHECK(json["stages"][line.process].contains(key));
    }
    CHECK(json["stages"][line.process]["latency_ms"].contains("p99"));
  }
  std::istringstream text(to_text(report));
  for (std::string row; std::getline(text, row);) CHECK(row.size() <= 100);
}

namespace {

header_t header(int64_t run_id, int64_t seq, int64_t utime, int64_t frame_seq) {
  header_t h{};
  h.trace.run_id = run_id;
  h.seq = seq;
  h.utime = utime;
  h.frame_seq = frame_seq;
  return h;
}

void camera_says(WatchView& view, int64_t run_id, int64_t seq, int64_t published, int8_t state, int64_t now) {
  auto message = health("camera_proc", {}, "FRAME", published, state);
  message.header = header(run_id, seq, now, -1);
  view.on_health(message, now);
}

void mission_says(WatchView& view, int64_t frame_seq, int64_t utime, int64_t now) {
  auto message = mission();
  message.header = header(mission_run, frame_seq, utime, frame_seq);
  view.on_mission(message, now);
}

constexpr int64_t second = 1'000'000;

}  // namespace

TEST_CASE("worked off: the camera has finished and its newest frame came out") {
  WatchView view(0);
  camera_says(view, 1, 0, 3, health_t::STATE_OK, second);
  for (int64_t k = 0; k < 3; ++k) mission_says(view, k, second, second + 5000);
  CHECK_FALSE(view.worked_off(second + 5000));
  camera_says(view, 1, 1, 4, health_t::STATE_FINISHED, 2 * second);
  CHECK_FALSE(view.worked_off(2 * second));
  mission_says(view, 3, 2 * second, 2 * second + 5000);
  CHECK(view.worked_off(2 * second + 5000));
}

TEST_CASE("worked off: a last frame that never comes is waited for, not for ever") {
  WatchView view(0);
  mission_says(view, 0, second, second);
  camera_says(view, 1, 0, 2, health_t::STATE_FINISHED, second);
  CHECK_FALSE(view.worked_off(2 * second));
  CHECK(view.worked_off(3 * second));
}

TEST_CASE("worked off: the world's newest frame counts, whatever it dropped before") {
  WatchView view(0);
  const auto sim_says = [&view](int64_t seq, int8_t state, int64_t now) {
    auto message = health("sim_proc", {}, "FRAME", 3, state);
    message.header = header(1, seq, now, -1);
    view.on_health(message, now);
  };
  sim_says(0, health_t::STATE_OK, second);
  view.on_frame(header(1, 0, second, 0));
  view.on_frame(header(1, 1, second, 4));
  view.on_frame(header(1, 2, second, 6));
  mission_says(view, 0, second, second);
  mission_says(view, 4, second, second);
  sim_says(1, health_t::STATE_FINISHED, 2 * second);
  CHECK_FALSE(view.worked_off(2 * second));
  CHECK(view.line(2 * second).find("camera drops 4") != std::string::npos);
  mission_says(view, 6, 2 * second, 2 * second);
  CHECK(view.worked_off(2 * second));
}

TEST_CASE("a finished camera without one answer is not worked off") {
  WatchView view(0);
  camera_says(view, 1, 0, 4, health_t::STATE_FINISHED, second);
  auto idle = mission();
  idle.header = header(mission_run, 0, second, -1);
  view.on_mission(idle, second);
  CHECK_FALSE(view.worked_off(30 * second));
  CHECK(view.silent_s(30 * second) == Approx(30));
}

TEST_CASE("a camera that ended without a frame is not waited for") {
  WatchView view(0);
  camera_says(view, 1, 0, 0, health_t::STATE_FAILED, second);
  CHECK_FALSE(view.ended_without_frames());
  camera_says(view, 1, 1, 0, health_t::STATE_FINISHED, 2 * second);
  CHECK(view.ended_without_frames());
  WatchView played(0);
  camera_says(played, 1, 0, 3, health_t::STATE_FINISHED, second);
  CHECK_FALSE(played.ended_without_frames());
}

TEST_CASE("answers to an earlier run of the camera don't count for this one") {
  WatchView view(0);
  camera_says(view, 1, 0, 9, health_t::STATE_OK, second);
  mission_says(view, 8, second, second);
  camera_says(view, 2, 0, 4, health_t::STATE_FINISHED, 2 * second);
  CHECK_FALSE(view.worked_off(2 * second));
  mission_says(view, 3, 2 * second, 2 * second);
  CHECK(view.worked_off(2 * second));
}

TEST_CASE("silence names who is silent") {
  WatchView view(0);
  CHECK(view.silence(second) ==
        "No HEALTH from camera_proc, detector_proc, tracker_proc, pose_proc, mission_proc.");
  const auto all_say = [&view](int64_t now) {
    for (const StageLine& line : stage_lines) view.on_health(health(line.process, {}, line.output, 0), now);
  };
  all_say(second);
  CHECK(view.silence(2 * second) == "Every process is there, but camera_proc published no FRAME.");
  camera_says(view, 1, 0, 30, health_t::STATE_OK, second);
  view.on_ellipses(ellipses(), 2 * second);
  CHECK(view.silence(2 * second) == "Every process is there, but no TRACKS comes from tracker_proc.");
  view.on_health(health("pose_proc", {}, "POSES", 0), 9 * second);
  CHECK(view.silence(9 * second) == "No HEALTH from camera_proc, detector_proc, tracker_proc, mission_proc.");
}

TEST_CASE("the line sums what all processes lost, over their runs") {
  WatchView view(0);
  auto in = input("FRAME", 5);
  in.lost_gap = 2;
  in.skipped = 7;
  auto message = health("detector_proc", {in}, "ELLIPSES", 5);
  message.header.trace.run_id = 1;
  view.on_health(message, second);
  message.header.trace.run_id = 2;
  view.on_health(message, second);
  mission_says(view, 0, second - 9000, second);
  mission_says(view, 1, second - 9000, second);
  const std::string line = view.line(2 * second);
  INFO(line);
  CHECK(line.find("lost 4  skipped 14") != std::string::npos);
  CHECK(line.find("frames 2/2") != std::string::npos);
  CHECK(line.find("1.0/s") != std::string::npos);
  CHECK(line.find("9/9 ms") != std::string::npos);
  CHECK(view.line(3 * second).find("0.0/s") != std::string::npos);
}

TEST_CASE("a process in trouble is told once, and once when it is well again") {
  WatchView view(0);
  auto message = health("pose_proc", {}, "POSES", 0, health_t::STATE_DEGRADED);
  message.message = "no camera file";
  view.on_health(message, second);
  view.on_health(message, 2 * second);
  CHECK(view.take_news() == std::vector<std::string>{"pose_proc degraded: no camera file"});
  message.state = health_t::STATE_OK;
  view.on_health(message, 3 * second);
  CHECK(view.take_news() == std::vector<std::string>{"pose_proc is well again"});
}

TEST_CASE("a mission that flew is told: by itself, and by TRUTH") {
  SyntheticLog log;
  const auto truth = [](std::vector<int> platforms, double off_m) {
    truth_t message{};
    message.circles.resize(1);
    message.circle_count = 1;
    message.circles[0].platform = 1;
    message.circles[0].slot = 2;
    message.circles[0].radius_m = 0.5;
    message.circles[0].normal_ned[2] = -1;
    for (const int platform : platforms) {
      truth_cargo_t cargo{};
      cargo.index = static_cast<int16_t>(message.cargoes.size());
      cargo.platform = static_cast<int16_t>(platform);
      cargo.slot = platform == 1 ? 2 : 0;
      cargo.center_ned_m[0] = off_m;
      cargo.axis_ned[2] = -1;
      cargo.radius_m = 0.16;
      message.cargoes.push_back(cargo);
    }
    message.cargo_count = static_cast<int16_t>(message.cargoes.size());
    message.ned_from_body[0] = message.ned_from_camera[0] = 1;
    return message;
  };
  const auto flown = [](int8_t phase, int16_t delivered) {
    mission_t message = mission();
    message.has_setpoint = true;
    message.phase = phase;
    message.delivered = delivered;
    message.attempts = 3;
    return message;
  };
  for (int64_t k = 0; k < 4; ++k) publish_line(log, k);
  CHECK_FALSE(log.report().mission);
  log.publish(channels::truth, truth({0, 0, 1}, 0), camera, 1'000'000, 0, 1'000'000);
  log.publish(channels::mission, flown(mission_t::PHASE_SEARCH, 0), again, 2'000'000, -1, 2'000'000);
  log.publish(channels::mission, flown(mission_t::PHASE_COMPLETE, 1), again, 62'000'000, -1, 62'000'000);
  log.publish(channels::mission, flown(mission_t::PHASE_COMPLETE, 1), again, 70'000'000, -1, 70'000'000);
  log.publish(channels::truth, truth({1, 0, 1}, 0.07), camera, 70'000'000, 1, 70'000'000);
  const auto report = log.report();
  REQUIRE(report.mission);
  CHECK(report.mission->phase == "complete");
  CHECK(report.mission->told_delivered == 1);
  CHECK(report.mission->attempts == 3);
  CHECK(report.mission->flown_s == Approx(60));
  REQUIRE(report.mission->brought);
  REQUIRE(report.mission->brought->size() == 1);  // the third cargo stood there from the start
  CHECK(report.mission->brought->front().off_m == Approx(0.07));
  CHECK(report.mission->brought->front().cargo == 0);
  CHECK(to_json(report, "log")["delivered"] == 1);
  CHECK(to_text(report).find("1 delivered in 3 attempts") != std::string::npos);
}

TEST_CASE("report.json of a mission has the promised fields, also of one that did nothing") {
  Report report;
  report.mission.emplace();
  report.stages.resize(1);
  const auto json = to_json(report, "a.log");
  for (const char* key : {"delivered", "attempts", "duration_s", "drop_error_m", "altitude_error_below_2m_m",
                          "altitude_share", "emergencies", "camera_drops"})
    CHECK(json.contains(key));
  for (const char* key : {"p50", "p99", "max"}) CHECK(json["altitude_error_below_2m_m"][key].is_null());
  for (const char* key : {"measured", "predicted", "none"}) CHECK(json["altitude_share"][key].is_null());
  CHECK(json["emergencies"].is_array());
}

TEST_CASE("without TRUTH what was delivered is as told, and no drop error is known") {
  SyntheticLog log;
  publish_line(log, 0);
  mission_t message = mission();
  message.has_setpoint = true;
  message.delivered = 2;
  log.publish(channels::mission, message, again, 2'000'000, -1, 2'000'000);
  const auto json = to_json(log.report(), "a.log");
  CHECK(json["delivered"] == 2);
  CHECK(json["drop_error_m"].is_null());
}

TEST_CASE("emergencies: from the first MISSION that tells to the first that does not") {
  SyntheticLog log;
  publish_line(log, 0);  // the log begins at capture_utime(0) + camera_us
  const auto tell = [&log](double log_s, const std::vector<int16_t>& kinds) {
    mission_t message = mission();
    message.has_setpoint = true;
    for (const int16_t kind : kinds) {
      emergency_t emergency{};
      emergency.kind = kind;
      emergency.cause = "at " + std::to_string(std::lround(log_s));
      message.emergencies.push_back(emergency);
    }
    message.emergency_count = static_cast<int16_t>(kinds.size());
    const int64_t utime = capture_utime(0) + camera_us + std::llround(log_s * 1e6);
    log.publish(channels::mission, message, again, utime, -1, utime);
  };
  constexpr int16_t lost = emergency_t::KIND_TARGET_LOST, stale = emergency_t::KIND_VISION_STALE;
  tell(1, {});
  tell(2, {lost});
  tell(3, {stale, lost});
  tell(5, {stale});
  tell(7, {lost, stale});
  const int64_t end_utime = capture_utime(0) + camera_us + 8 * second;
  publish_health(log, health("sim_proc", {}, "FRAME", 1, health_t::STATE_FINISHED), camera, end_utime);
  tell(9, {lost, stale, emergency_t::KIND_GIMBAL_NOT_LEVEL});  // the set is being stopped
  const auto json = to_json(log.report(), "a.log")["emergencies"];
  REQUIRE(json.size() == 3);
  CHECK(json[0]["kind"] == "target lost");
  CHECK(json[0]["cause"] == "at 2");
  CHECK(json[0]["raised_s"] == Approx(2));
  CHECK(json[0]["cleared_s"] == Approx(5));
  CHECK(json[1]["kind"] == "vision stale");
  CHECK(json[1]["raised_s"] == Approx(3));
  CHECK(json[1]["cleared_s"].is_null());
  CHECK(json[2]["raised_s"] == Approx(7));
  CHECK(to_text(log.report()).find("target lost, 2 times") != std::string::npos);
}

namespace {

/// Frames over a deck that leans by a tenth towards the east: its circle 2 lies 1 m east of the camera, so
/// that the plane is 0.1 m higher there than straight below.
class Descent {
 public:
  /// Straight down to the plane, in truth and as told; told_m nothing: MISSION has no place of the target.
  void frame(double true_m, std::optional<double> told_m, int8_t phase, bool seen = true,
             bool answered = true) {
    const int64_t k = next_++, utime = capture_utime(k), publish_utime = utime + line_us;
    vehicle_state_t vehicle{};
    vehicle.ned_from_body[0] = vehicle.ned_from_body[3] = std::sqrt(0.5);  // eastwards
    log_.publish(channels::vehicle_state, vehicle, camera, utime, -1, utime);
    truth_t truth{};
    truth.circles.resize(1);
    truth.circle_count = 1;
    truth_circle_t& circle = truth.circles[0];
    circle.platform = 1;
    circle.slot = 2;
    circle.radius_m = 0.5;
    circle.center_ned_m[0] = 10;
    circle.center_ned_m[1] = 1;
    circle.center_ned_m[2] = -0.1;
    put_normal(circle.normal_ned);
    truth.camera_ned_m[0] = 10;
    truth.camera_ned_m[2] = -true_m;
    truth.ned_from_body[0] = truth.ned_from_camera[0] = 1;
    log_.publish(channels::truth, truth, camera, utime, k, utime);
    platform_estimate_t estimate{};
    estimate.platform = 1;
    estimate.measured_utime = utime;
    estimate.seen_utime = seen ? utime : 0;
    estimate.roll_rad = -std::atan(0.1);
    log_.publish(channels::platform_estimate, estimate, pose, utime, k, utime);
    if (!answered) return;
    mission_t message = mission();
    message.has_setpoint = true;
    message.phase = phase;
    message.has_target_level = told_m.has_value();
    if (told_m) {
      message.target_platform = 1;
      message.target_slot = 2;
      message.target_level_m[1] = -2;  // ahead, a metre off the circle: as good a point of the plane
      message.target_level_m[2] = *told_m - 0.2;
    }
    // later than the next prediction, as when the line is late
    log_.publish(channels::mission, message, again, utime, k, publish_utime);
  }
  [[nodiscard]] LowAltitude sum_up() const { return log_.report().mission.value().low_altitude; }

 private:
  static void put_normal(double (&normal)[3]) {
    const double length = std::hypot(1, 0.1);
    normal[1] = -0.1 / length;
    normal[2] = -1 / length;
  }

  SyntheticLog log_;
  int64_t next_ = 0;
};

}  // namespace

TEST_CASE("altitude below 2 m: against the leaning plane, from descend to the end of the climb") {
  Descent descent;
  descent.frame(1.5, 1.9, mission_t::PHASE_APPROACH);      // not yet
  descent.frame(2.5, 2.9, mission_t::PHASE_DESCEND);       // too high
  descent.frame(1.9, 1.93, mission_t::PHASE_DESCEND);      // 0.03
  descent.frame(1.2, 1.15, mission_t::PHASE_LOAD, false);  // 0.05, predicted
  descent.frame(1.3, std::nullopt, mission_t::PHASE_LOAD);
  descent.frame(1.3, 1.3, mission_t::PHASE_LOAD, true, false);  // no MISSION
  descent.frame(1.4, 1.39, mission_t::PHASE_VERIFY_LOAD);       // 0.01
  descent.frame(1.5, 1.7, mission_t::PHASE_TRANSIT);            // over
  const LowAltitude low = descent.sum_up();
  CHECK(low.measured == 2);
  CHECK(low.predicted == 1);
  CHECK(low.none == 2);
  REQUIRE(low.errors_m.size() == 3);
  CHECK(low.errors_m[0] == Approx(0.01));
  CHECK(low.errors_m[1] == Approx(0.03));
  CHECK(low.errors_m[2] == Approx(0.05));
  CHECK(low.error_m(0.5) == Approx(0.03));
  CHECK(low.error_m(1) == Approx(0.05));
  CHECK(low.share(low.none) == Approx(0.4));
}

TEST_CASE("a watched mission: its line, and its end") {
  WatchView view(0, 4);
  const auto says = [&view](int8_t phase, bool flies, int64_t now) {
    mission_t message = mission();
    message.header = header(mission_run, 0, now, -1);
    message.phase = phase;
    message.has_setpoint = flies;
    message.delivered = 2;
    message.target_platform = 1;
    message.target_slot = 3;
    view.on_mission(message, now);
  };
  says(mission_t::PHASE_IDLE, false, 0);
  CHECK_FALSE(view.mission_over(9 * second));
  says(mission_t::PHASE_DROP, true, 10 * second);
  CHECK(view.line(10 * second).find("drop         delivered 2/4  target 1.3") != std::string::npos);
  says(mission_t::PHASE_COMPLETE, false, 11 * second);
  CHECK_FALSE(view.mission_over(12 * second));  // the log has its end, too
  CHECK(view.mission_over(13 * second));
  says(mission_t::PHASE_SEARCH, true, 14 * second);
  CHECK_FALSE(view.mission_over(20 * second));
  says(mission_t::PHASE_IDLE, false, 20 * second);  // somebody else has landed it
  CHECK(view.mission_over(22 * second));
  WatchView film(0);
  auto message = mission();
  message.phase = mission_t::PHASE_COMPLETE;
  film.on_mission(message, second);
  CHECK_FALSE(film.mission_over(30 * second));
}
