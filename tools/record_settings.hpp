// The section `record` of the configuration.
#pragma once

#include <string>

namespace stevedore {

struct RecordSettings {
  std::string frames = "raw";
  int jpeg_quality = 95;
  double free_floor_mb = 500;
};

template <class Visitor>
void describe(RecordSettings& s, Visitor& visit) {
  visit.choice(
      "frames", s.frames, {"raw", "png", "jpeg"},
      "how ring frames are stored; raw and png are lossless and replay to the bit; for lcm-logplayer take "
      "jpeg: with the kernel's usual receive buffer larger frames are lost on their way");
  visit("jpeg_quality", s.jpeg_quality, 1.0, 100.0, "%", "raise: sharper edges, a larger log");
  // 500 MB: free space is looked at every 5 s, in which raw 640x480 colour at 30 Hz takes 140 MB
  visit("free_floor_mb", s.free_floor_mb, 0.0, 1e6, "MB",
        "raise: recording stops earlier when the disk fills");
}

}  // namespace stevedore
