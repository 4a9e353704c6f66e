// A frame that could not be read is counted on FRAME's input.
#pragma once

#include "runtime/bus.hpp"
#include "runtime/frame_codec.hpp"

namespace stevedore {

inline void count_frame_loss(Bus& bus, FrameFault fault) {
  switch (fault) {
    case FrameFault::none:
      break;
    case FrameFault::malformed:
    case FrameFault::undecodable:
      bus.count_loss(channels::frame.name, Loss::malformed);
      break;
    case FrameFault::missing_segment:
    case FrameFault::stale_generation:
      bus.count_loss(channels::frame.name, Loss::stale);
      break;
    case FrameFault::overwritten:
      bus.count_loss(channels::frame.name, Loss::overwritten);
      break;
  }
}

}  // namespace stevedore
