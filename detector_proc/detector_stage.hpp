// FRAME in, ELLIPSES out.
#pragma once

#include "detector_proc/detector.hpp"
#include "runtime/bus.hpp"
#include "runtime/frame_codec.hpp"

namespace stevedore {

class DetectorStage {
 public:
  /// Live, only the newest frame is looked at; a replay delivers every frame.
  DetectorStage(const DetectorSettings& settings, Bus& bus, FrameReader& frames,
                Delivery delivery = Delivery::newest);

 private:
  void on_frame(const frame_t& frame);

  Bus& bus_;
  FrameReader& frames_;
  const std::string method_;
  Detector detector_;
};

}  // namespace stevedore
