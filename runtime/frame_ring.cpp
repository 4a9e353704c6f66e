#include "runtime/frame_ring.hpp"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <limits>
#include <random>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "runtime/file_descriptor.hpp"

#if defined(__SANITIZE_THREAD__) && !defined(__clang__)
// gcc's thread sanitizer doesn't model fences. Every shared word is accessed atomically, so it has no race to
// report.
#pragma GCC diagnostic ignored "-Wtsan"
#endif

namespace stevedore {
namespace {

using Word = std::uint64_t;
using AtomicWord = std::atomic_ref<Word>;
static_assert(AtomicWord::is_always_lock_free, "a lock would be private to each process");

constexpr Word ring_magic = 0x474E495256545331;  // bytes "1STVRING"
constexpr Word layout_version = 1;
constexpr std::size_t line_bytes = 64;  // slots share no cache line
constexpr std::size_t max_slot_bytes = 3 * max_frame_pixels;

// The segment: one SegmentHeader, a SlotHeader for each slot, then the slots' pixels. All of it is 64-bit
// words.
struct alignas(line_bytes) SegmentHeader {
  Word magic;  // written last: a segment without it isn't ready
  Word layout_version;
  Word generation;
  Word slots;
  Word slot_bytes;
};
struct alignas(line_bytes) SlotHeader {
  Word sequence;  // 0: never written; odd: being written; even: complete
  Word utime;
  Word shape;
};

std::size_t segment_bytes(std::size_t slots, std::size_t slot_bytes) {
  return sizeof(SegmentHeader) + slots * (sizeof(SlotHeader) + slot_bytes);
}

Word shape_word(const frame_t& frame) {
  return static_cast<Word>(frame.width_px) | static_cast<Word>(frame.height_px) << 16 |
         static_cast<Word>(frame.format) << 32;
}

// A name that is one plain file name whatever a message says: no slash, no dots.
bool is_ring_name(const std::string& name) {
  const auto allowed = [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
  };
  return !name.empty() && name.size() <= 64 && std::all_of(name.begin(), name.end(), allowed);
}

std::string object_name(const std::string& name) {
  return "/stevedore." + name;
}

Word random_generation() {
  std::random_device device;
  return Word{device()} << 32 | device();
}

[[noreturn]] void fail(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

// Relaxed atomic words in place of memcpy, so that a concurrent overwrite is a stale value and not a data
// race. Compilers don't unroll loops over atomics: a cache line a turn comes near memcpy's speed.
constexpr std::size_t line_words = line_bytes / sizeof(Word);

void store_word(Word& shared, const std::uint8_t* from, std::size_t bytes = sizeof(Word)) {
  Word word = 0;
  std::memcpy(&word, from, bytes);
  AtomicWord(shared).store(word, std::memory_order_relaxed);
}

void load_word(Word& shared, std::uint8_t* to, std::size_t bytes = sizeof(Word)) {
  const Word word = AtomicWord(shared).load(std::memory_order_relaxed);
  std::memcpy(to, &word, bytes);
}

void copy_in(Word* shared, const std::uint8_t* from, std::size_t bytes) {
  for (; bytes >= line_bytes; bytes -= line_bytes, from += line_bytes, shared += line_words)
#pragma GCC unroll 8
    for (std::size_t i = 0; i < line_words; ++i) store_word(shared[i], from + i * sizeof(Word));
  for (; bytes >= sizeof(Word); bytes -= sizeof(Word), from += sizeof(Word)) store_word(*shared++, from);
  if (bytes > 0) store_word(*shared, from, bytes);
}

void copy_out(Word* shared, std::uint8_t* to, std::size_t bytes) {
  for (; bytes >= line_bytes; bytes -= line_bytes, to += line_bytes, shared += line_words)
#pragma GCC unroll 8
    for (std::size_t i = 0; i < line_words; ++i) load_word(shared[i], to + i * sizeof(Word));
  for (; bytes >= sizeof(Word); bytes -= sizeof(Word), to += sizeof(Word)) load_word(*shared++, to);
  if (bytes > 0) load_word(*shared, to, bytes);
}

}  // namespace

// Numbers are copied out of the shared header once, so that nobody can change them after they were checked.
struct RingSegment {
  void* base = MAP_FAILED;
  std::size_t bytes = 0;
  Word generation = 0;
  std::size_t slots = 0;
  std::size_t slot_bytes = 0;

  RingSegment() = default;
  ~RingSegment() {
    if (base != MAP_FAILED) munmap(base, bytes);
  }
  RingSegment(const RingSegment&) = delete;
  RingSegment& operator=(const RingSegment&) = delete;

  [[nodiscard]] SegmentHeader& header() const { return *static_cast<SegmentHeader*>(base); }
  [[nodiscard]] SlotHeader& slot(std::size_t index) const {
    return reinterpret_cast<SlotHeader*>(static_cast<std::byte*>(base) + sizeof(SegmentHeader))[index];
  }
  [[nodiscard]] Word* pixels(std::size_t index) const {
    return reinterpret_cast<Word*>(static_cast<std::byte*>(base) + segment_bytes(slots, 0) +
                                   index * slot_bytes);
  }
};

namespace {

// Maps what lies under the name if it is a complete ring of this layout, else nothing.
std::unique_ptr<RingSegment> map_existing(const std::string& name) {
  // O_NONBLOCK: a pipe under this name must not block
  const FileDescriptor fd(shm_open(object_name(name).c_str(), O_RDONLY | O_NONBLOCK, 0));
  struct stat status = {};
  if (fd.get() < 0 || fstat(fd.get(), &status) != 0 || !S_ISREG(status.st_mode)) return nullptr;
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size < sizeof(SegmentHeader)) return nullptr;

  auto segment = std::make_unique<RingSegment>();
  segment->bytes = size;
  segment->base = mmap(nullptr, size, PROT_READ, MAP_SHARED, fd.get(), 0);
  if (segment->base == MAP_FAILED) return nullptr;
  SegmentHeader& header = segment->header();
  if (AtomicWord(header.magic).load(std::memory_order_acquire) != ring_magic) return nullptr;
  const auto load = [](Word& word) { return AtomicWord(word).load(std::memory_order_relaxed); };
  const Word slots = load(header.slots);
  const Word slot_bytes = load(header.slot_bytes);
  if (load(header.layout_version) != layout_version) return nullptr;
  if (slots == 0 || slots > FrameRing::max_slots || slot_bytes > max_slot_bytes ||
      slot_bytes % line_bytes != 0 || segment_bytes(slots, slot_bytes) > size)
    return nullptr;
  segment->generation = load(header.generation);
  segment->slots = slots;
  segment->slot_bytes = slot_bytes;
  return segment;
}

}  // namespace

const char* to_string(FrameFault fault) {
  switch (fault) {
    case FrameFault::none:
      return "none";
    case FrameFault::malformed:
      return "malformed";
    case FrameFault::missing_segment:
      return "missing segment";
    case FrameFault::stale_generation:
      return "stale generation";
    case FrameFault::overwritten:
      return "overwritten";
    case FrameFault::undecodable:
      return "undecodable";
  }
  return "unknown";
}

std::optional<PixelLayout> pixel_layout(const frame_t& frame) {
  if (frame.width_px <= 0 || frame.height_px <= 0) return std::nullopt;
  if (frame.format != frame_t::FORMAT_GRAY8 && frame.format != frame_t::FORMAT_BGR8) return std::nullopt;
  const bool grey = frame.format == frame_t::FORMAT_GRAY8;
  const std::size_t pixels =
      static_cast<std::size_t>(frame.width_px) * static_cast<std::size_t>(frame.height_px);
  if (pixels > max_frame_pixels) return std::nullopt;
  return PixelLayout{frame.width_px, frame.height_px, grey ? CV_8UC1 : CV_8UC3, grey ? pixels : 3 * pixels};
}

void set_pixel_layout(const cv::Mat& image, frame_t& frame) {
  constexpr int max_side_px = std::numeric_limits<std::int16_t>::max();
  if (image.dims != 2 || image.empty() || (image.type() != CV_8UC1 && image.type() != CV_8UC3) ||
      image.cols > max_side_px || image.rows > max_side_px || image.total() > max_frame_pixels)
    throw std::invalid_argument("a frame is a gray8 or bgr8 image of 1 to 32767 pixels a side");
  frame.width_px = static_cast<std::int16_t>(image.cols);
  frame.height_px = static_cast<std::int16_t>(image.rows);
  frame.format = image.channels() == 1 ? frame_t::FORMAT_GRAY8 : frame_t::FORMAT_BGR8;
}

FrameRing::FrameRing(std::string name, int slots, std::size_t slot_bytes)
    : name_(std::move(name)), slots_(slots) {
  if (!is_ring_name(name_))
    throw std::invalid_argument("ring name '" + name_ + "': 1 to 64 of letters, digits, '_' and '-'");
  if (slots < min_slots || slots > max_slots)
    throw std::invalid_argument("a frame ring has " + std::to_string(min_slots) + " to " +
                                std::to_string(max_slots) + " slots, not " + std::to_string(slots));
  create(slot_bytes);
}

FrameRing::~FrameRing() {
  unlink_own();
}

std::int64_t FrameRing::generation() const {
  return segment_ ? static_cast<std::int64_t>(segment_->generation) : 0;
}

// The name is removed only if it still leads to this ring: a camera started since may have taken it over.
void FrameRing::unlink_own() noexcept {
  if (!segment_) return;
  const auto there = map_existing(name_);
  if (there && there->generation == segment_->generation) shm_unlink(object_name(name_).c_str());
  segment_.reset();
}

void FrameRing::create(std::size_t slot_bytes) {
  if (slot_bytes > max_slot_bytes)
    throw std::invalid_argument("a frame ring's slot of more than 64 megapixels");
  unlink_own();
  // What a killed camera left; its readers keep their mapping. Where another user's can't be removed, a name
  // of this user's does as well: readers have it from the notice.
  if (shm_unlink(object_name(name_).c_str()) != 0 && errno != ENOENT) {
    name_ = name_.substr(0, 50) + "-" + std::to_string(getuid());
    shm_unlink(object_name(name_).c_str());
  }
  const std::string object = object_name(name_);
  const auto slots = static_cast<std::size_t>(slots_);
  slot_bytes = (std::max<std::size_t>(slot_bytes, 1) + line_bytes - 1) / line_bytes * line_bytes;

  auto segment = std::make_unique<RingSegment>();
  segment->bytes = segment_bytes(slots, slot_bytes);
  const FileDescriptor fd(shm_open(object.c_str(), O_RDWR | O_CREAT | O_EXCL, 0644));
  if (fd.get() < 0)
    fail(errno, "can't create shared memory " + object + " (`doctor` tells how /dev/shm should be)");
  // Reserved now: running out of memory later would be a SIGBUS at some pixel.
  if (const int error = posix_fallocate(fd.get(), 0, static_cast<off_t>(segment->bytes)); error != 0) {
    shm_unlink(object.c_str());
    fail(error, "shared memory " + object + " needs " + std::to_string(segment->bytes >> 20) +
                    " MB: make room in /dev/shm or use fewer ring_slots");
  }
  segment->base = mmap(nullptr, segment->bytes, PROT_READ | PROT_WRITE, MAP_SHARED, fd.get(), 0);
  if (segment->base == MAP_FAILED) {
    const int error = errno;
    shm_unlink(object.c_str());
    fail(error, "can't map shared memory " + object);
  }

  SegmentHeader& header = segment->header();
  header.layout_version = layout_version;
  header.generation = segment->generation = random_generation();
  header.slots = segment->slots = slots;
  header.slot_bytes = segment->slot_bytes = slot_bytes;
  AtomicWord(header.magic).store(ring_magic, std::memory_order_release);
  segment_ = std::move(segment);
  next_slot_ = 0;
}

void FrameRing::write(const cv::Mat& image, frame_t& notice) {
  set_pixel_layout(image, notice);
  const std::size_t bytes = image.total() * image.elemSize();
  if (!segment_ || bytes > segment_->slot_bytes) create(bytes);
  const cv::Mat pixels = image.isContinuous() ? image : image.clone();

  const auto index = static_cast<std::size_t>(next_slot_);
  SlotHeader& slot = segment_->slot(index);
  AtomicWord sequence(slot.sequence);
  const Word complete = sequence.load(std::memory_order_relaxed) + 2;
  sequence.store(complete - 1, std::memory_order_relaxed);
  std::atomic_thread_fence(std::memory_order_release);  // nobody sees a new pixel with the old sequence
  AtomicWord(slot.utime).store(static_cast<Word>(notice.header.utime), std::memory_order_relaxed);
  AtomicWord(slot.shape).store(shape_word(notice), std::memory_order_relaxed);
  copy_in(segment_->pixels(index), pixels.data, bytes);
  sequence.store(complete, std::memory_order_release);

  notice.encoding = frame_t::ENCODING_RING;
  notice.ring_name = name_;
  notice.ring_generation = generation();
  notice.ring_slot = next_slot_;
  notice.ring_sequence = static_cast<std::int64_t>(complete);
  notice.size = 0;
  notice.data.clear();
  next_slot_ = (next_slot_ + 1) % slots_;
}

FrameRingReader::FrameRingReader() = default;
FrameRingReader::~FrameRingReader() = default;
FrameRingReader::FrameRingReader(FrameRingReader&&) noexcept = default;
FrameRingReader& FrameRingReader::operator=(FrameRingReader&&) noexcept = default;

const RingSegment* FrameRingReader::find(const frame_t& notice, FrameFault& fault) {
  const auto wanted = static_cast<Word>(notice.ring_generation);
  const auto known = segments_.find(notice.ring_name);
  if (known != segments_.end() && known->second->generation == wanted) return known->second.get();

  auto segment = map_existing(notice.ring_name);
  if (!segment) {
    fault = FrameFault::missing_segment;
    return nullptr;
  }
  if (segment->generation != wanted) {
    fault = FrameFault::stale_generation;
    return nullptr;
  }
  return (segments_[notice.ring_name] = std::move(segment)).get();
}

FrameImage FrameRingReader::read(const frame_t& notice) {
  const auto layout = pixel_layout(notice);
  if (!layout || notice.encoding != frame_t::ENCODING_RING || notice.size != 0 || !notice.data.empty() ||
      !is_ring_name(notice.ring_name) || notice.ring_slot < 0 || notice.ring_sequence <= 0 ||
      notice.ring_sequence % 2 != 0)
    return {{}, FrameFault::malformed};
  FrameFault fault = FrameFault::none;
  const RingSegment* segment = find(notice, fault);
  if (!segment) return {{}, fault};
  const auto index = static_cast<std::size_t>(notice.ring_slot);
  if (index >= segment->slots || layout->bytes > segment->slot_bytes) return {{}, FrameFault::malformed};

  SlotHeader& slot = segment->slot(index);
  AtomicWord sequence(slot.sequence);
  const auto wanted = static_cast<Word>(notice.ring_sequence);
  const Word before = sequence.load(std::memory_order_acquire);
  if (before != wanted) return {{}, before > wanted ? FrameFault::overwritten : FrameFault::malformed};
  cv::Mat pixels(layout->height_px, layout->width_px, layout->type);
  copy_out(segment->pixels(index), pixels.data, layout->bytes);
  const Word utime = AtomicWord(slot.utime).load(std::memory_order_relaxed);
  const Word shape = AtomicWord(slot.shape).load(std::memory_order_relaxed);
  std::atomic_thread_fence(
      std::memory_order_acquire);  // the pixels were read before the sequence is read again
  if (sequence.load(std::memory_order_relaxed) != wanted) return {{}, FrameFault::overwritten};
  if (utime != static_cast<Word>(notice.header.utime) || shape != shape_word(notice))
    return {{}, FrameFault::malformed};
  return {std::move(pixels), FrameFault::none};
}

}  // namespace stevedore
