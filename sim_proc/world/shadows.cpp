#include "sim_proc/world/shadows.hpp"

#include <cmath>
#include <opencv2/imgproc.hpp>

namespace stevedore::world {
namespace {

using Eigen::Vector2d;
using Eigen::Vector2f;
using Eigen::Vector3d;

/// Sine of the lowest sun that still throws shadows: at 2 degrees they are 28 times as long as things are
/// high, and what little light there is comes from the sky.
constexpr double lowest_sun = 0.035;

/// How far from a foot the sky's light is back.
constexpr double foot_reach_m = 0.35;

template <typename Shape, typename Shade>
void over_pixels(const Shape& shape, PlaneRow& row, const Shade& shade) {
  if (!shape.rect.has_row(row.v)) return;
  const int last = std::min(shape.rect.right, row.last);
  for (int u = std::max(shape.rect.left, row.first); u < last; ++u) shade(static_cast<size_t>(u));
}

/// Share of the sun that is hidden at that distance from the edge of a shadow (negative: inside).
float hidden_share(float distance, float soft) {
  return std::clamp(0.5F - distance / (2 * soft), 0.0F, 1.0F);
}

}  // namespace

Shadows::Shadows(const View& view, const Scene& scene, const Rigid& plane, int own_deck)
    : view_(view),
      plane_(plane),
      to_sun_(plane.ned_from_local.conjugate() * scene.light.to_sun_ned),
      along_(to_sun_.head<2>().normalized().cast<float>()),
      sun_radius_rad_(scene.light.sun_radius_rad) {
  if (!(to_sun_.head<2>().norm() > 1e-9)) along_ = {1, 0};
  const bool sunny = scene.light.sun.maxCoeff() > 0 && -to_sun_.z() > lowest_sun;
  for (const Bucket& bucket : scene.buckets) add_foot(bucket.rigid.position_ned_m, bucket.base_radius_m);
  for (const Tyre& tyre : scene.tyres) add_foot(tyre.rigid.position_ned_m, tyre.radius_m - 0.05);
  for (const Capsule& capsule : scene.capsules) add_foot(capsule.from_ned_m, capsule.radius_m);
  if (!sunny) return;
  add_things(scene);
  if (own_deck < 0)
    for (const Deck& deck : scene.decks) add_box(deck);
}

void Shadows::add_things(const Scene& scene) {
  for (const Bucket& bucket : scene.buckets)
    add_swept({bucket.rigid.position_ned_m, bucket.base_radius_m},
              {bucket.rigid.to_ned({0, 0, -bucket.height_m}), bucket.rim_radius_m}, true, 1);
  for (const Tyre& tyre : scene.tyres)
    add_swept({tyre.rigid.to_ned({0, 0, -tyre.tube_m / 2}), tyre.radius_m - tyre.tube_m / 4},
              {tyre.rigid.to_ned({0, 0, -1.5 * tyre.tube_m}), tyre.radius_m - tyre.tube_m / 4}, true, 1);
  for (const Capsule& capsule : scene.capsules)
    add_swept({capsule.from_ned_m, capsule.radius_m}, {capsule.to_ned_m, capsule.radius_m}, false, 1);
  const AircraftShadow& aircraft = scene.aircraft;
  const double half_m = aircraft.length_m / 2;
  constexpr double mast_m = 0.3, fuselage_m = 0.15, tail_m = 0.04;
  add_swept({aircraft.body.to_ned({0.35 * half_m, 0, 0}), fuselage_m},
            {aircraft.body.to_ned({-0.2 * half_m, 0, 0}), fuselage_m}, false, 1);
  add_swept({aircraft.body.to_ned({-0.2 * half_m, 0, -0.1}), tail_m},
            {aircraft.body.to_ned({-1.4 * half_m, 0, -0.1}), tail_m}, false, 1);
  const Vector3d hub = aircraft.body.to_ned({0, 0, -mast_m});
  add_swept({hub, aircraft.rotor_radius_m}, {hub, aircraft.rotor_radius_m}, true, aircraft.rotor_cover);
}

Vector2d Shadows::shadow_of(const Vector3d& local_m) const {
  return local_m.head<2>() - to_sun_.head<2>() * (local_m.z() / to_sun_.z());
}

PixelRect Shadows::rect_of(const Vector2d& low, const Vector2d& high) const {
  std::vector<Vector3d> corners;
  for (const double x : {low.x(), high.x()})
    for (const double y : {low.y(), high.y()}) corners.push_back(plane_.to_ned({x, y, 0}));
  return view_.bounds_of(corners, 2);
}

void Shadows::add_swept(const Sphere& a, const Sphere& b, bool are_discs, float opacity) {
  const Vector3d a_local = plane_.to_local(a.center_ned_m), b_local = plane_.to_local(b.center_ned_m);
  constexpr double under_m = 0.05;  // what lies under the plane does not shade it
  if (a_local.z() > under_m && b_local.z() > under_m) return;
  const double sine = -to_sun_.z();
  const auto soft = [&](const Vector3d& local) {
    return std::max(1e-3, std::abs(local.z()) / sine * sun_radius_rad_);
  };
  const Vector2d a_at = shadow_of(a_local), b_at = shadow_of(b_local);
  const double reach =
      std::max(a.radius_m, b.radius_m) / (are_discs ? 1 : sine) + (soft(a_local) + soft(b_local)) / sine;
  const PixelRect rect = rect_of(a_at.cwiseMin(b_at).array() - reach, a_at.cwiseMax(b_at).array() + reach);
  if (rect.empty()) return;
  casters_.push_back({a_at.cast<float>(), b_at.cast<float>(), static_cast<float>(a.radius_m),
                      static_cast<float>(b.radius_m), static_cast<float>(soft(a_local)),
                      static_cast<float>(soft(b_local)), are_discs ? 1.0F : static_cast<float>(sine), opacity,
                      rect});
}

void Shadows::add_box(const Deck& deck) {
  std::vector<cv::Point2f> points;
  double highest = 0;
  for (const double x : {-deck.half_size_m.x(), deck.half_size_m.x()})
    for (const double y : {-deck.half_size_m.y(), deck.half_size_m.y()})
      for (const double z : {0.0, deck.thickness_m}) {
        Vector3d local = plane_.to_local(deck.rigid.to_ned({x, y, z}));
        local.z() = std::min(local.z(), 0.0);  // what is under the plane shades where it comes out
        highest = std::max(highest, -local.z());
        const Vector2d at = shadow_of(local);
        points.emplace_back(static_cast<float>(at.x()), static_cast<float>(at.y()));
      }
  std::vector<cv::Point2f> hull;
  cv::convexHull(points, hull, false);
  if (hull.size() < 3 || cv::contourArea(hull) < 1e-3) return;
  Outline outline;
  outline.soft = static_cast<float>(std::max(1e-3, highest / -to_sun_.z() * sun_radius_rad_));
  Vector2d low(1e9, 1e9), high(-1e9, -1e9);
  Vector2d from(hull.back().x, hull.back().y);
  for (const cv::Point2f& corner : hull) {  // in order with the inside on the left
    const Vector2d to(corner.x, corner.y),
        normal = Vector2d(to.y() - from.y(), from.x() - to.x()).normalized();
    outline.edges.push_back({static_cast<float>(normal.x()), static_cast<float>(normal.y()),
                             static_cast<float>(normal.dot(from))});
    low = low.cwiseMin(to);
    high = high.cwiseMax(to);
    from = to;
  }
  const double soft = static_cast<double>(outline.soft);
  outline.rect = rect_of(low.array() - soft, high.array() + soft);
  if (!outline.rect.empty()) outlines_.push_back(outline);
}

void Shadows::add_foot(const Vector3d& ned_m, double radius_m) {
  const Vector3d local = plane_.to_local(ned_m);
  const double near_m = 0.05 + radius_m;  // a capsule's end is its radius over what it stands on
  if (local.z() < -near_m || local.z() > near_m) return;
  const double reach = radius_m + foot_reach_m;
  const Vector2d at = local.head<2>();
  const PixelRect rect = rect_of(at.array() - reach, at.array() + reach);
  if (!rect.empty()) feet_.push_back({at.cast<float>(), static_cast<float>(radius_m), rect});
}

void Shadows::cast(const PlaneView& plane, PlaneRow& row) const {
  for (const Caster& caster : casters_) cast_one(caster, plane, row);
  for (const Outline& outline : outlines_) cast_one(outline, plane, row);
  for (const Foot& foot : feet_) cast_one(foot, row);
}

void Shadows::cast_one(const Caster& caster, const PlaneView& plane, PlaneRow& row) const {
  const auto squeezed = [&](const Vector2f& p) -> Vector2f {
    return p - along_ * (p.dot(along_) * (1 - caster.squeeze));
  };
  const Vector2f axis = squeezed(caster.b - caster.a);
  const float per_length2 = 1 / std::max(axis.squaredNorm(), 1e-12F);
  over_pixels(caster, row, [&](size_t u) {
    const Vector2f p = squeezed(Vector2f(row.x_m[u], row.y_m[u]) - caster.a);
    const float h = std::clamp(p.dot(axis) * per_length2, 0.0F, 1.0F);
    const float distance = (p - h * axis).norm() - std::lerp(caster.a_radius, caster.b_radius, h);
    const float soft = std::lerp(caster.a_soft, caster.b_soft, h) + plane.pixel_m(row.depth_m[u]) / 2;
    row.sun[u] *= 1 - caster.opacity * hidden_share(distance, soft);
  });
}

void Shadows::cast_one(const Outline& outline, const PlaneView& plane, PlaneRow& row) {
  over_pixels(outline, row, [&](size_t u) {
    float distance = -1e9F;
    for (const Edge& edge : outline.edges)
      distance = std::max(distance, row.x_m[u] * edge.nx + row.y_m[u] * edge.ny - edge.limit);
    row.sun[u] *= 1 - hidden_share(distance, outline.soft + plane.pixel_m(row.depth_m[u]) / 2);
  });
}

void Shadows::cast_one(const Foot& foot, PlaneRow& row) {
  constexpr float most = 0.5F;           // a wall hides half of the sky from its foot
  constexpr float half_reach_m = 0.08F;  // a hidden share of a quarter this far from a bucket's wall
  constexpr auto reach = static_cast<float>(foot_reach_m);
  over_pixels(foot, row, [&](size_t u) {
    const float distance = std::max(0.0F, (Vector2f(row.x_m[u], row.y_m[u]) - foot.at).norm() - foot.radius);
    if (distance >= reach) return;
    const float relative = distance / half_reach_m, fade = 1 - distance / reach;
    row.sky[u] *= 1 - most * fade / (1 + relative * relative);
  });
}

}  // namespace stevedore::world
