// Ropes and wires: lines drawn by the share of each pixel that they cover, however thin they are.
#pragma once

#include <vector>

#include "sim_proc/world/view.hpp"

namespace stevedore::world {

class SeenStrand {
 public:
  SeenStrand(const View& view, const Strand& strand, std::uint8_t motion);

  [[nodiscard]] const PixelRect& rect() const { return rect_; }
  /// Rows first..last-1. shares: scratch, as wide as the picture, all 0 before and after.
  void draw(const Light& light, int first, int last, Picture& picture, std::vector<float>& shares) const;

 private:
  /// In pixels; depth and radius change evenly from one end to the other.
  struct Piece {
    Eigen::Vector2f from, to;
    float from_depth_m, to_depth_m, from_radius_px, to_radius_px;
    PixelRect rect;
  };
  void add(const View& view, const Eigen::Vector3d& from_camera_m, const Eigen::Vector3d& to_camera_m,
           double radius_m);
  void draw_row(const Light& light, const PictureRow& row, std::vector<float>& shares) const;
  void cover(const Piece& piece, const PictureRow& row, std::vector<float>& shares) const;

  Surface surface_;
  std::vector<Piece> pieces_;
  PixelRect rect_;
  std::uint8_t motion_;
};

}  // namespace stevedore::world
