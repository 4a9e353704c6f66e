// The program `replay`: what it reads, what it refuses, and that no file is lost by it.
#include <catch2/catch.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "runtime/event_log.hpp"
#include "runtime/frame_codec.hpp"
#include "tests/support/program.hpp"

using namespace stevedore;
namespace fs = std::filesystem;

namespace {

const std::string golden_log = STEVEDORE_SOURCE_DIR "/logs/film.lcm";
const std::string config = " --config " STEVEDORE_SOURCE_DIR "/config/film.yaml ";

/// The golden log with every frame changed.
template <class Change>
std::string with_frames(const Folder& folder, const Change& change) {
  LogReader reader(golden_log);
  LogWriter writer(folder.file("changed.lcm"));
  while (auto event = reader.next()) {
    if (auto frame = decode(*event, channels::frame)) {
      change(*frame);
      event->bytes = encode(*frame);
    }
    writer.write(*event);
  }
  writer.flush();
  return folder.file("changed.lcm");
}

ProgramRun replay_as_flown(const Folder& folder, const std::string& log) {
  return run_program("$BIN/replay " + log + config + "--as-flown --out " + folder.file("out.lcm"));
}

bool says(const ProgramRun& run, const std::string& text) {
  INFO(run.out << run.err);
  CHECK((run.out + run.err).find(text) != std::string::npos);
  return (run.out + run.err).find(text) != std::string::npos;
}

std::vector<std::string> files_in(const Folder& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder.file(""))) names.push_back(entry.path().filename());
  std::sort(names.begin(), names.end());
  return names;
}

}  // namespace

TEST_CASE("a log that can't be read costs the log of an earlier replay nothing") {
  const Folder folder;
  std::ofstream(folder.file("out.lcm")) << "an earlier replay";
  std::ofstream(folder.file("text.lcm")) << "no log";
  for (const auto& [log, why] : {std::pair<std::string, std::string>{"mistyped.lcm", "No such file"},
                                 {"", "directory"},
                                 {"text.lcm", "no message of this system"}}) {
    const auto run = run_program("$BIN/replay " + folder.file(log) + " --out " + folder.file("out.lcm"));
    CHECK(run.status == 1);
    CHECK(says(run, why));
    CHECK(text_of(folder.file("out.lcm")) == "an earlier replay");
  }
  CHECK(files_in(folder) == std::vector<std::string>{"out.lcm", "text.lcm"});
}

TEST_CASE("what is read is not written") {
  const Folder folder;
  fs::copy_file(golden_log, folder.file("log.lcm"));
  fs::create_hard_link(folder.file("log.lcm"), folder.file("link.lcm"));
  for (const std::string out : {"log.lcm", "link.lcm", "../log.lcm"}) {
    fs::create_directory(folder.file("x"));
    const std::string path = out[0] == '.' ? folder.file("x/" + out) : folder.file(out);
    const auto run = run_program("$BIN/replay " + folder.file("log.lcm") + config + "--out " + path);
    CHECK(run.status == 2);
    CHECK(says(run, "which is read"));
    fs::remove(folder.file("x"));
  }
  CHECK(text_of(folder.file("log.lcm")) == text_of(golden_log));
  CHECK(run_program("$BIN/replay " + golden_log + config + "--out " + folder.file("")).status == 2);
}

TEST_CASE("a replay replaces an earlier one and leaves nothing else") {
  const Folder folder;
  std::ofstream(folder.file("out.lcm")) << "an earlier replay";
  const auto run = replay_as_flown(folder, golden_log);
  CHECK(run.status == 0);
  CHECK(says(run, "as flown"));
  CHECK(files_in(folder) == std::vector<std::string>{"out.lcm"});
  CHECK(fs::file_size(folder.file("out.lcm")) > 1'000'000);
  CHECK(run_program("$BIN/replay " + golden_log + config + "--out /dev/null").status == 0);
  CHECK(fs::is_character_file("/dev/null"));
}

TEST_CASE("damage is told with its place and is never as flown") {
  const Folder folder;
  fs::copy_file(golden_log, folder.file("log.lcm"));
  const auto size = static_cast<int64_t>(fs::file_size(golden_log));
  LogReader reader(golden_log);
  while (reader.next() && reader.position() < size / 2) {
  }
  const int64_t damaged = reader.position();
  for (const char* length : {"\x7f\xff\xff\xff", "\xff\xff\xff\xff"}) {
    std::fstream(folder.file("log.lcm"), std::ios::in | std::ios::out).seekp(damaged + 24).write(length, 4);
    const auto flown = replay_as_flown(folder, folder.file("log.lcm"));
    CHECK(flown.status == 1);
    CHECK(says(flown, "damaged at byte " + std::to_string(damaged)));
    CHECK(says(flown, "NOT as flown"));
    for (const std::string& command :
         {"replay " + folder.file("log.lcm") + config + "--every-frame --out " + folder.file("out.lcm"),
          "report " + folder.file("log.lcm"),
          "overlay " + folder.file("log.lcm") + " --frames " + folder.file("png")}) {
      const auto run = run_program("$BIN/" + command);
      INFO(command);
      CHECK(run.status == 1);
      CHECK(says(run, "damaged at byte " + std::to_string(damaged)));
    }
  }
}

TEST_CASE("as flown also where the recorder heard answers before their causes") {
  const Folder folder;
  LogReader reader(golden_log);
  std::vector<LogEvent> events;
  while (const auto event = reader.next()) events.push_back(*event);
  int64_t swapped = 0;
  for (size_t i = 1; i < events.size(); ++i) {
    const auto answer = decode_header(events[i].bytes);
    if (!answer || answer->trace.cause != events[i - 1].channel || events[i].channel == "HEALTH") continue;
    std::swap(events[i - 1], events[i]);
    std::swap(events[i - 1].utime, events[i].utime);
    ++swapped;
  }
  CHECK(swapped > 50);
  LogWriter writer(folder.file("log.lcm"));
  for (const LogEvent& event : events) writer.write(event);
  writer.flush();
  const auto run = replay_as_flown(folder, folder.file("log.lcm"));
  CHECK(run.status == 0);
  CHECK(says(run, "every payload is equal to the bit"));
}

TEST_CASE("a message of ours that can't be decoded is not as flown either") {
  const Folder folder;
  LogReader reader(golden_log);
  LogWriter writer(folder.file("log.lcm"));
  while (auto event = reader.next()) {
    if (event->channel == "VEHICLE_STATE" || event->channel == "HEALTH") event->bytes.pop_back();
    writer.write(*event);
  }
  writer.flush();
  const auto run = replay_as_flown(folder, folder.file("log.lcm"));
  CHECK(run.status == 1);
  CHECK(says(run, "NOT as flown"));
}

TEST_CASE("frames without their pixels are an error that says what to do, not a table of zeros") {
  const Folder folder;
  const auto log = with_frames(folder, [](frame_t& frame) {
    frame.encoding = frame_t::ENCODING_RING;
    frame.ring_name = "/gone";
    frame.size = 0;
    frame.data.clear();
  });
  for (const std::string mode : {"--every-frame", "--as-flown"}) {
    const auto run = run_program("$BIN/replay " + log + config + mode + " --out " + folder.file("out.lcm"));
    CHECK(run.status == 1);
    CHECK(says(run, "camera.transport=jpeg"));
    CHECK_FALSE(fs::exists(folder.file("out.lcm")));
  }
  CHECK(run_program("$BIN/replay " + log + config + "--as-flown --stages mission_proc --out " +
                    folder.file("out.lcm"))
            .status == 0);
}

TEST_CASE("frames that JPEG changed: as flown within the tolerances, and moved ones are not") {
  const Folder folder;
  FrameReader frames;
  const auto recoded =
      with_frames(folder, [&frames](frame_t& frame) { encode_jpeg(frames.image(frame).pixels, frame, 90); });
  const auto within = replay_as_flown(folder, recoded);
  CHECK(within.status == 0);
  CHECK(says(within, "as flown within tolerances"));
  const auto moved = with_frames(folder, [&frames](frame_t& frame) {
    const cv::Mat pixels = frames.image(frame).pixels,
                  by_a_pixel = (cv::Mat_<double>(2, 3) << 1, 0, 1, 0, 1, 0);
    cv::Mat shifted;
    cv::warpAffine(pixels, shifted, by_a_pixel, pixels.size());
    encode_jpeg(shifted, frame, 95);
  });
  const auto different = replay_as_flown(folder, moved);
  CHECK(different.status == 1);
  CHECK(says(different, "NOT as flown"));
}

TEST_CASE("lossless frames are compared to the bit") {
  const Folder folder;
  FrameReader frames;
  const auto log = with_frames(folder, [&frames](frame_t& frame) {
    encode_jpeg(frames.image(frame).pixels, frame, 90);
    encode_png(frames.image(frame).pixels, frame);
  });
  const auto run = replay_as_flown(folder, log);
  CHECK(run.status == 1);
  CHECK(says(run, "compared to the bit"));
}

TEST_CASE("the configuration kept beside the log is taken, and --config goes over it") {
  const Folder folder;
  fs::copy_file(golden_log, folder.file("recording.lcm"));
  const std::string replay_it =
      "$BIN/replay " + folder.file("recording.lcm") + " --as-flown --out " + folder.file("out.lcm");
  CHECK(says(run_program(replay_it), "settings have their defaults"));
  const fs::path cameras = STEVEDORE_SOURCE_DIR "/config/cameras/paper_640x480.yaml";
  std::ofstream(folder.file("config.yaml")) << "camera_file: " << cameras << "\n";
  std::ofstream(folder.file("settings.txt")) << "pose.circle_radius_m=0.5\n--set camera.rate_hz=15\n";
  const auto kept = run_program(replay_it);
  CHECK(kept.status == 0);
  CHECK(says(kept, "2 settings"));
  const auto over =
      run_program("$BIN/replay " + folder.file("recording.lcm") + " --out " + folder.file("config.yaml"));
  CHECK(over.status == 2);
  CHECK(says(over, "which is read"));
  CHECK(run_program(replay_it + " --set pose.circle_radius_m=2").status == 1);
  CHECK(run_program(replay_it + " --set pose.nonsense=2").status == 2);
  std::ofstream(folder.file("config.yaml")) << "nonsense: 1\n";
  CHECK(run_program(replay_it).status == 2);
  CHECK(run_program(replay_it + config).status == 0);
}
