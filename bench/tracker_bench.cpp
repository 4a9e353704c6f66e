// What tracking costs: the whole of it, with eight marks and the target's window, against one CAMShift over
// the full frame (hue, back projection, mean shift), as the paper's Algorithm 2 is usually run.
#include <benchmark/benchmark.h>

#include <numbers>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>
#include <vector>

#include "tracker_proc/tracker.hpp"

using namespace stevedore;

namespace {

constexpr int kMarks = 8;

/// Two rows of rings on a deck, which drift with the frame's number.
std::vector<Ellipse> marks_at(int frame) {
  std::vector<Ellipse> marks;
  for (int i = 0; i < kMarks; ++i)
    marks.push_back({120.0 + 130 * (i % 4) + 5 * std::sin(frame * 0.1), 160.0 + 150 * (i / 4), 40, 36, 0.2});
  return marks;
}

cv::Mat picture_at(int frame) {
  cv::Mat image(480, 640, CV_8UC3, cv::Scalar(70, 110, 70));
  cv::rectangle(image, {50, 60}, {590, 420}, cv::Scalar(110, 110, 120), cv::FILLED);
  for (const Ellipse& e : marks_at(frame))
    cv::ellipse(image, {cvRound(e.u_px), cvRound(e.v_px)}, {cvRound(e.a_px), cvRound(e.b_px)},
                e.alpha_rad * 180 / std::numbers::pi, 0, 360, cv::Scalar(240, 240, 245), 10);
  cv::Mat noise(image.size(), CV_8UC3);
  cv::RNG(static_cast<uint64_t>(frame) + 1).fill(noise, cv::RNG::UNIFORM, 0, 10);
  return image + noise;
}

std::vector<cv::Mat> film() {
  std::vector<cv::Mat> frames;
  for (int k = 0; k < 30; ++k) frames.push_back(picture_at(k));
  return frames;
}

void full_frame_camshift(benchmark::State& state) {
  const std::vector<cv::Mat> frames = film();
  cv::Mat histogram(36, 1, CV_32F, cv::Scalar(0));
  histogram.at<float>(0) = 255;
  std::size_t k = 0;
  for (auto _ : state) {
    cv::Mat hsv, probability;
    cv::cvtColor(frames[k++ % frames.size()], hsv, cv::COLOR_BGR2HSV);
    const int channel = 0;
    const float range[] = {0, 180};
    const float* ranges[] = {range};
    cv::calcBackProject(&hsv, 1, &channel, histogram, probability, ranges);
    cv::Rect window(80, 120, 80, 80);
    benchmark::DoNotOptimize(
        cv::CamShift(probability, window, {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 10, 1}));
  }
}
BENCHMARK(full_frame_camshift)->Unit(benchmark::kMicrosecond);

void whole_tracker(benchmark::State& state) {
  const std::vector<cv::Mat> frames = film();
  const bool target_is_covered = state.range(0) != 0;
  Tracker tracker{TrackerSettings{}};
  tracker.follow_pixel({120, 160});
  int k = 0;
  for (auto _ : state) {
    const int frame = k % static_cast<int>(frames.size());
    std::vector<Detection> detections;
    for (const Ellipse& e : marks_at(frame)) detections.emplace_back().outer.ellipse = e;
    if (target_is_covered && k % 30 != 0) detections.erase(detections.begin());
    benchmark::DoNotOptimize(tracker.step(k++ / 30.0, frames[static_cast<std::size_t>(frame)], detections));
  }
}
BENCHMARK(whole_tracker)->Arg(0)->Arg(1)->ArgName("target_covered")->Unit(benchmark::kMicrosecond);

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  benchmark::Initialize(&argc, argv);
  benchmark::RunSpecifiedBenchmarks();
}
