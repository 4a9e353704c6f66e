// From light to grey levels: lens blur, veils of glare and spray, gain, noise, the camera's response.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <vector>

#include "sim_proc/world/motion.hpp"
#include "sim_proc/world/view.hpp"

namespace stevedore::world {

/// Grey level 0..1 that a camera gives for light 0..1: the inverse of linear_light of geometry.
double level_of_light(double light, const Response& response);

/// Standard normal numbers, drawn once; a row of noise is a run of them from a place that the frame's seed,
/// the row and the channel choose.
class NoiseTile {
 public:
  NoiseTile();
  [[nodiscard]] const float* run(std::uint64_t frame_seed, int row, int channel) const;
  static constexpr int longest_run = 16384;

 private:
  std::vector<float> values_;
};

/// Levels of 2^15 steps of light.
class ResponseTable {
 public:
  explicit ResponseTable(const Response& response);
  [[nodiscard]] std::uint8_t level(float light) const {
    return levels_[static_cast<size_t>(light * static_cast<float>(steps) + 0.5F)];
  }
  [[nodiscard]] bool is_for(const Response& response) const {
    return response.curve == response_.curve && response.gamma == response_.gamma;
  }

 private:
  static constexpr int steps = 1 << 15;  // a step is a tenth of a level where the sRGB curve is steepest
  Response response_;
  std::vector<std::uint8_t> levels_;
};

/// Light that the lens itself adds.
class Veil {
 public:
  Veil(const Scene& scene, const View& view, const Picture& picture);
  /// In full scales.
  void add(int v, const RowOut& row, float full_scale) const;

 private:
  struct Droplet {
    float u, v, radius;
    Eigen::Vector3f light;
  };
  float glare_, sun_u_, sun_v_, reach_px_;
  Eigen::Vector3f glare_colour_;
  int width_;
  std::vector<Droplet> droplets_;
};

/// What developing needs beside the picture; one for each frame.
struct Darkroom {
  const Scene& scene;
  const LensRays& rays;
  const Motions& motions;
  const Picture& picture;
  const NoiseTile& noise;
  const ResponseTable& response;
  const Veil& veil;
};

/// Memory of one thread.
struct DevelopScratch {
  std::vector<float> rows;  ///< of the shutter's picture, as many as the lens blur is high
  std::vector<float> padded, light;
};

/// Rows first..last-1 of the finished picture.
void develop_rows(const Darkroom& darkroom, int first, int last, DevelopScratch& scratch, cv::Mat& bgr);

}  // namespace stevedore::world
