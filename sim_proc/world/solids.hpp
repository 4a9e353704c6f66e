// Things with a body: buckets, tyres, people, the sides of decks. Ray cast where they may be; their
// silhouettes, and the edges between their parts, by sixteen rays a pixel.
#pragma once

#include <variant>
#include <vector>

#include "sim_proc/world/shapes.hpp"
#include "sim_proc/world/texture.hpp"
#include "sim_proc/world/view.hpp"

namespace stevedore::world {

class Solid {
 public:
  using Hit = Meeting<float>;

  struct Box {
    Vec3<float> lowest, highest;
  };
  struct Torus {
    float outer, tube;
  };
  struct Sausage {
    Vec3<float> from, to;
    float radius;
  };

  static Solid of(const View& view, const Deck& deck, std::uint8_t motion);
  static Solid of(const View& view, const Bucket& bucket, std::uint8_t motion);
  static Solid of(const View& view, const Tyre& tyre, std::uint8_t motion);
  static Solid of(const View& view, const Capsule& capsule, std::uint8_t motion);

  [[nodiscard]] const PixelRect& rect() const { return rect_; }

  /// Rows of parts that one thread keeps while it draws.
  struct Scratch {
    std::vector<Hit> above, here, below;
  };
  void draw(const LensRays& rays, const Light& light, const Textures& textures, const PictureRow& row,
            Scratch& scratch) const;

 private:
  struct Shading;

  Solid(const View& view, const Rigid& rigid, std::uint8_t motion) : local_(view, rigid), motion_(motion) {}
  [[nodiscard]] Hit meet(float ray_x, float ray_y) const;
  void meet_row(const LensRays& rays, int v, std::vector<Hit>& hits) const;

  LocalView local_;
  std::variant<Box, Frustum<float>, Torus, Sausage> shape_;
  Surface outside_, inside_;
  Eigen::Matrix3f local_from_ned_;
  PixelRect rect_;
  std::uint8_t motion_;
};

}  // namespace stevedore::world
