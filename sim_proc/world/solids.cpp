#include "sim_proc/world/solids.hpp"

#include <cmath>
#include <numbers>

#include "sim_proc/world/surface.hpp"

namespace stevedore::world {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;
using Hit = Solid::Hit;
using Part = Hit::Part;

constexpr double soft_edge_px = 2;

std::vector<Vector3d> rim(const Rigid& rigid, double radius_m, double z_m) {
  std::vector<Vector3d> points;
  constexpr int corners = 12;
  const double polygon_m = radius_m / std::cos(std::numbers::pi / corners);  // encloses the circle
  for (int i = 0; i < corners; ++i) {
    const double angle = 2 * std::numbers::pi * i / corners;
    points.push_back(rigid.to_ned({polygon_m * std::cos(angle), polygon_m * std::sin(angle), z_m}));
  }
  return points;
}

void append(std::vector<Vector3d>& points, const std::vector<Vector3d>& more) {
  points.insert(points.end(), more.begin(), more.end());
}

/// Sixteen places in a pixel, no two in the same row or column of a grid of 16 x 16: an upright or level edge
/// is resolved to a sixteenth of a pixel.
constexpr int rays_per_pixel = 16;
struct Offset {
  float u, v;
};
Offset offset_of(int ray) {
  constexpr std::array<int, rays_per_pixel> rows = {2, 9, 5, 14, 0, 11, 7, 12, 4, 15, 1, 8, 13, 6, 10, 3};
  return {(static_cast<float>(ray) + 0.5F) / rays_per_pixel - 0.5F,
          (static_cast<float>(rows[static_cast<size_t>(ray)]) + 0.5F) / rays_per_pixel - 0.5F};
}

/// Whether it is not hidden by what is drawn already.
bool is_before(const Hit& hit, float drawn_depth_m) {
  constexpr float touching = 1.0005F, touching_m = 0.002F;  // things stand on decks, not in them
  return hit && hit.range <= drawn_depth_m * touching + touching_m;
}

Rigid at_ned(const Vector3d& position_ned_m) {
  Rigid rigid;
  rigid.position_ned_m = position_ned_m;
  return rigid;
}

}  // namespace

Solid Solid::of(const View& view, const Deck& deck, std::uint8_t motion) {
  Solid solid(view, deck.rigid, motion);
  const double x = deck.half_size_m.x(), y = deck.half_size_m.y(), z = deck.thickness_m;
  solid.shape_ = Box{Vector3d(-x, -y, 0).cast<float>(), Vector3d(x, y, z).cast<float>()};
  solid.outside_ = solid.inside_ = deck.ground;
  solid.outside_.colour *= 0.7F;  // sides are dirtier than what is walked on
  std::vector<Vector3d> corners;
  for (const double sx : {-x, x})
    for (const double sy : {-y, y})
      for (const double sz : {0.0, z}) corners.push_back(deck.rigid.to_ned({sx, sy, sz}));
  solid.rect_ = view.bounds_of(corners, soft_edge_px);
  solid.local_from_ned_ = deck.rigid.ned_from_local.conjugate().toRotationMatrix().cast<float>();
  return solid;
}

Solid Solid::of(const View& view, const Bucket& bucket, std::uint8_t motion) {
  Solid solid(view, bucket.rigid, motion);
  solid.shape_ = frustum_of<float>(bucket);
  solid.outside_ = bucket.outside;
  solid.inside_ = bucket.inside;
  auto points = rim(bucket.rigid, bucket.base_radius_m, 0);
  append(points, rim(bucket.rigid, bucket.rim_radius_m, -bucket.height_m));
  solid.rect_ = view.bounds_of(points, soft_edge_px);
  solid.local_from_ned_ = bucket.rigid.ned_from_local.conjugate().toRotationMatrix().cast<float>();
  return solid;
}

Solid Solid::of(const View& view, const Tyre& tyre, std::uint8_t motion) {
  Solid solid(view, tyre.rigid, motion);
  solid.shape_ = Torus{static_cast<float>(tyre.radius_m), static_cast<float>(tyre.tube_m)};
  solid.outside_ = solid.inside_ = tyre.rubber;
  auto points = rim(tyre.rigid, tyre.radius_m, 0);
  append(points, rim(tyre.rigid, tyre.radius_m, -2 * tyre.tube_m));
  solid.rect_ = view.bounds_of(points, soft_edge_px);
  solid.local_from_ned_ = tyre.rigid.ned_from_local.conjugate().toRotationMatrix().cast<float>();
  return solid;
}

Solid Solid::of(const View& view, const Capsule& capsule, std::uint8_t motion) {
  Solid solid(view, at_ned(capsule.from_ned_m), motion);
  solid.shape_ = Sausage{Vector3f::Zero(), (capsule.to_ned_m - capsule.from_ned_m).cast<float>(),
                         static_cast<float>(capsule.radius_m)};
  solid.outside_ = solid.inside_ = capsule.surface;
  std::vector<Vector3d> corners;
  for (const Vector3d& end : {capsule.from_ned_m, capsule.to_ned_m})
    for (const double x : {-1.0, 1.0})
      for (const double y : {-1.0, 1.0})
        for (const double z : {-1.0, 1.0}) corners.push_back(end + capsule.radius_m * Vector3d(x, y, z));
  solid.rect_ = view.bounds_of(corners, soft_edge_px);
  solid.local_from_ned_ = Eigen::Matrix3f::Identity();
  return solid;
}

/// The upper side, seen from above: nearer than all else, and what most rays meet.
std::optional<Hit> Solid::meet_top(const Ray<float>& ray, const Box& box) {
  if (ray.origin.z() >= 0) return std::nullopt;
  const float range = -ray.origin.z() / ray.direction.z();
  const Vector3f at = ray.origin + range * ray.direction;
  if (!(range > 0) || std::abs(at.x()) > box.highest.x() || std::abs(at.y()) > box.highest.y())
    return std::nullopt;
  Hit hit;
  hit.range = range;
  hit.normal = {0, 0, -1};
  hit.part = Part::floor;
  return hit;
}

Hit Solid::meet(float ray_x, float ray_y) const {
  const Ray<float> ray{local_.eye, local_.local_from_camera * Vector3f(ray_x, ray_y, 1)};
  if (const auto* frustum = std::get_if<Frustum<float>>(&shape_)) return meet_bucket(ray, *frustum);
  if (const auto* torus = std::get_if<Torus>(&shape_)) return meet_torus(ray, torus->outer, torus->tube);
  if (const auto* sausage = std::get_if<Sausage>(&shape_))
    return meet_capsule(ray, sausage->from, sausage->to, sausage->radius);
  const Box& box = std::get<Box>(shape_);
  if (const auto top = meet_top(ray, box)) return *top;
  Hit hit = meet_box(ray, box.lowest, box.highest);
  if (hit && hit.normal.z() != 0) hit.part = Part::floor;  // the upper side, which is drawn with its paint
  return hit;
}

void Solid::meet_row(const LensRays& rays, int v, std::vector<Hit>& hits) const {
  hits.resize(static_cast<size_t>(rays.width_px));
  const bool inside = rect_.has_row(v) && v >= 0 && v < rays.height_px;
  for (int u = rect_.left; u < rect_.right; ++u)
    hits[static_cast<size_t>(u)] = inside ? meet(rays.row_x(v)[u], rays.row_y(v)[u]) : Hit{};
}

/// Light from a place on the solid to the eye.
struct Solid::Shading {
  const Solid& solid;
  const Light& light;
  Vector3f to_sun;
  SurfaceSampler outside, inside;

  Shading(const Solid& of_solid, const Light& of_light, const Textures& textures, float pixel_m)
      : solid(of_solid),
        light(of_light),
        to_sun(of_solid.local_from_ned_ * of_light.to_sun_ned.cast<float>()),
        outside(of_solid.outside_, textures),
        inside(of_solid.inside_, textures) {
    outside.focus(pixel_m);
    inside.focus(pixel_m);
  }

  /// Inside a bucket the sun comes through its opening only.
  [[nodiscard]] bool sunlit(const Hit& hit, const Vector3f& at) const {
    const auto* frustum = std::get_if<Frustum<float>>(&solid.shape_);
    const bool is_inside = hit.part == Part::inside || hit.part == Part::floor;
    if (!frustum || !is_inside) return true;
    if (to_sun.z() > -1e-3F) return false;
    const float up = (at.z() + frustum->height) / -to_sun.z();
    const float x = at.x() + up * to_sun.x(), y = at.y() + up * to_sun.y(), r = frustum->rim - frustum->wall;
    return x * x + y * y < r * r;
  }

  /// Share of the sky that a place sees: the hemisphere above its surface, or what a bucket's opening leaves.
  [[nodiscard]] float open_sky(const Hit& hit, const Vector3f& at, const Vector3f& normal) const {
    const auto* frustum = std::get_if<Frustum<float>>(&solid.shape_);
    if (frustum && (hit.part == Part::inside || hit.part == Part::floor)) {
      const float depth = (at.z() + frustum->height) / frustum->rim;
      return 1 / (1 + 0.8F * depth * depth);  // form factor of a disc on its axis (Lambert), halved beside it
    }
    const float up = -(solid.local_from_ned_.transpose() * normal).z();
    return 0.5F + 0.5F * up;
  }

  [[nodiscard]] Vector3f at(const Hit& hit, const Vector3f& ray) const {
    const Vector3f place = solid.local_.eye + hit.range * ray, normal = hit.normal.normalized();
    const bool is_inside = hit.part == Part::inside || hit.part == Part::floor;
    const Surface& surface = is_inside ? solid.inside_ : solid.outside_;
    const SurfaceSampler& sampler = is_inside ? inside : outside;
    const float tone = sampler.tone(place.x() + 0.7F * place.z(), place.y() - 0.4F * place.z());
    const float sun_cosine = sunlit(hit, place) ? std::max(0.0F, normal.dot(to_sun)) : 0.0F;
    constexpr float from_below = 0.15F;  // what the ground throws back
    const float sky = std::lerp(from_below, 1.0F, open_sky(hit, place, normal));
    Vector3f out = (surface.colour * tone).cwiseProduct(light.sun * sun_cosine + light.sky * sky);
    if (surface.gloss > 0 && sun_cosine > 0) {
      const float middle = std::max(0.0F, normal.dot((to_sun - ray.normalized()).normalized()));
      out += light.sun * (surface.gloss * std::pow(middle, 40.0F));  // Blinn (1977)
    }
    return out;
  }
};

bool Solid::is_inside_part(int u, const Scratch& scratch) const {
  const auto i = static_cast<size_t>(u);
  const Part part = scratch.here[i].part;
  return (u == rect_.left || scratch.here[i - 1].part == part) &&
         (u + 1 == rect_.right || scratch.here[i + 1].part == part) && scratch.above[i].part == part &&
         scratch.below[i].part == part;
}

/// A deck's upper side is drawn with its paint, by DeckLayer.
bool Solid::is_upper_side(const Hit& hit) const {
  return hit.part == Part::floor && std::holds_alternative<Box>(shape_);
}

void Solid::draw_edge(const LensRays& rays, const Shading& shading, const PictureRow& row, int u) const {
  const RaySlopes slope = rays.slopes(u, row.v);
  const float middle_x = rays.row_x(row.v)[u], middle_y = rays.row_y(row.v)[u];
  Vector3f sum = Vector3f::Zero();
  int met = 0, under_top = 0;
  float depth = 0;
  for (int k = 0; k < rays_per_pixel; ++k) {
    const Offset offset = offset_of(k);
    const float x = middle_x + slope.xu * offset.u + slope.xv * offset.v;
    const float y = middle_y + slope.yu * offset.u + slope.yv * offset.v;
    const Hit hit = meet(x, y);
    if (!is_before(hit, row.depth_m[u])) continue;
    if (is_upper_side(hit)) {
      ++under_top;
      continue;
    }
    sum += shading.at(hit, local_.local_from_camera * Vector3f(x, y, 1));
    depth += hit.range;
    ++met;
  }
  if (met == 0) return;
  // a deck's side goes on under its upper side, which is laid over it with its own edge
  const float share = static_cast<float>(met + under_top) / rays_per_pixel;
  row.lay(u, sum / static_cast<float>(met), share, depth / static_cast<float>(met), motion_);
}

void Solid::draw_row(const LensRays& rays, const Shading& shading, const PictureRow& row,
                     const Scratch& scratch) const {
  const float *ray_x = rays.row_x(row.v), *ray_y = rays.row_y(row.v);
  for (int u = rect_.left; u < rect_.right; ++u) {
    const Hit& hit = scratch.here[static_cast<size_t>(u)];
    if (!is_inside_part(u, scratch)) {
      draw_edge(rays, shading, row, u);
    } else if (is_before(hit, row.depth_m[u]) && !is_upper_side(hit)) {
      const Vector3f ray = local_.local_from_camera * Vector3f(ray_x[u], ray_y[u], 1);
      row.lay(u, shading.at(hit, ray), 1, hit.range, motion_);
    }
  }
}

void Solid::draw(const LensRays& rays, const Light& light, const Textures& textures, int first, int last,
                 Picture& picture, Scratch& scratch) const {
  first = std::max(first, rect_.top);
  last = std::min(last, rect_.bottom);
  if (first >= last) return;
  const Shading shading(*this, light, textures, rays.pixel_rad * local_.eye.norm());
  meet_row(rays, first - 1, scratch.above);
  meet_row(rays, first, scratch.here);
  for (int v = first; v < last; ++v) {
    meet_row(rays, v + 1, scratch.below);
    draw_row(rays, shading, PictureRow(picture, v), scratch);
    std::swap(scratch.above, scratch.here);
    std::swap(scratch.here, scratch.below);
  }
}

}  // namespace stevedore::world
