#include "runtime/frame_codec.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <exception>
#include <limits>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <utility>
#include <vector>

#include "runtime/file_descriptor.hpp"

namespace stevedore {
namespace {

using Bytes = std::vector<std::uint8_t>;

struct CodedSize {
  int width_px = 0;
  int height_px = 0;
};

int big_endian_16(const Bytes& data, std::size_t at) {
  return data[at] << 8 | data[at + 1];
}

// Size in the header of a complete JPEG (ITU-T T.81, annex B). A truncated one, which a decoder would fill up
// with grey, lacks the end marker.
std::optional<CodedSize> jpeg_size(const Bytes& data) {
  const std::size_t n = data.size();
  if (n < 4 || data[0] != 0xFF || data[1] != 0xD8 || data[n - 2] != 0xFF || data[n - 1] != 0xD9)
    return std::nullopt;
  std::size_t at = 2;
  while (at + 9 <= n && data[at] == 0xFF) {
    const int marker = data[at + 1];
    const bool start_of_frame =
        marker >= 0xC0 && marker <= 0xCF && marker != 0xC4 && marker != 0xC8 && marker != 0xCC;
    if (start_of_frame) return CodedSize{big_endian_16(data, at + 7), big_endian_16(data, at + 5)};
    at += 2 + static_cast<std::size_t>(big_endian_16(data, at + 2));
  }
  return std::nullopt;
}

// Size in the first chunk of a complete PNG (ISO/IEC 15948, 11.2.2); the last chunk is IEND.
std::optional<CodedSize> png_size(const Bytes& data) {
  constexpr std::array<std::uint8_t, 16> head = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n',
                                                 0,    0,   0,   13,  'I',  'H',  'D',  'R'};
  constexpr std::array<std::uint8_t, 12> tail = {0, 0, 0, 0, 'I', 'E', 'N', 'D', 0xAE, 0x42, 0x60, 0x82};
  if (data.size() < 33 + tail.size() || !std::equal(head.begin(), head.end(), data.begin()) ||
      !std::equal(tail.rbegin(), tail.rend(), data.rbegin()))
    return std::nullopt;
  if (big_endian_16(data, 16) != 0 || big_endian_16(data, 20) != 0)
    return std::nullopt;  // beyond 65535 pixels
  return CodedSize{big_endian_16(data, 18), big_endian_16(data, 22)};
}

FrameImage raw_image(const frame_t& frame, const PixelLayout& layout) {
  if (frame.data.size() != layout.bytes) return {{}, FrameFault::malformed};
  cv::Mat pixels(layout.height_px, layout.width_px, layout.type);
  std::memcpy(pixels.data, frame.data.data(), layout.bytes);
  return {std::move(pixels), FrameFault::none};
}

// The coded size is compared before decoding, so that a small forged file can't ask for gigabytes.
FrameImage decoded_image(const frame_t& frame, const PixelLayout& layout) {
  const auto size = frame.encoding == frame_t::ENCODING_JPEG ? jpeg_size(frame.data) : png_size(frame.data);
  if (!size) return {{}, FrameFault::undecodable};
  if (size->width_px != layout.width_px || size->height_px != layout.height_px)
    return {{}, FrameFault::malformed};
  cv::Mat pixels;
  try {
    pixels = cv::imdecode(frame.data, cv::IMREAD_UNCHANGED);
  } catch (const std::exception&) {
    return {{}, FrameFault::undecodable};
  }
  if (pixels.empty()) return {{}, FrameFault::undecodable};
  if (pixels.cols != layout.width_px || pixels.rows != layout.height_px || pixels.type() != layout.type)
    return {{}, FrameFault::malformed};
  return {std::move(pixels), FrameFault::none};
}

void set_inline(frame_t& frame, std::int8_t encoding, Bytes data) {
  frame.encoding = encoding;
  frame.ring_name.clear();
  frame.ring_generation = 0;
  frame.ring_slot = 0;
  frame.ring_sequence = 0;
  frame.size = static_cast<std::int32_t>(data.size());
  frame.data = std::move(data);
}

void encode(const cv::Mat& image, frame_t& frame, std::int8_t encoding, const char* suffix,
            const std::vector<int>& parameters) {
  set_pixel_layout(image, frame);
  Bytes data;
  if (!cv::imencode(suffix, image, data, parameters))
    throw std::runtime_error(std::string("OpenCV can't encode a ") + suffix);
  set_inline(frame, encoding, std::move(data));
}

}  // namespace

FrameImage FrameReader::image(const frame_t& frame) {
  if (frame.encoding == frame_t::ENCODING_RING) return ring_.read(frame);
  const auto layout = pixel_layout(frame);
  if (!layout || frame.size < 0 || static_cast<std::size_t>(frame.size) != frame.data.size())
    return {{}, FrameFault::malformed};
  switch (frame.encoding) {
    case frame_t::ENCODING_RAW:
      return raw_image(frame, *layout);
    case frame_t::ENCODING_JPEG:
    case frame_t::ENCODING_PNG:
      return decoded_image(frame, *layout);
    default:
      return {{}, FrameFault::malformed};
  }
}

void encode_raw(const cv::Mat& image, frame_t& frame) {
  set_pixel_layout(image, frame);
  const cv::Mat pixels = image.isContinuous() ? image : image.clone();
  set_inline(frame, frame_t::ENCODING_RAW,
             Bytes(pixels.data, pixels.data + pixels.total() * pixels.elemSize()));
}

void encode_jpeg(const cv::Mat& image, frame_t& frame, int quality) {
  encode(image, frame, frame_t::ENCODING_JPEG, ".jpg", {cv::IMWRITE_JPEG_QUALITY, quality});
}

void encode_png(const cv::Mat& image, frame_t& frame) {
  // Level 1: for camera frames a tenth of the time of level 9 at a few per cent more bytes.
  encode(image, frame, frame_t::ENCODING_PNG, ".png", {cv::IMWRITE_PNG_COMPRESSION, 1});
}

std::size_t granted_receive_buffer(std::size_t asked_bytes) {
  const FileDescriptor udp(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const int asked = static_cast<int>(std::min<std::size_t>(asked_bytes, std::numeric_limits<int>::max()));
  int doubled = 0;  // the kernel's own bookkeeping gets as much again
  socklen_t size = sizeof doubled;
  if (asked > 0 && setsockopt(udp.get(), SOL_SOCKET, SO_RCVBUF, &asked, sizeof asked) != 0) return 0;
  if (getsockopt(udp.get(), SOL_SOCKET, SO_RCVBUF, &doubled, &size) != 0) return 0;
  return static_cast<std::size_t>(doubled) / 2;
}

std::optional<std::string> inline_refusal(std::size_t bytes, std::size_t asked_bytes,
                                          std::size_t granted_bytes) {
  const std::size_t needed = 4 * bytes, held = std::min(asked_bytes, granted_bytes);
  if (bytes <= inline_limit_bytes || held >= needed) return std::nullopt;
  const std::string number = std::to_string(needed);
  std::string cure;
  if (granted_bytes < needed)
    cure += "run 'sysctl -w net.core.rmem_max=" + number + "' as root on every receiving host, ";
  if (asked_bytes < needed) cure += "ask for it with 'recv_buf_size=" + number + "' in bus.url, ";
  return "an inline frame of " + std::to_string(bytes / 1000) +
         " kB would be lost on its way: the receive buffers hold " + std::to_string(held) +
         " bytes and four frames need " + number + "; " + cure +
         "or set 'transport: ring' (same host) or 'jpeg'";
}

std::optional<std::string> inline_refusal(std::size_t bytes, std::size_t asked_bytes) {
  if (bytes <= inline_limit_bytes) return std::nullopt;  // no socket for it
  return inline_refusal(bytes, asked_bytes, granted_receive_buffer(4 * bytes));
}

}  // namespace stevedore
