// What a frame's way costs, against plain memcpy of the same pixels. Arguments: width, height (bgr8).
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <cstring>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "runtime/frame_codec.hpp"

namespace {

using namespace stevedore;

// Looks like a camera's frame to a codec: smooth shapes, edges, and noise of 5 grey levels.
cv::Mat camera_like(const benchmark::State& state) {
  const auto width = static_cast<int>(state.range(0));
  const auto height = static_cast<int>(state.range(1));
  cv::Mat image(height, width, CV_8UC3, cv::Scalar(90, 110, 100));
  for (int i = 1; i < 8; ++i)
    cv::circle(image, {width * i / 8, height * (i * 3 % 8) / 8}, height / 8,
               cv::Scalar(30 * i, 255 - 30 * i, 128), 9);
  cv::Mat noise(height, width, CV_16SC3);
  cv::RNG(1).fill(noise, cv::RNG::NORMAL, 0, 5);
  cv::add(image, noise, image, cv::noArray(), CV_8UC3);
  return image;
}

void count_bytes(benchmark::State& state, const cv::Mat& image) {
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations()) *
                          static_cast<std::int64_t>(image.total() * image.elemSize()));
}

// One copy into one of 16 buffers, another into a fresh image: what the ring does, without the ring.
void memcpy_twice(benchmark::State& state) {
  const cv::Mat image = camera_like(state);
  const std::size_t bytes = image.total() * image.elemSize();
  std::vector<cv::Mat> slots(16);
  for (auto& slot : slots) slot = image.clone();
  std::size_t turn = 0;
  for (auto _ : state) {
    const cv::Mat& slot = slots[turn++ % slots.size()];
    std::memcpy(slot.data, image.data, bytes);
    cv::Mat copy(image.rows, image.cols, image.type());
    std::memcpy(copy.data, slot.data, bytes);
    benchmark::DoNotOptimize(copy.data);
    benchmark::ClobberMemory();
  }
  count_bytes(state, image);
}

void ring_write_read(benchmark::State& state) {
  const cv::Mat image = camera_like(state);
  FrameRing ring("bench_" + std::to_string(getpid()), 16, image.total() * image.elemSize());
  FrameReader reader;
  frame_t notice{};
  for (auto _ : state) {
    ring.write(image, notice);
    const FrameImage back = reader.image(notice);
    if (!back) state.SkipWithError("frame lost");
    benchmark::DoNotOptimize(back.pixels.data);
  }
  count_bytes(state, image);
}

void ring_write(benchmark::State& state) {
  const cv::Mat image = camera_like(state);
  FrameRing ring("bench_" + std::to_string(getpid()), 16, image.total() * image.elemSize());
  frame_t notice{};
  for (auto _ : state) ring.write(image, notice);
  count_bytes(state, image);
}

void jpeg_encode(benchmark::State& state) {
  const cv::Mat image = camera_like(state);
  frame_t frame{};
  for (auto _ : state) encode_jpeg(image, frame);
  count_bytes(state, image);
  state.counters["kB"] = static_cast<double>(frame.size) / 1000;
}

void jpeg_decode(benchmark::State& state) {
  const cv::Mat image = camera_like(state);
  frame_t frame{};
  encode_jpeg(image, frame);
  FrameReader reader;
  for (auto _ : state) benchmark::DoNotOptimize(reader.image(frame).pixels.data);
  count_bytes(state, image);
}

BENCHMARK(memcpy_twice)->Args({640, 480})->Args({1280, 960});
BENCHMARK(ring_write_read)->Args({640, 480})->Args({1280, 960});
BENCHMARK(ring_write)->Args({640, 480})->Args({1280, 960});
BENCHMARK(jpeg_encode)->Args({640, 480})->Args({1280, 960});
BENCHMARK(jpeg_decode)->Args({640, 480})->Args({1280, 960});

}  // namespace

BENCHMARK_MAIN();
