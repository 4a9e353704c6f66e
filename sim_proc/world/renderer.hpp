// The picture of a scene: an analytic ray caster with the exact lens, edges of paint by analytic coverage,
// silhouettes of solid things by supersampling, motion blur along the image flow, lens blur, noise from tiles
// drawn once.
#pragma once

#include <memory>
#include <opencv2/core.hpp>

#include "sim_proc/world/scene.hpp"

namespace stevedore::world {

class Renderer {
 public:
  /// threads: rows are shared out; the picture is the same to the bit for any number.
  explicit Renderer(int threads);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// bgr8, of eye.lens.given's size. What is computed once for a lens is kept for the next picture with it.
  cv::Mat render(const Scene& scene);

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace stevedore::world
