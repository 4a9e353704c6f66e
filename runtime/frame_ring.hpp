// Frames through shared memory: a ring of slots that one camera writes and any number of processes read.
//
// A small notice (frame_t with ENCODING_RING) travels over the bus and says where the pixels are: the ring's
// name, the generation of its segment, the slot, and the slot's sequence number when the frame was complete.
// The ring is a sequence lock: the writer never waits, and a reader that was too slow learns so instead of
// getting a mixed image. Pixels are copied with relaxed atomic words between an acquire load of the sequence
// and an acquire fence before it is looked at again: H.-J. Boehm, "Can seqlocks get along with programming
// language memory models?" (MSPC 2012), fig. 6.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <stevedore/frame_t.hpp>
#include <string>

namespace stevedore {

/// Why a frame_t gave no image. Each is counted as one lost frame by the receiver.
enum class FrameFault {
  none,
  malformed,         ///< the message contradicts itself or its ring
  missing_segment,   ///< no ring of that name, or what is there is no ring
  stale_generation,  ///< the ring was created anew since
  overwritten,       ///< the ring went round before or while the slot was read
  undecodable,       ///< inline data that is no such JPEG or PNG
};
const char* to_string(FrameFault fault);

/// gray8 (CV_8UC1) or bgr8 (CV_8UC3), contiguous and owned, or the reason why there is none.
struct FrameImage {
  cv::Mat pixels;
  FrameFault fault = FrameFault::none;
  explicit operator bool() const { return fault == FrameFault::none; }
};

/// No camera here comes near it; it bounds what a forged message can make a reader allocate (200 MB).
constexpr std::size_t max_frame_pixels = std::size_t{1} << 26;

struct PixelLayout {
  int width_px = 0;
  int height_px = 0;
  int type = 0;  ///< CV_8UC1 or CV_8UC3
  std::size_t bytes = 0;
};
/// What a message says its decoded pixels are; nothing if the size or the format is impossible.
std::optional<PixelLayout> pixel_layout(const frame_t& frame);

/// Fills width, height and format. Throws std::invalid_argument for anything but a gray8 or bgr8 image that
/// fits.
void set_pixel_layout(const cv::Mat& image, frame_t& frame);

struct RingSegment;  // one mapping of the shared memory

/// Writer: owns the shared-memory object /stevedore.NAME. One writer per name; a second one takes the name
/// over, or takes another name where it may not remove what is there. The segment is never truncated nor
/// reused: a mapping stays valid for as long as a reader keeps it.
class FrameRing {
 public:
  /// NAME is 1 to 64 of [A-Za-z0-9_-]. Throws std::invalid_argument or, when the memory can't be had (all of
  /// it is reserved at once), std::system_error with a sentence that says what to do.
  FrameRing(std::string name, int slots, std::size_t slot_bytes);
  ~FrameRing();
  FrameRing(const FrameRing&) = delete;
  FrameRing& operator=(const FrameRing&) = delete;

  /// Copies the pixels in and fills the notice's size, format, encoding and ring fields. notice.header.utime
  /// must be set before: the slot carries it. A frame that doesn't fit makes a larger segment with a new
  /// generation; throws as the constructor does.
  void write(const cv::Mat& image, frame_t& notice);

  [[nodiscard]] const std::string& name() const { return name_; }
  [[nodiscard]] std::int64_t generation() const;

  static constexpr int min_slots = 8;  ///< a tracker 200 ms behind a 30 Hz camera still finds its frame
  static constexpr int max_slots = 1024;

 private:
  void create(std::size_t slot_bytes);
  void unlink_own() noexcept;

  std::string name_;
  int slots_;
  int next_slot_ = 0;
  std::unique_ptr<RingSegment> segment_;
};

/// Reader: maps rings by name when a notice first asks for them, read-only. Never throws or crashes whatever
/// the notice says or whatever file lies under the name. (It relies on nobody truncating a segment that is
/// mapped: the writer above never does.)
class FrameRingReader {
 public:
  FrameRingReader();
  ~FrameRingReader();
  FrameRingReader(FrameRingReader&&) noexcept;
  FrameRingReader& operator=(FrameRingReader&&) noexcept;

  FrameImage read(const frame_t& notice);

 private:
  const RingSegment* find(const frame_t& notice, FrameFault& fault);

  std::map<std::string, std::unique_ptr<RingSegment>> segments_;
};

}  // namespace stevedore
