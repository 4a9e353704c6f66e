// Things with a body: buckets, tyres, people, the sides of decks. Ray cast where they may be; their
// silhouettes, and the edges between their parts, by sixteen rays a pixel.
#pragma once

#include <optional>
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

  /// What three rows of pixels meet; one thread's memory.
  struct Scratch {
    std::vector<Hit> above, here, below;
  };
  /// Rows first..last-1.
  void draw(const LensRays& rays, const Light& light, const Textures& textures, int first, int last,
            Picture& picture, Scratch& scratch) const;

 private:
  struct Shading;

  Solid(const View& view, const Rigid& rigid, std::uint8_t motion) : local_(view, rigid), motion_(motion) {}
  static std::optional<Hit> meet_top(const Ray<float>& ray, const Box& box);
  [[nodiscard]] Hit meet(float ray_x, float ray_y) const;
  void meet_row(const LensRays& rays, int v, std::vector<Hit>& hits) const;
  /// Whether all four neighbours of the pixel meet the same part as it does.
  [[nodiscard]] bool is_inside_part(int u, const Scratch& scratch) const;
  [[nodiscard]] bool is_upper_side(const Hit& hit) const;
  void draw_row(const LensRays& rays, const Shading& shading, const PictureRow& row,
                const Scratch& scratch) const;
  void draw_edge(const LensRays& rays, const Shading& shading, const PictureRow& row, int u) const;

  LocalView local_;
  std::variant<Box, Frustum<float>, Torus, Sausage> shape_;
  Surface outside_, inside_;
  Eigen::Matrix3f local_from_ned_;
  PixelRect rect_;
  std::uint8_t motion_;
};

}  // namespace stevedore::world
