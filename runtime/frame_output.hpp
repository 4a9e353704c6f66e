// How a camera's pixels get into its messages: one way for every process that publishes FRAME.
#pragma once

#include <opencv2/core/mat.hpp>
#include <optional>
#include <stevedore/frame_t.hpp>
#include <string>

#include "runtime/frame_ring.hpp"

namespace stevedore {

struct FrameTransport {
  std::string transport = "ring";
  int ring_slots = 16;
  int jpeg_quality = 95;
};

template <class Visitor>
void describe(FrameTransport& s, Visitor& visit) {
  visit.choice("transport", s.transport, {"ring", "jpeg", "png", "raw"},
               "how pixels travel to the consumers");
  visit("ring_slots", s.ring_slots, 8.0, 1024.0, "frames",
        "raise: slower consumers still find their frame, more shared memory");
  visit("jpeg_quality", s.jpeg_quality, 1.0, 100.0, "%", "raise: sharper edges, larger messages");
}

class FrameOutput {
 public:
  /// The ring is made with the first frame.
  FrameOutput(const FrameTransport& settings, std::string ring_name);

  /// Puts the pixels, gray8 or bgr8, where the settings say; message.header.utime must be set. Nothing, or
  /// why they can't be sent to receivers that ask for buffers of so much.
  std::optional<std::string> put(const cv::Mat& pixels, frame_t& message, std::size_t receive_buffer_bytes);

 private:
  const FrameTransport settings_;
  const std::string ring_name_;
  std::optional<FrameRing> ring_;
};

}  // namespace stevedore
