#include "runtime/frame_ring.hpp"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <catch2/catch.hpp>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <opencv2/core.hpp>
#include <optional>
#include <thread>
#include <vector>

using namespace stevedore;

namespace {

// A name of its own for each test and process, so that tests can run side by side.
std::string ring_name(const char* test) {
  return std::string("test_") + test + "_" + std::to_string(getpid());
}

cv::Mat noise_image(int rows, int cols, int type, unsigned seed) {
  cv::Mat image(rows, cols, type);
  cv::RNG(seed).fill(image, cv::RNG::UNIFORM, 0, 256);
  return image;
}

bool same(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && cv::norm(a, b, cv::NORM_INF) == 0;
}

// All bytes alike; the writer fills each frame with one value.
bool is_uniform(const cv::Mat& image) {
  const std::size_t bytes = image.total() * image.elemSize();
  return std::memcmp(image.data, image.data + 1, bytes - 1) == 0;
}

frame_t notice_of(FrameRing& ring, const cv::Mat& image, std::int64_t utime = 1) {
  frame_t notice{};
  notice.header.utime = utime;
  ring.write(image, notice);
  return notice;
}

bool exists(const std::string& name) {
  struct stat status = {};
  return stat(("/dev/shm/stevedore." + name).c_str(), &status) == 0;
}

// A file of our own making in the ring's place.
class ForeignSegment {
 public:
  ForeignSegment(const std::string& name, const std::vector<std::uint8_t>& content)
      : path_("/dev/shm/stevedore." + name) {
    const int fd = open(path_.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0644);
    REQUIRE(fd >= 0);
    REQUIRE(write(fd, content.data(), content.size()) == static_cast<ssize_t>(content.size()));
    close(fd);
  }
  ~ForeignSegment() { unlink(path_.c_str()); }
  ForeignSegment(const ForeignSegment&) = delete;
  ForeignSegment& operator=(const ForeignSegment&) = delete;

 private:
  std::string path_;
};

std::vector<std::uint8_t> content_of(const std::string& name) {
  const int fd = open(("/dev/shm/stevedore." + name).c_str(), O_RDONLY);
  REQUIRE(fd >= 0);
  struct stat status = {};
  REQUIRE(fstat(fd, &status) == 0);
  std::vector<std::uint8_t> content(static_cast<std::size_t>(status.st_size));
  REQUIRE(read(fd, content.data(), content.size()) == status.st_size);
  close(fd);
  return content;
}

}  // namespace

TEST_CASE("what is written is read: grey and colour, odd sizes, part of a larger image") {
  FrameRing ring(ring_name("same"), 8, 64 * 48 * 3);
  FrameRingReader reader;
  const cv::Mat large = noise_image(48, 64, CV_8UC3, 1);
  for (const cv::Mat& image : {large, noise_image(48, 64, CV_8UC1, 2), noise_image(1, 1, CV_8UC1, 3),
                               noise_image(7, 5, CV_8UC3, 4), large(cv::Rect(3, 5, 31, 17))}) {
    const frame_t notice = notice_of(ring, image, 77);
    CHECK(notice.encoding == frame_t::ENCODING_RING);
    CHECK(notice.width_px == image.cols);
    CHECK(notice.height_px == image.rows);
    CHECK(notice.size == 0);
    CHECK(notice.ring_name == ring.name());
    CHECK(notice.ring_generation == ring.generation());
    CHECK(notice.ring_sequence % 2 == 0);
    const FrameImage back = reader.read(notice);
    REQUIRE(back);
    CHECK(back.pixels.isContinuous());
    CHECK(same(back.pixels, image));
  }
}

TEST_CASE("the newest frames of a ring are there, the one before them is overwritten") {
  constexpr int slots = 9;
  FrameRing ring(ring_name("round"), slots, 100);
  FrameRingReader reader;
  std::vector<frame_t> notices;
  for (int i = 0; i < 3 * slots; ++i)
    notices.push_back(notice_of(ring, cv::Mat(10, 10, CV_8UC1, cv::Scalar(i)), i));
  for (std::size_t i = 0; i < notices.size(); ++i) {
    const FrameImage image = reader.read(notices[i]);
    if (i + slots < notices.size()) {
      CHECK(image.fault == FrameFault::overwritten);
    } else {
      REQUIRE(image);
      CHECK(image.pixels.at<std::uint8_t>(5, 5) == i);
    }
  }
}

TEST_CASE("an image read stays as it was when its slot is overwritten") {
  FrameRing ring(ring_name("owned"), 8, 100);
  FrameRingReader reader;
  const FrameImage first = reader.read(notice_of(ring, cv::Mat(10, 10, CV_8UC1, cv::Scalar(1))));
  for (int i = 0; i < 16; ++i) notice_of(ring, cv::Mat(10, 10, CV_8UC1, cv::Scalar(99)));
  REQUIRE(first);
  CHECK(same(first.pixels, cv::Mat(10, 10, CV_8UC1, cv::Scalar(1))));
}

TEST_CASE("a larger frame makes a new segment and the reader follows") {
  FrameRing ring(ring_name("grow"), 8, 100);
  FrameRingReader reader;
  const frame_t small = notice_of(ring, cv::Mat(10, 10, CV_8UC1, cv::Scalar(1)));
  REQUIRE(reader.read(small));
  const cv::Mat image = noise_image(100, 100, CV_8UC3, 1);
  const frame_t large = notice_of(ring, image);
  CHECK(large.ring_generation != small.ring_generation);
  const FrameImage back = reader.read(large);
  REQUIRE(back);
  CHECK(same(back.pixels, image));
  CHECK(reader.read(small).fault == FrameFault::stale_generation);
}

TEST_CASE("a camera that starts anew takes the name over and the old one leaves it alone") {
  const std::string name = ring_name("anew");
  FrameRingReader reader;
  auto first = std::make_unique<FrameRing>(name, 8, 100);
  const frame_t old = notice_of(*first, cv::Mat(10, 10, CV_8UC1, cv::Scalar(1)));
  REQUIRE(reader.read(old));

  auto second = std::make_unique<FrameRing>(name, 8, 100);
  CHECK(second->generation() != first->generation());
  const frame_t fresh = notice_of(*second, cv::Mat(10, 10, CV_8UC1, cv::Scalar(2)));
  CHECK(reader.read(fresh));
  CHECK(reader.read(old).fault == FrameFault::stale_generation);
  first.reset();
  CHECK(exists(name));
  CHECK(FrameRingReader().read(fresh));
  second.reset();
  CHECK_FALSE(exists(name));
  CHECK(FrameRingReader().read(fresh).fault == FrameFault::missing_segment);
  CHECK(reader.read(fresh));  // mapped before the camera ended: still a whole frame
}

TEST_CASE("what can't be removed from under the name is left alone: the ring has another") {
  const std::string name = ring_name("theirs"), path = "/dev/shm/stevedore." + name;
  REQUIRE(mkdir(path.c_str(), 0755) == 0);  // no more to be unlinked than a ring of another user
  std::string used;
  {
    FrameRing ring(name, 8, 100);
    const cv::Mat image(10, 20, CV_8UC1, cv::Scalar(3));
    const frame_t notice = notice_of(ring, image), larger = notice_of(ring, cv::Mat(20, 20, CV_8UC1));
    CHECK(notice.ring_name != name);
    CHECK(larger.ring_name == notice.ring_name);
    used = ring.name();
    CHECK(FrameRingReader().read(larger));
  }
  CHECK_FALSE(exists(used));
  CHECK(rmdir(path.c_str()) == 0);
}

TEST_CASE("no notice makes the reader fail") {
  const std::string name = ring_name("bad");
  FrameRing ring(name, 8, 300);
  FrameRingReader reader;
  const frame_t good = notice_of(ring, noise_image(10, 10, CV_8UC1, 1), 5);
  REQUIRE(reader.read(good));
  const auto fault_of = [&](auto change) {
    frame_t notice = good;
    change(notice);
    const FrameFault warm = reader.read(notice).fault;
    CHECK(FrameRingReader().read(notice).fault == warm);
    return warm;
  };
  constexpr FrameFault malformed = FrameFault::malformed;
  CHECK(fault_of([](frame_t& n) { n.ring_slot = 8; }) == malformed);
  CHECK(fault_of([](frame_t& n) { n.ring_slot = -1; }) == malformed);
  CHECK(fault_of([](frame_t& n) { n.ring_slot = 2147483647; }) == malformed);
  CHECK(fault_of([](frame_t& n) { n.ring_slot = 3; }) == malformed);                  // never written
  CHECK(fault_of([](frame_t& n) { n.width_px = n.height_px = 18; }) == malformed);    // > slot
  CHECK(fault_of([](frame_t& n) { n.width_px = n.height_px = 8000; }) == malformed);  // > segment
  CHECK(fault_of([](frame_t& n) { n.width_px = n.height_px = 32767; }) == malformed);
  CHECK(fault_of([](frame_t& n) { n.width_px = 5; }) == malformed);  // fits, but isn't what was written
  CHECK(fault_of([](frame_t& n) { n.format = frame_t::FORMAT_BGR8; }) == malformed);
  CHECK(fault_of([](frame_t& n) { n.width_px = 0; }) == malformed);
  CHECK(fault_of([](frame_t& n) { n.height_px = -10; }) == malformed);
  CHECK(fault_of([](frame_t& n) { n.format = 0; }) == malformed);
  CHECK(fault_of([](frame_t& n) { n.format = 17; }) == malformed);
  CHECK(fault_of([](frame_t& n) { n.encoding = frame_t::ENCODING_RAW; }) == malformed);
  CHECK(fault_of([](frame_t& n) { n.header.utime = 6; }) == malformed);
  CHECK(fault_of([](frame_t& n) { n.size = 4; }) == malformed);
  CHECK(fault_of([](frame_t& n) { n.ring_sequence += 2; }) == malformed);  // a frame not yet written
  CHECK(fault_of([](frame_t& n) { n.ring_sequence -= 1; }) == malformed);
  CHECK(fault_of([](frame_t& n) { n.ring_sequence = 0; }) == malformed);
  CHECK(fault_of([](frame_t& n) { n.ring_sequence = -2; }) == malformed);
  CHECK(fault_of([](frame_t& n) { n.ring_generation += 1; }) == FrameFault::stale_generation);
  CHECK(fault_of([](frame_t& n) { n.ring_generation = 0; }) == FrameFault::stale_generation);
  CHECK(fault_of([](frame_t& n) { n.ring_name += "_not"; }) == FrameFault::missing_segment);
  for (const std::string& odd : {std::string(), std::string("../../etc/passwd"), std::string("/etc/passwd"),
                                 std::string("."), std::string(".."), std::string("a b"),
                                 std::string("a\0b", 3), std::string("\xff\xfe"), std::string(100000, 'a')})
    CHECK(fault_of([&](frame_t& n) { n.ring_name = odd; }) == malformed);
  CHECK(reader.read(good));
}

TEST_CASE("whatever file lies under the name, the reader says that there is no ring") {
  const std::string name = ring_name("foreign");
  frame_t notice;
  std::vector<std::uint8_t> whole;
  {
    FrameRing ring(name, 8, 256);
    notice = notice_of(ring, noise_image(16, 16, CV_8UC1, 1));
    whole = content_of(name);
  }
  const auto fault_of = [&](const std::vector<std::uint8_t>& content) {
    const ForeignSegment segment(name, content);
    return FrameRingReader().read(notice).fault;
  };
  REQUIRE(fault_of(whole) == FrameFault::none);
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{1}, std::size_t{63}, std::size_t{64}, whole.size() - 1})
    CHECK(fault_of({whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)}) ==
          FrameFault::missing_segment);
  CHECK(fault_of(std::vector<std::uint8_t>(5000, 0)) == FrameFault::missing_segment);
  CHECK(fault_of(std::vector<std::uint8_t>(5000, 0xFF)) == FrameFault::missing_segment);
  // magic, layout version, slots, slot bytes; not the generation (word 2)
  for (const std::size_t word : {0U, 1U, 3U, 4U}) {
    auto broken = whole;
    broken[8 * word + 7] ^= 0x40;
    CHECK(fault_of(broken) == FrameFault::missing_segment);
  }
  auto other = whole;
  other[8 * 2] ^= 1;
  CHECK(fault_of(other) == FrameFault::stale_generation);
}

TEST_CASE("a directory or a pipe in the ring's place neither blocks nor harms") {
  const std::string name = ring_name("pipe");
  const std::string path = "/dev/shm/stevedore." + name;
  frame_t notice;
  {
    FrameRing ring(name, 8, 256);
    notice = notice_of(ring, noise_image(16, 16, CV_8UC1, 1));
  }
  REQUIRE(mkfifo(path.c_str(), 0600) == 0);
  CHECK(FrameRingReader().read(notice).fault == FrameFault::missing_segment);
  unlink(path.c_str());
  REQUIRE(mkdir(path.c_str(), 0700) == 0);
  CHECK(FrameRingReader().read(notice).fault == FrameFault::missing_segment);
  rmdir(path.c_str());
}

TEST_CASE("a ring says what is wrong with its arguments") {
  CHECK_THROWS_AS(FrameRing("a/b", 8, 100), std::invalid_argument);
  CHECK_THROWS_AS(FrameRing("", 8, 100), std::invalid_argument);
  CHECK_THROWS_AS(FrameRing(ring_name("few"), 7, 100), std::invalid_argument);
  CHECK_THROWS_AS(FrameRing(ring_name("vast"), 8, std::size_t{1} << 60), std::invalid_argument);
  FrameRing ring(ring_name("arguments"), 8, 100);
  frame_t notice{};
  CHECK_THROWS_AS(ring.write(cv::Mat(), notice), std::invalid_argument);
  CHECK_THROWS_AS(ring.write(cv::Mat(2, 2, CV_16UC1), notice), std::invalid_argument);
  CHECK_THROWS_AS(ring.write(cv::Mat(2, 2, CV_8UC4), notice), std::invalid_argument);
  CHECK_THROWS_AS(ring.write(cv::Mat(1, 40000, CV_8UC1), notice), std::invalid_argument);
}

namespace {

// Notices of the last `slots` frames, handed from the writer to readers.
class Board {
 public:
  explicit Board(std::size_t size) : notices_(size) {}
  void post(const frame_t& notice) {
    const std::lock_guard lock(mutex_);
    notices_[count_++ % notices_.size()] = notice;
  }
  // The notice posted `age` before the newest.
  std::optional<frame_t> get(std::size_t age) {
    const std::lock_guard lock(mutex_);
    if (count_ <= age) return std::nullopt;
    return notices_[(count_ - 1 - age) % notices_.size()];
  }

 private:
  std::mutex mutex_;
  std::vector<frame_t> notices_;
  std::size_t count_ = 0;
};

struct Outcome {
  int whole = 0;
  int overwritten = 0;
  int mixed = 0;
  int other = 0;
};

void count(const FrameImage& image, Outcome& outcome) {
  if (image) {
    ++(is_uniform(image.pixels) ? outcome.whole : outcome.mixed);
  } else {
    ++(image.fault == FrameFault::overwritten ? outcome.overwritten : outcome.other);
  }
}

}  // namespace

TEST_CASE("a hammering writer: whole images or overwritten, never a mixed one") {
  constexpr int slots = FrameRing::min_slots;
  FrameRing ring(ring_name("hammer"), slots, 320 * 240);
  Board board(slots);
  std::atomic<bool> stop = false;
  std::thread writer([&] {
    for (std::int64_t i = 0; !stop; ++i)
      board.post(notice_of(ring, cv::Mat(240, 320, CV_8UC1, cv::Scalar(static_cast<double>(i % 251))), i));
  });
  FrameRingReader reader;
  Outcome outcome;
  // The oldest notice names the slot that the writer comes to next: it is being overwritten while it is read.
  for (std::size_t turn = 0; outcome.whole < 500 || outcome.overwritten < 500; ++turn)
    if (const auto notice = board.get(turn % slots)) count(reader.read(*notice), outcome);
  stop = true;
  writer.join();
  std::printf("hammered: %d whole, %d overwritten\n", outcome.whole, outcome.overwritten);
  CHECK(outcome.mixed == 0);
  CHECK(outcome.other == 0);
}

namespace {

// What goes through the pipe from the writing process.
struct SmallNotice {
  std::int64_t utime, generation, slot, sequence;
};

// Writes frames until nobody reads the pipe any more.
void write_frames(const std::string& name, int pipe_end) {
  signal(SIGPIPE, SIG_IGN);
  FrameRing ring(name, FrameRing::min_slots, 320 * 240);
  for (std::int64_t i = 0;; ++i) {
    const frame_t n =
        notice_of(ring, cv::Mat(240, 320, CV_8UC1, cv::Scalar(static_cast<double>(i % 251))), i);
    const SmallNotice message{i, n.ring_generation, n.ring_slot, n.ring_sequence};
    if (write(pipe_end, &message, sizeof message) != sizeof message) return;
  }
}

}  // namespace

TEST_CASE("the same between two processes") {
  int ends[2];
  REQUIRE(pipe(ends) == 0);
  REQUIRE(fcntl(ends[1], F_SETPIPE_SZ, 4096) > 0);  // the writer is never far ahead
  const std::string name = ring_name("processes");
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    close(ends[0]);
    write_frames(name, ends[1]);
    _exit(0);
  }
  close(ends[1]);
  FrameRingReader reader;
  Outcome outcome;
  const auto read_frame = [&](const SmallNotice& message) {
    frame_t notice{};
    notice.header.utime = message.utime;
    notice.width_px = 320;
    notice.height_px = 240;
    notice.format = frame_t::FORMAT_GRAY8;
    notice.encoding = frame_t::ENCODING_RING;
    notice.ring_name = name;
    notice.ring_generation = message.generation;
    notice.ring_slot = static_cast<std::int32_t>(message.slot);
    notice.ring_sequence = message.sequence;
    count(reader.read(notice), outcome);
  };
  constexpr std::size_t kept = FrameRing::min_slots;
  std::array<SmallNotice, kept> last{};
  SmallNotice message{};
  for (std::size_t i = 0; outcome.whole < 200 || outcome.overwritten < 200; ++i) {
    if (read(ends[0], &message, sizeof message) != sizeof message) break;
    if (i >= kept) read_frame(last[i % kept]);  // the slot that the writer is at now
    read_frame(last[i % kept] = message);
  }
  close(ends[0]);
  int status = -1;
  REQUIRE(waitpid(child, &status, 0) == child);
  CHECK(status == 0);
  std::printf("two processes: %d whole, %d overwritten\n", outcome.whole, outcome.overwritten);
  CHECK(outcome.whole >= 200);
  CHECK(outcome.overwritten >= 200);
  CHECK(outcome.mixed == 0);
  CHECK(outcome.other == 0);
  CHECK_FALSE(exists(name));
}
