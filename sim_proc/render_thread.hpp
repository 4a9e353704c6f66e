// Pictures are drawn in a thread of their own, one at a time, so that the world's clock never waits for one.
#pragma once

#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>

#include "geometry/camera_model.hpp"
#include "sim_proc/world/scene.hpp"
#include "sim_proc/world/truth.hpp"

namespace stevedore {

/// What the shutter caught.
struct Exposure {
  std::int64_t frame_seq = 0;
  std::int64_t utime = 0;  ///< as the camera's driver stamps it
  world::Scene scene;
  world::Truth truth;
};

/// The same as it is published: rectified as the pipeline is told, the outlines of truth in its pixels.
struct Picture {
  std::int64_t frame_seq = 0;
  std::int64_t utime = 0;
  cv::Mat pixels;  ///< bgr8
  world::Truth truth;
};

class RenderThread {
 public:
  RenderThread(int threads, const CameraModel& told);
  ~RenderThread();
  RenderThread(const RenderThread&) = delete;
  RenderThread& operator=(const RenderThread&) = delete;

  /// Makes what is made once for a lens and a scenery, so that the first picture takes no longer than others.
  void warm_up(const world::Scene& scene);
  /// From start() until the picture is taken.
  [[nodiscard]] bool is_busy() const;
  /// Only when not busy.
  void start(Exposure exposure);
  /// The picture, once it is drawn. Throws what drawing threw.
  std::optional<Picture> take();
  /// Returns when there is a picture, or a failure, to take. Only when busy.
  void wait();

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace stevedore
