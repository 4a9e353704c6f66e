#include "tracker_proc/tracker.hpp"

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <opencv2/imgproc.hpp>
#include <random>

using namespace stevedore;

namespace {

constexpr double kFrame_s = 1.0 / 30;

/// A circle that wanders smoothly: sums of slow sines in place and size, so that paths cross.
struct Wanderer {
  double u, v, radius, reach, pace_radps, phase;
  [[nodiscard]] Ellipse at(double t) const {
    const double size = radius * (1 + 0.2 * std::sin(0.7 * t + phase));
    return normalized({u + reach * std::sin(pace_radps * t + phase),
                       v + reach * std::cos(0.8 * pace_radps * t - phase), size, 0.8 * size,
                       0.3 * t + phase});
  }
};

using Random = std::mt19937;

double between(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

std::vector<Wanderer> wanderers(Random& random, int count) {
  std::vector<Wanderer> all;
  for (int i = 0; i < count; ++i)
    all.push_back({between(random, 150, 490), between(random, 120, 360), between(random, 15, 50),
                   between(random, 30, 120), between(random, 0.3, 1.5), between(random, 0, 6.28)});
  return all;
}

Detection measured(const Ellipse& truth, Random& random) {
  std::normal_distribution<double> noise(0, 0.3);
  Detection d;
  d.outer.ellipse = normalized({truth.u_px + noise(random), truth.v_px + noise(random),
                                truth.a_px + noise(random), truth.b_px + noise(random), truth.alpha_rad});
  d.label = Label::circle;
  return d;
}

}  // namespace

TEST_CASE("several ellipses on smooth crossing paths: no id ever switches") {
  for (unsigned seed = 0; seed < 100; ++seed) {
    Random random(seed);
    const auto objects = wanderers(random, 6);
    Tracker tracker{TrackerSettings{}};
    std::map<std::size_t, std::int64_t> id_of;
    for (int k = 0; k < 300; ++k) {
      std::vector<std::size_t> order(objects.size());
      for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
      std::shuffle(order.begin(), order.end(), random);
      std::vector<Detection> detections;
      std::vector<std::size_t> seen;
      for (const std::size_t i : order) {
        if (k > 10 && between(random, 0, 1) < 0.1) continue;  // one in ten is missed
        detections.push_back(measured(objects[i].at(k * kFrame_s), random));
        seen.push_back(i);
      }
      const auto result = tracker.step(k * kFrame_s, {}, detections);
      for (const Track& track : result.tracks) {
        if (track.detection_index < 0) continue;
        const std::size_t object = seen[static_cast<std::size_t>(track.detection_index)];
        const auto [known, is_new] = id_of.emplace(object, track.id);
        INFO("seed " << seed << " frame " << k << " object " << object);
        REQUIRE(known->second == track.id);
      }
    }
    REQUIRE(id_of.size() == objects.size());
  }
}

TEST_CASE("no id is used twice, no detection has two tracks") {
  Random random(5);
  Tracker tracker{TrackerSettings{}};
  tracker.follow_first_circle();
  std::int64_t highest = 0;
  for (int k = 0; k < 500; ++k) {
    std::vector<Detection> detections;
    const int count = static_cast<int>(between(random, 0, 40));
    for (int i = 0; i < count; ++i)
      detections.push_back(measured({between(random, 0, 640), between(random, 0, 480), 30, 20, 0.1}, random));
    const auto result = tracker.step(k * kFrame_s, {}, detections);
    std::vector<int> tracks_of(detections.size(), 0);
    std::int64_t previous = 0;
    for (const Track& track : result.tracks) {
      REQUIRE(track.id > previous);  // in order, each once
      previous = track.id;
      if (track.age_frames == 0) {
        REQUIRE(track.id > highest);
        highest = track.id;
      }
      REQUIRE((track.detection_index >= 0) == (track.status == TrackStatus::tracking));
      REQUIRE((track.unseen_s == 0) == (track.status == TrackStatus::tracking));
      if (track.detection_index >= 0) ++tracks_of[static_cast<std::size_t>(track.detection_index)];
    }
    REQUIRE(std::count_if(tracks_of.begin(), tracks_of.end(), [](int n) { return n > 1; }) == 0);
  }
}

TEST_CASE("the same frames twice give the same result to the bit") {
  const auto run = [] {
    Random random(9);
    const auto objects = wanderers(random, 4);
    Tracker tracker{TrackerSettings{}};
    tracker.follow_pixel({objects[0].at(0).u_px, objects[0].at(0).v_px});
    std::vector<double> numbers;
    std::string reasons;
    for (int k = 0; k < 60; ++k) {
      cv::Mat image(480, 640, CV_8UC3, cv::Scalar(60, 90, 60));
      std::vector<Detection> detections;
      for (const Wanderer& object : objects) {
        const Ellipse e = object.at(k * kFrame_s);
        cv::ellipse(image, {cvRound(e.u_px), cvRound(e.v_px)}, {cvRound(e.a_px), cvRound(e.b_px)},
                    e.alpha_rad * 57.29578, 0, 360, cv::Scalar(240, 240, 250), cv::FILLED);
        detections.push_back(measured(e, random));
      }
      const auto result = tracker.step(k * kFrame_s, image, detections);
      for (const Track& track : result.tracks)
        numbers.insert(numbers.end(), {double(track.id), track.velocity_pxps.x(), track.velocity_pxps.y(),
                                       track.detection.outer.ellipse.u_px});
      if (result.target.window)
        numbers.insert(numbers.end(), {result.target.window->u_px, result.target.window->a_px});
      reasons += result.target.reason;
    }
    return std::pair(numbers, reasons);
  };
  const auto once = run(), again = run();
  CHECK(once.first == again.first);
  CHECK(once.second == again.second);
  CHECK(once.second.find("the CAMShift window") != std::string::npos);
}
