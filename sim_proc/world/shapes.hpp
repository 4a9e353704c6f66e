// Where a ray meets the shapes that a scene is made of, in each shape's own axes. In double for truth, in
// float for pictures.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

#include "sim_proc/world/scene.hpp"

namespace stevedore::world {

template <typename T>
using Vec3 = Eigen::Matrix<T, 3, 1>;

template <typename T>
struct Ray {
  Vec3<T> origin;
  Vec3<T> direction;  ///< any length; ranges are in multiples of it
};

/// Nearest crossing in front of the origin. range stays infinite where there is none.
template <typename T>
struct Meeting {
  enum class Part { none, outside, inside, floor, rim };
  T range = std::numeric_limits<T>::infinity();
  Vec3<T> normal = Vec3<T>::Zero();  ///< towards where the shape is not, any length
  Part part = Part::none;

  explicit operator bool() const { return part != Part::none; }
};

/// Box from lowest to highest corner (slabs: Kay and Kajiya 1986).
template <typename T>
Meeting<T> meet_box(const Ray<T>& ray, const Vec3<T>& lowest, const Vec3<T>& highest) {
  T enter = -std::numeric_limits<T>::infinity(), leave = std::numeric_limits<T>::infinity();
  int side = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const T inverse = 1 / ray.direction[axis];
    T near = (lowest[axis] - ray.origin[axis]) * inverse, far = (highest[axis] - ray.origin[axis]) * inverse;
    if (near > far) std::swap(near, far);
    if (near > enter) {
      enter = near;
      side = axis;
    }
    leave = std::min(leave, far);
  }
  Meeting<T> met;
  if (!(enter < leave) || !(enter > 0)) return met;
  met.range = enter;
  met.normal[side] = ray.direction[side] > 0 ? T(-1) : T(1);
  met.part = Meeting<T>::Part::outside;
  return met;
}

/// Sizes of an open bucket (see Bucket), s up from the base.
template <typename T>
struct Frustum {
  T base, rim, height, wall;
  [[nodiscard]] T widening() const { return (rim - base) / height; }
};

template <typename T>
Frustum<T> frustum_of(const Bucket& bucket) {
  return {static_cast<T>(bucket.base_radius_m), static_cast<T>(bucket.rim_radius_m),
          static_cast<T>(bucket.height_m), static_cast<T>(bucket.wall_m)};
}

/// Wall of the cone whose radius is `foot` at s = 0, both crossings; `inside` turns the normal inwards.
template <typename T>
void meet_wall(const Ray<T>& ray, const Frustum<T>& f, bool inside, Meeting<T>& met) {
  const T k = f.widening(), foot = inside ? f.base - f.wall : f.base;
  const Vec3<T>&o = ray.origin, &d = ray.direction;
  const T radius_at_origin = foot - k * o.z(), radius_slope = -k * d.z();
  const T a = d.x() * d.x() + d.y() * d.y() - radius_slope * radius_slope;
  const T b = o.x() * d.x() + o.y() * d.y() - radius_at_origin * radius_slope;
  const T c = o.x() * o.x() + o.y() * o.y() - radius_at_origin * radius_at_origin;
  const T discriminant = b * b - a * c;
  if (!(discriminant >= 0)) return;
  // the form without cancellation of both roots
  const T q = b > 0 ? -b - std::sqrt(discriminant) : -b + std::sqrt(discriminant);
  const std::array<T, 2> roots = {q / a, c / q};
  for (const T range : roots) {
    if (!(range > 0) || !(range < met.range)) continue;
    const Vec3<T> at = o + range * d;
    if (at.z() > 0 || at.z() < -f.height) continue;
    const T radius = foot - k * at.z();
    met.range = range;
    met.normal = Vec3<T>(at.x(), at.y(), radius * k) * T(inside ? -1 : 1);
    met.part = inside ? Meeting<T>::Part::inside : Meeting<T>::Part::outside;
  }
}

/// Flat ring at local z, from inner to outer radius.
template <typename T>
void meet_annulus(const Ray<T>& ray, T z, T inner, T outer, typename Meeting<T>::Part part, Meeting<T>& met) {
  const T range = (z - ray.origin.z()) / ray.direction.z();
  if (!(range > 0) || !(range < met.range)) return;
  const T x = ray.origin.x() + range * ray.direction.x(), y = ray.origin.y() + range * ray.direction.y();
  const T r2 = x * x + y * y;
  if (r2 > outer * outer || r2 < inner * inner) return;
  met.range = range;
  met.normal = Vec3<T>(0, 0, ray.direction.z() > 0 ? T(-1) : T(1));
  met.part = part;
}

/// Open bucket without its handle.
template <typename T>
Meeting<T> meet_bucket(const Ray<T>& ray, const Frustum<T>& f) {
  using Part = typename Meeting<T>::Part;
  Meeting<T> met;
  meet_wall(ray, f, false, met);
  meet_wall(ray, f, true, met);
  meet_annulus(ray, -f.height, f.rim - f.wall, f.rim, Part::rim, met);
  meet_annulus(ray, -f.wall, T(0), f.base, Part::floor, met);
  meet_annulus(ray, T(0), T(0), f.base, Part::outside, met);
  return met;
}

/// Radius of the wire that a bucket's handle is made of.
constexpr double handle_wire_m = 0.002;

/// Points along the handle's wire, half an ellipse from hinge to hinge, in the bucket's axes.
constexpr int handle_points = 17;
inline std::array<Eigen::Vector3d, handle_points> handle_of(const Bucket& bucket) {
  std::array<Eigen::Vector3d, handle_points> points;
  const Eigen::Vector3d rise =
      bucket.handle_rise_m * Eigen::Vector3d(std::sin(bucket.handle_rad), 0, -std::cos(bucket.handle_rad));
  for (int i = 0; i < handle_points; ++i) {
    const double t = std::numbers::pi * i / (handle_points - 1);
    points[static_cast<size_t>(i)] =
        Eigen::Vector3d(0, bucket.rim_radius_m * std::cos(t), -bucket.height_m) + std::sin(t) * rise;
  }
  return points;
}

/// Smaller root of a t^2 + 2 b t + c, where it is real and a > 0.
template <typename T>
std::optional<T> smaller_root(T a, T b, T c) {
  const T discriminant = b * b - a * c;
  if (!(discriminant >= 0) || !(a > 0)) return std::nullopt;
  return (-b - std::sqrt(discriminant)) / a;
}

/// Sphere-swept segment.
template <typename T>
Meeting<T> meet_capsule(const Ray<T>& ray, const Vec3<T>& from, const Vec3<T>& to, T radius) {
  Meeting<T> met;
  const Vec3<T> axis = to - from, &d = ray.direction, o = ray.origin - from;
  const T axis2 = axis.squaredNorm(), d2 = d.squaredNorm(), od = o.dot(d), o2 = o.squaredNorm();
  const auto offer = [&](T range, const Vec3<T>& normal) {
    if (!(range > 0) || !(range < met.range)) return;
    met.range = range;
    met.normal = normal;
    met.part = Meeting<T>::Part::outside;
  };
  if (axis2 > 0) {
    const T da = d.dot(axis), oa = o.dot(axis), inverse = 1 / axis2;
    const T a = d2 - da * da * inverse, b = od - oa * da * inverse;
    const T c = o2 - oa * oa * inverse - radius * radius;
    if (b * b < a * c) return met;  // it misses the endless cylinder, which holds both ends
    if (const auto range = smaller_root(a, b, c)) {
      const Vec3<T> at = o + *range * d;
      const T along = at.dot(axis);
      if (along >= 0 && along <= axis2) offer(*range, at - axis * (along * inverse));
    }
  }
  for (const Vec3<T>& end : {Vec3<T>(Vec3<T>::Zero()), axis}) {
    const Vec3<T> p = o - end;
    if (const auto range = smaller_root(d2, p.dot(d), p.squaredNorm() - radius * radius))
      offer(*range, p + *range * d);
  }
  return met;
}

/// Torus about local z whose tube of radius `tube` rests on z = 0; `outer`: its outer radius. By sphere
/// tracing (Hart 1996), to a hundredth of a millimetre.
template <typename T>
Meeting<T> meet_torus(const Ray<T>& ray, T outer, T tube) {
  Meeting<T> met;
  const T length = ray.direction.norm();
  const Vec3<T> d = ray.direction / length, o = ray.origin + Vec3<T>(0, 0, tube);
  const T middle = -o.dot(d), miss2 = o.squaredNorm() - middle * middle;
  if (miss2 > outer * outer || middle < 0) return met;
  const T half_chord = std::sqrt(outer * outer - miss2), ring = outer - tube;
  constexpr int most_steps = 96;  // grazing rays need tens; those that need more miss by less than a pixel
  T range = std::max(T(0), middle - half_chord);
  for (int i = 0; i < most_steps && range < middle + half_chord; ++i) {
    const Vec3<T> at = o + range * d;
    const T radial = std::sqrt(at.x() * at.x() + at.y() * at.y()), off = radial - ring;
    const T distance = std::sqrt(off * off + at.z() * at.z()) - tube;
    if (distance < T(1e-5)) {
      met.range = range / length;
      const T pull = 1 - ring / std::max(radial, T(1e-6));
      met.normal = Vec3<T>(at.x() * pull, at.y() * pull, at.z());
      met.part = Meeting<T>::Part::outside;
      return met;
    }
    range += distance;
  }
  return met;
}

}  // namespace stevedore::world
