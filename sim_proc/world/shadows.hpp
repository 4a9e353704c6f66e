// Shadows on a plane, worked out in the plane: a thing's outline swept along the light is a capsule there.
#pragma once

#include <vector>

#include "sim_proc/world/plane_row.hpp"
#include "sim_proc/world/scene.hpp"

namespace stevedore::world {

/// Everything that shades the plane z = 0 of a rigid thing.
class Shadows {
 public:
  /// own_deck: index of the deck whose upper side the plane is; -1 for the surroundings, which decks shade
  /// too.
  Shadows(const View& view, const Scene& scene, const Rigid& plane, int own_deck);

  /// Takes from the row's sun and sky, which must be set to 1 before.
  void cast(const PlaneView& plane, PlaneRow& row) const;

 private:
  /// Tapered capsule from a to b. Shadows of spheres are ellipses: along the light's direction the plane is
  /// squeezed until they are circles. Penumbra: the distance to what casts it times the sun's angular size.
  struct Caster {
    Eigen::Vector2f a, b;
    float a_radius, b_radius, a_soft, b_soft;
    float squeeze;
    float opacity;
    PixelRect rect;
  };
  /// Convex outline: where x nx + y ny <= limit for every edge (unit normals); soft edge of one width.
  struct Edge {
    float nx, ny, limit;
  };
  struct Outline {
    std::vector<Edge> edges;
    float soft;
    PixelRect rect;
  };
  /// Where something stands the sky is partly hidden from the ground around it.
  struct Foot {
    Eigen::Vector2f at;
    float radius;
    PixelRect rect;
  };
  struct Sphere {
    Eigen::Vector3d center_ned_m;
    double radius_m;
  };

  void add_things(const Scene& scene);
  void add_swept(const Sphere& a, const Sphere& b, bool are_discs, float opacity);
  void add_box(const Deck& deck);
  void add_foot(const Eigen::Vector3d& ned_m, double radius_m);
  [[nodiscard]] Eigen::Vector2d shadow_of(const Eigen::Vector3d& local_m) const;
  [[nodiscard]] PixelRect rect_of(const Eigen::Vector2d& low, const Eigen::Vector2d& high) const;
  void cast_one(const Caster& caster, const PlaneView& plane, PlaneRow& row) const;
  static void cast_one(const Outline& outline, const PlaneView& plane, PlaneRow& row);
  static void cast_one(const Foot& foot, PlaneRow& row);

  const View& view_;
  const Rigid& plane_;
  Eigen::Vector3d to_sun_;  ///< in the plane's axes
  Eigen::Vector2f along_;   ///< the light's direction in the plane
  double sun_radius_rad_;
  std::vector<Caster> casters_;
  std::vector<Outline> outlines_;
  std::vector<Foot> feet_;
};

}  // namespace stevedore::world
