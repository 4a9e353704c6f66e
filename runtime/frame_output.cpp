#include "runtime/frame_output.hpp"

#include <exception>

#include "runtime/frame_codec.hpp"

namespace stevedore {

FrameOutput::FrameOutput(const FrameTransport& settings, std::string ring_name)
    : settings_(settings), ring_name_(std::move(ring_name)) {}

std::optional<std::string> FrameOutput::put(const cv::Mat& pixels, frame_t& message,
                                            std::size_t receive_buffer_bytes) {
  try {
    if (settings_.transport == "ring") {
      if (!ring_) ring_.emplace(ring_name_, settings_.ring_slots, pixels.total() * pixels.elemSize());
      ring_->write(pixels, message);
      return std::nullopt;
    }
    if (settings_.transport == "jpeg") encode_jpeg(pixels, message, settings_.jpeg_quality);
    if (settings_.transport == "png") encode_png(pixels, message);
    if (settings_.transport == "raw") encode_raw(pixels, message);
    return inline_refusal(static_cast<size_t>(message.getEncodedSize()), receive_buffer_bytes);
  } catch (const std::exception& error) {
    return error.what();
  }
}

}  // namespace stevedore
