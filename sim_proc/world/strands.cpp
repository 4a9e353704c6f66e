#include "sim_proc/world/strands.hpp"

#include <cmath>

namespace stevedore::world {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3d;

constexpr double least_depth_m = 0.05;  // nearer than this to the camera's plane nothing is drawn

/// The part of the segment that is before the camera; false if there is none.
bool clip(Vector3d& from, Vector3d& to) {
  if (from.z() < least_depth_m && to.z() < least_depth_m) return false;
  const auto at_least_depth = [&] {
    return Vector3d(from + (to - from) * ((least_depth_m - from.z()) / (to.z() - from.z())));
  };
  if (from.z() < least_depth_m) from = at_least_depth();
  if (to.z() < least_depth_m) to = at_least_depth();
  return true;
}

void widen(PixelRect& rect, const PixelRect& other) {
  if (rect.empty()) {
    rect = other;
    return;
  }
  rect = {std::min(rect.left, other.left), std::min(rect.top, other.top), std::max(rect.right, other.right),
          std::max(rect.bottom, other.bottom)};
}

}  // namespace

SeenStrand::SeenStrand(const View& view, const Strand& strand, std::uint8_t motion)
    : surface_(strand.surface), motion_(motion) {
  for (size_t i = 1; i < strand.points_ned_m.size(); ++i) {
    Vector3d from = view.to_camera(strand.points_ned_m[i - 1]), to = view.to_camera(strand.points_ned_m[i]);
    if (!clip(from, to)) continue;
    // straight in the world is bent in the image: pieces short enough for the bend to vanish
    constexpr double straight_px = 24;
    const double length_px = (view.pixel_of(to) - view.pixel_of(from)).norm();
    const int pieces = std::clamp(static_cast<int>(std::ceil(length_px / straight_px)), 1, 64);
    for (int k = 0; k < pieces; ++k)
      add(view, from + (to - from) * (static_cast<double>(k) / pieces),
          from + (to - from) * (static_cast<double>(k + 1) / pieces), strand.radius_m);
  }
}

void SeenStrand::add(const View& view, const Vector3d& from_camera_m, const Vector3d& to_camera_m,
                     double radius_m) {
  Piece piece;
  piece.from = view.pixel_of(from_camera_m).cast<float>();
  piece.to = view.pixel_of(to_camera_m).cast<float>();
  const double px = 1 / static_cast<double>(view.rays.pixel_rad);
  piece.from_depth_m = static_cast<float>(from_camera_m.z());
  piece.to_depth_m = static_cast<float>(to_camera_m.z());
  piece.from_radius_px = static_cast<float>(radius_m * px / from_camera_m.z());
  piece.to_radius_px = static_cast<float>(radius_m * px / to_camera_m.z());
  const float reach = std::max(piece.from_radius_px, piece.to_radius_px) + 1;
  const Vector2f low = piece.from.cwiseMin(piece.to).array() - reach,
                 high = piece.from.cwiseMax(piece.to).array() + reach + 1;
  const auto column = [&](float u) {
    return static_cast<int>(std::clamp(u, 0.0F, static_cast<float>(view.rays.width_px)));
  };
  const auto line = [&](float v) {
    return static_cast<int>(std::clamp(v, 0.0F, static_cast<float>(view.rays.height_px)));
  };
  piece.rect = {column(low.x()), line(low.y()), column(high.x()), line(high.y())};
  if (piece.rect.empty()) return;
  pieces_.push_back(piece);
  widen(rect_, piece.rect);
}

void SeenStrand::cover(const Piece& piece, const PictureRow& row, std::vector<float>& shares) const {
  const Vector2f axis = piece.to - piece.from;
  const float per_length2 = 1 / std::max(axis.squaredNorm(), 1e-6F);
  for (int u = piece.rect.left; u < piece.rect.right; ++u) {
    const Vector2f p = Vector2f(static_cast<float>(u), static_cast<float>(row.v)) - piece.from;
    const float h = std::clamp(p.dot(axis) * per_length2, 0.0F, 1.0F), distance = (p - h * axis).norm();
    const float radius = std::lerp(piece.from_radius_px, piece.to_radius_px, h);
    if (distance > radius + 0.5F) continue;
    const float depth = std::lerp(piece.from_depth_m, piece.to_depth_m, h);
    constexpr float touching_m = 0.003F;  // it lies on things
    if (depth > row.depth_m[u] + touching_m) continue;
    // between the line's two edges
    const float share = coverage_at(radius - distance) - coverage_at(-radius - distance);
    float& most = shares[static_cast<size_t>(u)];
    most = std::max(most, share);
  }
}

void SeenStrand::draw(const Light& light, int first, int last, Picture& picture,
                      std::vector<float>& shares) const {
  for (int v = std::max(first, rect_.top); v < std::min(last, rect_.bottom); ++v)
    draw_row(light, PictureRow(picture, v), shares);
}

void SeenStrand::draw_row(const Light& light, const PictureRow& row, std::vector<float>& shares) const {
  for (const Piece& piece : pieces_)
    if (piece.rect.has_row(row.v)) cover(piece, row, shares);
  constexpr float sunny_side = 0.5F;  // mean cosine of a round thing's lit half, seen from where it may be
  const Eigen::Vector3f colour = surface_.colour.cwiseProduct(light.sun * sunny_side + light.sky * 0.8F);
  for (int u = rect_.left; u < rect_.right; ++u) {
    float& share = shares[static_cast<size_t>(u)];
    if (share > 0) row.lay(u, colour, share, row.depth_m[u], motion_);
    share = 0;
  }
}

}  // namespace stevedore::world
