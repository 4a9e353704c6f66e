// FRAME in, ELLIPSES out; with region search TRACKS in, for where to look.
#pragma once

#include <optional>

#include "detector_proc/detector.hpp"
#include "runtime/bus.hpp"
#include "runtime/frame_codec.hpp"

namespace stevedore {

class DetectorStage {
 public:
  /// Live, only the newest frame is looked at; a replay delivers every frame.
  DetectorStage(const DetectorSettings& settings, const std::optional<CameraModel>& camera, Bus& bus,
                FrameReader& frames, Delivery delivery = Delivery::newest);

 private:
  void on_frame(const frame_t& frame);

  /// Every mark that is followed, found where it is expected; nothing if one is not, or if it is the whole
  /// frame's turn.
  [[nodiscard]] std::optional<std::vector<Detection>> search_regions(const frame_t& frame,
                                                                     const cv::Mat& image) const;

  Bus& bus_;
  FrameReader& frames_;
  const DetectorSettings settings_;
  Detector detector_;
  std::optional<tracks_t> tracks_;  ///< the newest
  int64_t whole_frame_seq_ = -1;    ///< of the frame that was last searched as a whole
};

}  // namespace stevedore
