// A frame_t turned into an image and back, however its pixels travel: through a shared-memory ring, raw, JPEG
// or PNG.
#pragma once

#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <stevedore/frame_t.hpp>
#include <string>

#include "runtime/frame_ring.hpp"

namespace stevedore {

/// Consumers call image() and cannot tell which way the pixels came. Never throws; keeps mapped rings open.
class FrameReader {
 public:
  FrameImage image(const frame_t& frame);

 private:
  FrameRingReader ring_;
};

/// Put an image into the message: size, format, encoding and data; the ring fields are cleared. They throw
/// std::invalid_argument for an image that is not gray8 or bgr8.
void encode_raw(const cv::Mat& image, frame_t& frame);
void encode_jpeg(const cv::Mat& image, frame_t& frame, int quality = 95);
void encode_png(const cv::Mat& image, frame_t& frame);

/// Inline messages above this many bytes go over UDP only if the kernel's receive buffer may hold four of
/// them: with the usual 208 kB limit three of four raw 640x480 frames were lost.
constexpr std::size_t inline_limit_bytes = 150'000;

/// The receive buffer that a socket gets which asks for so much: no more than net.core.rmem_max, which older
/// kernels don't show in a network namespace. 0: of one that asks for nothing.
std::size_t granted_receive_buffer(std::size_t asked_bytes);

/// Why an inline message of this size must not be published, as a sentence that says what to do; nothing if
/// it may. asked: what the bus' sockets ask for; granted: what one gets that asks for four such messages.
std::optional<std::string> inline_refusal(std::size_t bytes, std::size_t asked_bytes,
                                          std::size_t granted_bytes);
/// The same on this machine.
std::optional<std::string> inline_refusal(std::size_t bytes, std::size_t asked_bytes);

}  // namespace stevedore
