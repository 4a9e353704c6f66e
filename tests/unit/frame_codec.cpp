#include "runtime/frame_codec.hpp"

#include <unistd.h>

#include <catch2/catch.hpp>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>

using namespace stevedore;

namespace {

// Smooth, so that JPEG keeps it within a few grey levels.
cv::Mat test_image(int rows, int cols, int type) {
  cv::Mat image(rows, cols, type);
  for (int v = 0; v < rows; ++v)
    for (int u = 0; u < cols; ++u)
      for (int c = 0; c < image.channels(); ++c)
        image.ptr(v)[u * image.channels() + c] = static_cast<std::uint8_t>((u + 2 * v + 40 * c) % 200);
  return image;
}

double difference(const cv::Mat& a, const cv::Mat& b) {
  REQUIRE(a.size() == b.size());
  REQUIRE(a.type() == b.type());
  return cv::norm(a, b, cv::NORM_L1) / static_cast<double>(a.total() * a.elemSize());
}

FrameFault fault_of(const frame_t& frame) {
  return FrameReader().image(frame).fault;
}

}  // namespace

TEST_CASE("every way gives the image back, and consumers see no difference") {
  FrameReader reader;
  FrameRing ring("test_codec_" + std::to_string(getpid()), 8, 100);
  for (const int type : {CV_8UC1, CV_8UC3}) {
    const cv::Mat large = test_image(40, 80, type);
    const cv::Mat image = large(cv::Rect(2, 3, 67, 33));  // not contiguous, odd sizes
    frame_t ringed{}, raw{}, jpeg{}, png{};
    ring.write(image, ringed);
    encode_raw(image, raw);
    encode_jpeg(image, jpeg);
    encode_png(image, png);
    CHECK(raw.data.size() == image.total() * image.elemSize());
    CHECK(jpeg.encoding == frame_t::ENCODING_JPEG);
    CHECK(png.encoding == frame_t::ENCODING_PNG);
    for (const frame_t& frame : {ringed, raw, jpeg, png}) {
      CHECK(frame.format == (type == CV_8UC1 ? frame_t::FORMAT_GRAY8 : frame_t::FORMAT_BGR8));
      const FrameImage back = reader.image(frame);
      REQUIRE(back);
      CHECK(back.pixels.isContinuous());
      CHECK(difference(back.pixels, image) <= (frame.encoding == frame_t::ENCODING_JPEG ? 2.0 : 0.0));
    }
  }
}

TEST_CASE("an encoder clears what another way left in the message") {
  frame_t frame{};
  FrameRing ring("test_codec_clear_" + std::to_string(getpid()), 8, 100);
  ring.write(test_image(10, 10, CV_8UC1), frame);
  encode_png(test_image(10, 10, CV_8UC1), frame);
  CHECK(frame.ring_name.empty());
  CHECK(frame.ring_generation == 0);
  CHECK(frame.ring_sequence == 0);
  CHECK(FrameReader().image(frame));
  ring.write(test_image(10, 10, CV_8UC1), frame);
  CHECK(frame.data.empty());
  CHECK(FrameReader().image(frame));
}

TEST_CASE("JPEG quality is what was asked for") {
  frame_t good{}, poor{};
  encode_jpeg(test_image(64, 64, CV_8UC3), good);
  encode_jpeg(test_image(64, 64, CV_8UC3), poor, 20);
  CHECK(poor.data.size() < good.data.size());
}

TEST_CASE("inline data that contradicts the message is malformed") {
  for (auto* encode : {+[](const cv::Mat&i, frame_t&f) { encode_raw(i, f); },
                       +[](const cv::Mat&i, frame_t&f) { encode_jpeg(i, f); },
                       +[](const cv::Mat&i, frame_t&f) { encode_png(i, f); }}) {
    frame_t good{};
    encode(test_image(16, 24, CV_8UC3), good);
    REQUIRE(fault_of(good) == FrameFault::none);
    const auto changed = [&](auto change) {
      frame_t frame = good;
      change(frame);
      return fault_of(frame);
    };
    CHECK(changed([](frame_t& f) { f.width_px = 23; }) == FrameFault::malformed);
    CHECK(changed([](frame_t& f) { f.height_px = 17; }) == FrameFault::malformed);
    CHECK(changed([](frame_t& f) { f.format = frame_t::FORMAT_GRAY8; }) == FrameFault::malformed);
    CHECK(changed([](frame_t& f) { f.format = 3; }) == FrameFault::malformed);
    CHECK(changed([](frame_t& f) { f.encoding = 0; }) == FrameFault::malformed);
    CHECK(changed([](frame_t& f) { f.encoding = 5; }) == FrameFault::malformed);
    CHECK(changed([](frame_t& f) { f.width_px = 0; }) == FrameFault::malformed);
    CHECK(changed([](frame_t& f) { f.height_px = -16; }) == FrameFault::malformed);
    CHECK(changed([](frame_t& f) { f.width_px = f.height_px = 32767; }) == FrameFault::malformed);
    CHECK(changed([](frame_t& f) { f.size -= 1; }) == FrameFault::malformed);
    CHECK(changed([](frame_t& f) { f.size = -1; }) == FrameFault::malformed);
    CHECK(changed([](frame_t& f) { f.encoding = frame_t::ENCODING_RING; }) == FrameFault::malformed);
    CHECK(changed([](frame_t& f) { f.data.clear(), f.size = 0; }) ==
          (good.encoding == frame_t::ENCODING_RAW ? FrameFault::malformed : FrameFault::undecodable));
  }
}

TEST_CASE("a cut or garbled JPEG or PNG never throws and a cut one never gives an image") {
  for (const bool jpeg : {true, false}) {
    frame_t good{};
    const cv::Mat image = test_image(48, 64, CV_8UC3);
    jpeg ? encode_jpeg(image, good) : encode_png(image, good);
    for (std::size_t size = 0; size < good.data.size(); size += 7) {
      frame_t cut = good;
      cut.data.resize(size);
      cut.size = static_cast<std::int32_t>(size);
      CHECK(fault_of(cut) == FrameFault::undecodable);
    }
    cv::RNG random(1);
    for (int turn = 0; turn < 300; ++turn) {
      frame_t garbled = good;
      for (int i = 0; i < 1 + turn % 5; ++i)
        garbled.data[static_cast<std::size_t>(random.uniform(0, garbled.size))] =
            static_cast<std::uint8_t>(random.uniform(0, 256));
      const FrameImage back = FrameReader().image(garbled);
      if (back) CHECK(back.pixels.size() == image.size());
    }
  }
}

TEST_CASE("only the announced codec is tried") {
  frame_t frame{};
  encode_png(test_image(16, 16, CV_8UC1), frame);
  frame.encoding = frame_t::ENCODING_JPEG;
  CHECK(fault_of(frame) == FrameFault::undecodable);
  encode_jpeg(test_image(16, 16, CV_8UC1), frame);
  frame.encoding = frame_t::ENCODING_PNG;
  CHECK(fault_of(frame) == FrameFault::undecodable);
  cv::imencode(".bmp", test_image(16, 16, CV_8UC1), frame.data);
  frame.size = static_cast<std::int32_t>(frame.data.size());
  CHECK(fault_of(frame) == FrameFault::undecodable);
}

TEST_CASE("a PNG of another pixel type is malformed") {
  frame_t frame{};
  encode_png(test_image(16, 16, CV_8UC1), frame);
  cv::imencode(".png", cv::Mat(16, 16, CV_16UC1, cv::Scalar(1000)), frame.data);
  frame.size = static_cast<std::int32_t>(frame.data.size());
  CHECK(fault_of(frame) == FrameFault::malformed);
}

TEST_CASE("images that are no frame are refused") {
  frame_t frame{};
  CHECK_THROWS_AS(encode_raw(cv::Mat(), frame), std::invalid_argument);
  CHECK_THROWS_AS(encode_jpeg(cv::Mat(4, 4, CV_8UC4), frame), std::invalid_argument);
  CHECK_THROWS_AS(encode_png(cv::Mat(4, 4, CV_16UC1), frame), std::invalid_argument);
}

TEST_CASE("a large inline message needs a receive buffer for four, granted and asked for") {
  constexpr std::size_t raw = 921'600, for_four = 4 * raw, much = 100'000'000;
  const auto names = [](const std::optional<std::string>& refusal, const std::string& what) {
    REQUIRE(refusal);
    CHECK(refusal->find("transport: ring") != std::string::npos);
    return refusal->find(what) != std::string::npos;
  };
  CHECK_FALSE(inline_refusal(150'000, 106'496, 212'992));
  CHECK_FALSE(inline_refusal(raw, for_four, for_four));
  const auto kernel = inline_refusal(raw, much, for_four - 1);
  CHECK(names(kernel, "sysctl -w net.core.rmem_max=3686400"));
  CHECK_FALSE(names(kernel, "bus.url"));
  const auto bus = inline_refusal(raw, 2'097'152, much);
  CHECK(names(bus, "'recv_buf_size=3686400' in bus.url"));
  CHECK_FALSE(names(bus, "sysctl"));
  const auto both = inline_refusal(raw, 2'097'152, 212'992);
  CHECK(names(both, "sysctl -w net.core.rmem_max=3686400"));
  CHECK(names(both, "'recv_buf_size=3686400' in bus.url"));
  CHECK(inline_refusal(150'001, 0, 0));
  CHECK_FALSE(inline_refusal(1000, 0));
  CHECK(inline_refusal(std::size_t{1} << 40, std::numeric_limits<std::size_t>::max()));
}

TEST_CASE("what a socket gets is what it asks for, up to what the kernel allows") {
  CHECK(granted_receive_buffer(100'000) == 100'000);
  const std::size_t most = granted_receive_buffer(std::numeric_limits<std::size_t>::max());
  CHECK(most >= granted_receive_buffer(0));
  CHECK(granted_receive_buffer(most) == most);
}
