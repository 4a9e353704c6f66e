// Detector and tracker over a real sequence: Debian's package visp-images-data, labels in tests/data/mire-2.
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <string>

#include "detector_proc/detector.hpp"
#include "tracker_proc/tracker.hpp"

using namespace stevedore;

namespace {

const std::string kImages = "/usr/share/visp-images-data/ViSP-images/mire-2";

constexpr double kFrame_s = 0.04;

/// The labelled ellipses, by frame number.
std::map<int, Ellipse> labels() {
  std::map<int, Ellipse> all;
  std::ifstream file(STEVEDORE_SOURCE_DIR "/tests/data/mire-2/truth.jsonl");
  for (std::string line; std::getline(file, line);) {
    int frame = 0;
    Ellipse e;
    const int read =
        std::sscanf(line.c_str(),
                    R"({"image": "mire-2/image.%d.pgm", "labelled": true, "ellipses": [{"u": %lf, )"
                    R"("v": %lf, "a": %lf, "b": %lf, "alpha": %lf)",
                    &frame, &e.u_px, &e.v_px, &e.a_px, &e.b_px, &e.alpha_rad);
    REQUIRE(read == 6);
    all[frame] = e;
  }
  return all;
}

cv::Mat frame_image(int frame) {
  char name[32];
  std::snprintf(name, sizeof name, "/image.%04d.pgm", frame);
  const cv::Mat image = cv::imread(kImages + name, cv::IMREAD_GRAYSCALE);
  REQUIRE_FALSE(image.empty());
  return image;
}

}  // namespace

TEST_CASE("the large circle of mire-2 is followed from the first frame to the last") {
  if (!std::filesystem::exists(kImages)) {
    WARN("skipped: package visp-images-data is not installed");
    return;
  }
  const auto truth = labels();
  REQUIRE(truth.size() == 51);
  const Ellipse& first = truth.at(1);
  const bool by_pixel = GENERATE(true, false);
  Tracker tracker{TrackerSettings{}};
  if (by_pixel)
    tracker.follow_pixel({first.u_px, first.v_px});
  else
    tracker.follow_first_circle();

  const Detector detector;
  int tracked = 0, windows_on_it = 0;
  for (int frame = 1; frame <= 501; ++frame) {
    const cv::Mat image = frame_image(frame);
    const auto result = tracker.step(frame * kFrame_s, image, detector.detect(image));
    INFO("frame " << frame << ": " << result.target.reason);
    REQUIRE(result.target.id);
    const auto label = truth.find(frame);
    if (result.target.status != TrackStatus::tracking) continue;
    for (const Track& track : result.tracks) {
      if (track.id != result.target.id) continue;
      const Ellipse& e = track.detection.outer.ellipse;
      const auto& window = result.target.window;
      windows_on_it += window && std::hypot(e.u_px - window->u_px, e.v_px - window->v_px) < 3;
      if (label == truth.end()) continue;
      // 2 px: far less than to anything else, more than half of the blur of frame 1
      CHECK(std::hypot(e.u_px - label->second.u_px, e.v_px - label->second.v_px) < 2);
      CHECK(std::abs(e.a_px - label->second.a_px) < 2);
      CHECK(std::abs(e.b_px - label->second.b_px) < 2);
      ++tracked;
    }
  }
  CHECK(tracked >= 50);         // of 51
  CHECK(windows_on_it >= 490);  // white on black: CAMShift by itself stays on it, in 500 frames
}
