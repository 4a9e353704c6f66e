#include <unistd.h>

#include <atomic>
#include <catch2/catch.hpp>
#include <chrono>
#include <cmath>
#include <deque>
#include <filesystem>
#include <fstream>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/videoio.hpp>
#include <stdexcept>
#include <thread>

#include "camera_proc/source_camera.hpp"
#include "camera_proc/source_thread.hpp"

using namespace stevedore;
namespace fs = std::filesystem;
using State = CameraStatus::State;

namespace {

class Folder {
 public:
  Folder() : path_(fs::temp_directory_path() / ("stevedore_camera_" + std::to_string(getpid()))) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~Folder() { fs::remove_all(path_); }
  Folder(const Folder&) = delete;
  Folder& operator=(const Folder&) = delete;
  [[nodiscard]] std::string path(const std::string& name = "") const { return (path_ / name).string(); }
  void image(const std::string& name, int value, int type = CV_8UC1) const {
    REQUIRE(cv::imwrite(path(name), cv::Mat(6, 8, type, cv::Scalar::all(value))));
  }
  void text(const std::string& name) const { std::ofstream(path(name)) << "no image"; }

 private:
  fs::path path_;
};

CameraSettings images(const Folder& folder) {
  CameraSettings settings;
  settings.source = folder.path();
  settings.once = true;
  settings.rate_hz = 10;
  return settings;
}

int value_of(const CameraFrame& frame) {
  return frame.pixels.at<std::uint8_t>(0, 0);
}

// A device that does what its script says; each step is one grab.
struct Script {
  std::deque<Grab> steps;  // empty: none for ever
  bool changing = true;
  int image = 0;
  int channels_type = CV_8UC1;
  bool opens = true;
  int opened = 0;
};

class ScriptedDevice : public FrameSource {
 public:
  ScriptedDevice(Script& script, const std::int64_t& now) : script_(script), now_(now) {}
  Grab grab(cv::Mat& image, std::int64_t& capture_utime) override {
    if (script_.steps.empty()) return Grab::none;
    const Grab step = script_.steps.front();
    script_.steps.pop_front();
    if (script_.changing) ++script_.image;
    if (step == Grab::frame) image = cv::Mat(4, 4, script_.channels_type, cv::Scalar::all(script_.image));
    capture_utime = now_ - 3;
    return step;
  }
  [[nodiscard]] std::string fault() const override { return "cable pulled"; }
  [[nodiscard]] bool is_live() const override { return true; }

 private:
  Script& script_;
  const std::int64_t& now_;
};

// A camera on a scripted device and a clock that only the test moves.
struct Bench {
  Script script;
  std::int64_t now = 1'000'000'000;
  CameraSettings settings;
  Camera camera;

  Bench()
      : camera(
            settings,
            [this](std::string& fault) -> std::unique_ptr<FrameSource> {
              ++script.opened;
              if (script.opens) return std::make_unique<ScriptedDevice>(script, now);
              fault = "no such device";
              return nullptr;
            },
            [this] { return now; }) {}

  void wait(double seconds) { now += std::llround(seconds * 1e6); }
  int frames(int calls, double seconds_each = 0.1) {
    int count = 0;
    for (int i = 0; i < calls; ++i, wait(seconds_each)) {
      script.steps.push_back(Grab::frame);
      count += camera.next().has_value();
    }
    return count;
  }
};

}  // namespace

TEST_CASE("natural order: digits compare as numbers") {
  CHECK(natural_less("image.9.pgm", "image.10.pgm"));
  CHECK_FALSE(natural_less("image.10.pgm", "image.9.pgm"));
  CHECK(natural_less("a2b10", "a2b11"));
  CHECK(natural_less("a1b99", "a2b1"));
  CHECK(natural_less("a", "a1"));
  CHECK(natural_less("a1", "b"));
  CHECK(natural_less("image.0009", "image.10"));
  CHECK(natural_less("99999999999999999999998", "99999999999999999999999"));  // beyond 64 bits
  CHECK(natural_less("a0", "a1"));
  CHECK(natural_less("a00", "a1"));
  CHECK_FALSE(natural_less("a1", "a1"));
  CHECK(natural_less("a01", "a1") != natural_less("a1", "a01"));  // some order, the same each time
  CHECK(natural_less("a01", "a1b"));
}

TEST_CASE("files of a folder, of a pattern, and one file") {
  const Folder folder;
  for (const char* name : {"image.10.pgm", "image.9.pgm", "image.1.PGM", "other.png"}) folder.image(name, 1);
  folder.text("notes.txt");
  fs::create_directory(folder.path("sub.png"));
  const auto all = image_files(folder.path());
  REQUIRE(all.size() == 4);
  CHECK(all[0] == folder.path("image.1.PGM"));
  CHECK(all[1] == folder.path("image.9.pgm"));
  CHECK(all[2] == folder.path("image.10.pgm"));
  CHECK(all[3] == folder.path("other.png"));
  CHECK(image_files(folder.path("image.*.pgm")) ==
        std::vector<std::string>{folder.path("image.9.pgm"), folder.path("image.10.pgm")});
  CHECK(image_files(folder.path("other.png")) == std::vector<std::string>{folder.path("other.png")});
  folder.image("odd[1]*.png", 1);
  CHECK(image_files(folder.path("odd[1]*.png")) == std::vector<std::string>{folder.path("odd[1]*.png")});
  CHECK(image_files(folder.path("nothing*")).empty());
  CHECK(image_files("").empty());
}

TEST_CASE("images become grey or colour frames") {
  std::string fault;
  cv::Mat colour(5, 7, CV_8UC3, cv::Scalar(10, 20, 30));
  const cv::Mat grey(5, 7, CV_8UC1, cv::Scalar(77));
  CHECK(to_frame(colour, "auto", fault)->type() == CV_8UC3);
  CHECK(to_frame(grey, "auto", fault)->type() == CV_8UC1);
  CHECK(to_frame(grey, "colour", fault)->at<cv::Vec3b>(4, 6) == cv::Vec3b(77, 77, 77));
  CHECK(to_frame(colour, "grey", fault)->at<std::uint8_t>(4, 6) == 22);  // 0.114 B + 0.587 G + 0.299 R
  CHECK(to_frame(colour, "colour", fault)->at<cv::Vec3b>(0, 0) == cv::Vec3b(10, 20, 30));
  const cv::Mat with_alpha(5, 7, CV_8UC4, cv::Scalar(10, 20, 30, 99));
  CHECK(to_frame(with_alpha, "auto", fault)->at<cv::Vec3b>(4, 6) == cv::Vec3b(10, 20, 30));
  CHECK(to_frame(with_alpha, "grey", fault)->at<std::uint8_t>(0, 0) == 22);
  CHECK(to_frame(cv::Mat(2, 2, CV_16UC1, cv::Scalar(65535)), "auto", fault)->at<std::uint8_t>(1, 1) == 255);
  CHECK(to_frame(cv::Mat(2, 2, CV_16UC3, cv::Scalar::all(257 * 200)), "auto", fault)->at<cv::Vec3b>(1, 1) ==
        cv::Vec3b(200, 200, 200));
  const auto part = to_frame(colour(cv::Rect(1, 1, 3, 3)), "auto", fault);
  REQUIRE(part);
  CHECK(part->isContinuous());
  CHECK(fault.empty());
}

TEST_CASE("what is no frame is refused in words") {
  for (const cv::Mat& image : {cv::Mat(), cv::Mat(2, 2, CV_32FC1), cv::Mat(2, 2, CV_8UC2),
                               cv::Mat(1, 40000, CV_8UC1), cv::Mat(2, 2, CV_16SC1)}) {
    std::string fault;
    CHECK_FALSE(to_frame(image, "auto", fault));
    CHECK(fault.find("image") + fault.find("pixels") != 2 * std::string::npos);
    CHECK_FALSE(fault.empty());
  }
}

TEST_CASE("a driver's stamp is taken if it is on our clock") {
  constexpr std::int64_t now = 5'000'000'000;
  CHECK(capture_instant(4'999'990.5, now) == 4'999'990'500);
  CHECK(capture_instant(0, now) == now);
  CHECK(capture_instant(5'000'001, now) == now);  // in the future
  CHECK(capture_instant(1.7e12, now) == now);     // UTC
  CHECK(capture_instant(std::nan(""), now) == now);
}

TEST_CASE("the schedule is absolute, and late ticks are left out and counted") {
  Pacer pacer(30, 1000);
  for (int i = 0; i < 3000; ++i) {
    CHECK(std::abs(pacer.due_utime() - (1000 + static_cast<std::int64_t>(std::llround(i * 1e6 / 30)))) <= 1);
    pacer.advance(pacer.due_utime() + i % 30000);  // a little late each time: no drift
  }
  CHECK(pacer.late_ticks() == 0);
  Pacer slow(10, 0);
  slow.advance(99'999);
  CHECK(slow.due_utime() == 100'000);
  slow.advance(100'000 + 250'000);  // ticks at 200 and 300 ms are over
  CHECK(slow.due_utime() == 400'000);
  CHECK(slow.late_ticks() == 2);
}

TEST_CASE("image files are played in order at the rate, an unreadable one is counted and passed over") {
  const Folder folder;
  folder.image("f.8.png", 8);
  folder.image("f.9.png", 9);
  folder.text("f.10.png");
  folder.image("f.11.png", 11);
  std::int64_t now = 50;
  const CameraSettings settings = images(folder);
  Camera camera(settings, make_opener(settings), [&] { return now; });
  CHECK(camera.status().state == State::failed);
  std::vector<std::pair<int, std::int64_t>> played;
  while (!camera.finished() && now < 2'000'000) {
    if (const auto frame = camera.next()) played.emplace_back(value_of(*frame), frame->capture_utime);
    if (camera.counts().unreadable > 0 && !camera.finished()) {
      CHECK(camera.status().state == State::degraded);
      CHECK(camera.status().message.find("f.10.png") != std::string::npos);
    }
    now += camera.wait_us();
  }
  CHECK(played == std::vector<std::pair<int, std::int64_t>>{{8, 50}, {9, 100'050}, {11, 200'050}});
  CHECK(camera.status().state == State::finished);
  CHECK(camera.counts().unreadable == 1);
  CHECK(camera.counts().late_ticks == 0);
  CHECK_FALSE(camera.next());
}

TEST_CASE("identical image files are not a frozen camera, and a folder starts over in step") {
  const Folder folder;
  for (const char* name : {"1.png", "2.png"}) folder.image(name, 5);
  std::int64_t now = 0;
  CameraSettings settings = images(folder);
  settings.once = false;
  Camera camera(settings, make_opener(settings), [&] { return now; });
  std::vector<std::int64_t> stamps;
  while (stamps.size() < 60) {
    if (const auto frame = camera.next()) stamps.push_back(frame->capture_utime);
    now += camera.wait_us();
  }
  for (std::size_t i = 0; i < stamps.size(); ++i) CHECK(stamps[i] == static_cast<std::int64_t>(100'000 * i));
  CHECK(camera.status().state == State::ok);
  CHECK(camera.counts().reopened == 0);
}

TEST_CASE("files that are fetched too late lose ticks, not images") {
  const Folder folder;
  for (int i = 0; i < 4; ++i) folder.image(std::to_string(i) + ".png", i);
  std::int64_t now = 0;
  const CameraSettings settings = images(folder);
  Camera camera(settings, make_opener(settings), [&] { return now; });
  REQUIRE(camera.next());
  now = 350'000;
  auto frame = camera.next();
  REQUIRE(frame);
  CHECK(value_of(*frame) == 1);
  CHECK(frame->capture_utime == 350'000);
  CHECK(camera.counts().late_ticks == 2);
  CHECK(camera.status().state == State::degraded);
  CHECK_FALSE(camera.next());
  now = 400'000;
  CHECK(camera.next());
}

TEST_CASE("unpaced files come at once with the stamps of their schedule") {
  const Folder folder;
  for (int i = 0; i < 3; ++i) folder.image(std::to_string(i) + ".png", i);
  CameraSettings settings = images(folder);
  settings.paced = false;
  Camera camera(settings, make_opener(settings), [] { return std::int64_t{700}; });
  for (int i = 0; i < 3; ++i) {
    const auto frame = camera.next();
    REQUIRE(frame);
    CHECK(value_of(*frame) == i);
    CHECK(frame->capture_utime == 700 + 100'000 * i);
    CHECK(camera.wait_us() <= 500);  // a look at the bus, no schedule
  }
  CHECK_FALSE(camera.next());
  CHECK(camera.finished());
}

TEST_CASE("files that are to be played once and are not there: finished at once, and why") {
  const Folder folder;
  const CameraSettings settings = images(folder);
  Camera camera(settings, make_opener(settings), [] { return std::int64_t{0}; });
  CHECK_FALSE(camera.next());
  CHECK(camera.finished());
  CHECK(camera.status().state == State::finished);
  CHECK(camera.status().message.find("no images at") != std::string::npos);
}

TEST_CASE("no files, or none that is readable: failed, and tried again until they appear") {
  const Folder folder;
  std::int64_t now = 0;
  CameraSettings settings = images(folder);
  settings.once = false;
  Camera camera(settings, make_opener(settings), [&] { return now; });
  CHECK_FALSE(camera.next());
  CHECK(camera.status().state == State::failed);
  CHECK(camera.status().message.find(folder.path()) != std::string::npos);
  CHECK(camera.status().message.find("again and again") != std::string::npos);
  folder.text("1.png");
  now += 200'000;
  for (int i = 0; i < 3; ++i) CHECK_FALSE(camera.next());
  CHECK(camera.status().state == State::failed);
  folder.image("2.png", 2);
  now += 400'000;
  bool came = false;
  for (int i = 0; i < 3; ++i) came = camera.next().has_value() || came;
  CHECK(came);
}

TEST_CASE("a device's frames are handed on with its stamps") {
  Bench bench;
  bench.script.steps = {Grab::frame, Grab::none};
  const auto frame = bench.camera.next();
  REQUIRE(frame);
  CHECK(frame->capture_utime == bench.now - 3);
  CHECK(bench.camera.status().state == State::ok);
  CHECK_FALSE(bench.camera.next());
  CHECK(bench.camera.status().state == State::ok);
  CHECK(bench.camera.counts().frames == 1);
}

TEST_CASE(
    "a device that vanishes is opened again with growing waits, and the waits start small the next time") {
  Bench bench;
  REQUIRE(bench.frames(5) == 5);
  bench.script.steps = {Grab::failed};
  bench.script.opens = false;
  CHECK_FALSE(bench.camera.next());
  CHECK(bench.camera.status().state == State::failed);
  CHECK(bench.camera.status().message.find("cable pulled") != std::string::npos);

  std::vector<double> waits;
  std::int64_t last = bench.now;
  for (int opened = bench.script.opened; waits.size() < 8; bench.wait(0.01)) {
    bench.camera.next();
    if (bench.script.opened == opened) continue;
    opened = bench.script.opened;
    waits.push_back(static_cast<double>(bench.now - last) / 1e6);
    last = bench.now;
  }
  const std::vector<double> expected = {0.2, 0.4, 0.8, 1.6, 3.2, 5, 5, 5};
  for (std::size_t i = 0; i < waits.size(); ++i) CHECK(waits[i] == Approx(expected[i]).margin(0.011));
  CHECK(bench.camera.status().message.find("no such device") != std::string::npos);

  bench.script.opens = true;
  bench.wait(5);
  CHECK(bench.frames(1) == 1);
  CHECK(bench.camera.status().state == State::degraded);  // shown for a while
  CHECK(bench.camera.counts().reopened == 1);
  bench.wait(2.1);
  CHECK(bench.frames(1) == 1);
  CHECK(bench.camera.status().state == State::ok);
  bench.script.steps = {Grab::failed};
  const int opened = bench.script.opened;
  bench.camera.next();
  bench.wait(0.21);
  bench.camera.next();
  CHECK(bench.script.opened == opened + 1);
}

TEST_CASE("a device that repeats one image is frozen: its images are withheld until one differs") {
  Bench bench;
  REQUIRE(bench.frames(5) == 5);
  bench.script.changing = false;
  const int passed = bench.frames(60);  // 6 s
  CHECK(passed >= 19);                  // the first 2 s
  CHECK(passed <= 21);
  CHECK(bench.script.opened > 1);
  CHECK(bench.camera.status().state == State::failed);
  CHECK(bench.camera.status().message.find("frozen") != std::string::npos);
  bench.script.changing = true;
  bench.wait(5);
  CHECK(bench.frames(3) == 3);
  CHECK(bench.camera.status().state == State::degraded);
}

TEST_CASE("a single repeated image is no fault") {
  Bench bench;
  for (int i = 0; i < 50; ++i) {
    bench.script.changing = i % 10 != 0;
    CHECK(bench.frames(1) == 1);
  }
  CHECK(bench.script.opened == 1);
  CHECK(bench.camera.status().state == State::ok);
}

TEST_CASE("a silent device is lost after frozen_after_s, a newly opened one after 10 s") {
  Bench bench;
  for (int i = 0; i < 99; ++i, bench.wait(0.1)) bench.camera.next();
  CHECK(bench.script.opened == 1);
  CHECK(bench.frames(1) == 1);
  for (int i = 0; i < 18; ++i, bench.wait(0.1)) bench.camera.next();
  CHECK(bench.camera.status().state == State::ok);
  for (int i = 0; i < 3; ++i, bench.wait(0.1)) bench.camera.next();
  CHECK(bench.camera.status().state == State::failed);
  CHECK(bench.camera.status().message.find("no frame for 2") != std::string::npos);
}

TEST_CASE("a device whose images can't be used says so") {
  Bench bench;
  bench.script.channels_type = CV_32FC1;
  CHECK(bench.frames(1) == 0);
  CHECK(bench.camera.status().state == State::failed);
  CHECK(bench.camera.status().message.find("CV_32FC1") != std::string::npos);
  CHECK(bench.camera.counts().unreadable == 1);
}

TEST_CASE("an opener that throws is a fault like any other") {
  Camera camera(
      {}, [](std::string&) -> std::unique_ptr<FrameSource> { throw std::runtime_error("driver broke"); },
      [] { return std::int64_t{0}; });
  CHECK_FALSE(camera.next());
  CHECK(camera.status().message.find("driver broke") != std::string::npos);
}

TEST_CASE("waits are short, so that a stop is obeyed") {
  Bench bench;
  bench.script.opens = false;
  for (int i = 0; i < 20; ++i, bench.wait(1)) {
    bench.camera.next();
    CHECK(bench.camera.wait_us() <= 100'000);
    CHECK(bench.camera.wait_us() > 0);
  }
}

namespace {

// Blocks in its second grab until it is let go, as a V4L2 driver does when the camera dies.
struct Blocker : FrameSource {
  explicit Blocker(std::atomic<bool>& open) : let_go(open) {}
  Grab grab(cv::Mat& image, std::int64_t& capture_utime) override {
    if (++grabs > 1)
      while (!let_go) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    image = cv::Mat(2, 2, CV_8UC1, cv::Scalar(grabs));
    capture_utime = grabs;
    return grabs < 3 ? Grab::frame : Grab::failed;
  }
  [[nodiscard]] std::string fault() const override { return "gone"; }
  [[nodiscard]] bool is_live() const override { return true; }
  std::atomic<bool>& let_go;
  int grabs = 0;
};

Grab wait_for(FrameSource& source, Grab wanted) {
  cv::Mat image;
  std::int64_t capture_utime = 0;
  Grab outcome = Grab::none;
  while (outcome != wanted) outcome = source.grab(image, capture_utime);
  return outcome;
}

}  // namespace

TEST_CASE("a driver that blocks is left behind, and its device isn't opened until it returns") {
  static std::atomic<bool> let_go = false;
  const Opener open = threaded([](std::string&) { return std::make_unique<Blocker>(let_go); });
  std::string fault;
  auto source = open(fault);
  REQUIRE(source);
  CHECK(source->is_live());
  wait_for(*source, Grab::frame);
  cv::Mat image;
  std::int64_t capture_utime = 0;
  CHECK(source->grab(image, capture_utime) == Grab::none);
  source.reset();  // returns although the driver doesn't
  CHECK_FALSE(open(fault));
  CHECK(fault.find("still blocks") != std::string::npos);
  let_go = true;
  while (!source) source = open(fault);
  wait_for(*source, Grab::failed);
  CHECK(source->fault() == "gone");
  CHECK(source->grab(image, capture_utime) == Grab::failed);  // its last word
}

TEST_CASE("a device that can't be opened or throws is a failed source") {
  const Opener absent = threaded([](std::string& fault) -> std::unique_ptr<FrameSource> {
    fault = "not there";
    return nullptr;
  });
  std::string fault;
  auto source = absent(fault);
  REQUIRE(source);
  wait_for(*source, Grab::failed);
  CHECK(source->fault() == "not there");
  source =
      threaded([](std::string&) -> std::unique_ptr<FrameSource> { throw std::runtime_error("bang"); })(fault);
  wait_for(*source, Grab::failed);
  CHECK(source->fault() == "bang");
}

TEST_CASE("a video file is played once and ends") {
  const Folder folder;
  const std::string file = folder.path("film.avi");
  cv::VideoWriter writer(file, cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), 25, {64, 48});
  REQUIRE(writer.isOpened());
  for (int i = 0; i < 6; ++i) writer.write(cv::Mat(48, 64, CV_8UC3, cv::Scalar::all(40 * i)));
  writer.release();
  CameraSettings settings;
  settings.kind = "video";
  settings.source = file;
  settings.once = true;
  settings.paced = false;
  settings.rate_hz = 0;
  settings.colour = "grey";
  Camera camera(settings, make_opener(settings), [] { return std::int64_t{0}; });
  std::vector<int> values;
  for (int i = 0; i < 20 && !camera.finished(); ++i)
    if (const auto frame = camera.next()) {
      CHECK(frame->capture_utime ==
            static_cast<std::int64_t>(40'000 * values.size()));  // the file's own rate
      values.push_back(value_of(*frame));
    }
  CHECK(camera.finished());
  REQUIRE(values.size() == 6);
  for (std::size_t i = 0; i < values.size(); ++i) CHECK(std::abs(values[i] - static_cast<int>(40 * i)) <= 4);
}

TEST_CASE("a device that isn't there is a fault in words") {
  for (const std::string kind : {"v4l2", "video"}) {
    CameraSettings settings;
    settings.kind = kind;
    settings.source = "/nowhere/video99";
    Camera camera(settings);
    for (int i = 0; i < 100 && camera.status().message.find("/nowhere/video99") == std::string::npos; ++i)
      CHECK_FALSE(camera.next());
    CHECK(camera.status().state == State::failed);
    CHECK(camera.status().message.find("can't open " + kind) != std::string::npos);
  }
}

TEST_CASE("a GStreamer pipeline gives frames") {
  CameraSettings settings;
  settings.kind = "gstreamer";
  settings.source =
      "videotestsrc is-live=true pattern=snow ! video/x-raw,width=64,height=48,framerate=30/1 ! "
      "videoconvert ! video/x-raw,format=BGR ! appsink";
  if (!cv::VideoCapture(settings.source, cv::CAP_GSTREAMER).isOpened()) {
    WARN("skipped: this OpenCV or GStreamer can't play videotestsrc");
    return;
  }
  Camera camera(settings);
  std::int64_t last = 0;
  for (int frames = 0; frames < 5;) {
    const auto frame = camera.next();
    if (!frame) continue;
    ++frames;
    CHECK(frame->pixels.size() == cv::Size(64, 48));
    CHECK(frame->capture_utime > last);
    last = frame->capture_utime;
  }
  CHECK(camera.status().state == State::ok);
}

namespace {

// Gives a frame at each grab, as fast as it is asked.
struct Fast : FrameSource {
  explicit Fast(std::atomic<int>& count) : grabbed(count) {}
  Grab grab(cv::Mat& image, std::int64_t& capture_utime) override {
    image = cv::Mat(2, 2, CV_8UC1, cv::Scalar(grabbed % 256));
    capture_utime = ++grabbed;
    return grabbed <= 100 ? Grab::frame : Grab::failed;
  }
  [[nodiscard]] std::string fault() const override { return "gone"; }
  [[nodiscard]] bool is_live() const override { return true; }
  std::atomic<int>& grabbed;
};

}  // namespace

TEST_CASE("frames that come faster than they are fetched are counted") {
  static std::atomic<int> grabbed = 0;
  std::string fault;
  auto source = threaded([](std::string&) { return std::make_unique<Fast>(grabbed); })(fault);
  REQUIRE(source);
  int fetched = 0;
  std::int64_t superseded = 0;
  cv::Mat image;
  std::int64_t capture_utime = 0;
  for (Grab outcome = Grab::none; outcome != Grab::failed;) {
    outcome = source->grab(image, capture_utime);
    if (outcome == Grab::frame) ++fetched;
    superseded += source->take_superseded();
  }
  CHECK(fetched + superseded == 100);
  CHECK(source->take_superseded() == 0);
}
