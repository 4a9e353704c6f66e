// What the parts of the renderer share: the eye's geometry, and the picture that they draw into.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "sim_proc/world/lens_rays.hpp"
#include "sim_proc/world/scene.hpp"

namespace stevedore::world {

/// Pixels left..right-1, top..bottom-1.
struct PixelRect {
  int left = 0, top = 0, right = 0, bottom = 0;

  [[nodiscard]] bool empty() const { return left >= right || top >= bottom; }
  [[nodiscard]] bool has_row(int v) const { return v >= top && v < bottom; }
};

/// The eye of one scene.
struct View {
  const LensRays& rays;
  const CameraModel& lens;
  Eigen::Vector3d position_ned_m;
  Eigen::Matrix3d camera_from_ned;

  View(const Eye& eye, const LensRays& rays_of_lens)
      : rays(rays_of_lens),
        lens(eye.lens),
        position_ned_m(eye.rigid.position_ned_m),
        camera_from_ned(eye.rigid.ned_from_local.conjugate().toRotationMatrix()) {}

  [[nodiscard]] Eigen::Vector3d to_camera(const Eigen::Vector3d& ned_m) const {
    return camera_from_ned * (ned_m - position_ned_m);
  }
  /// Pixel of the image as given, of a point with z > 0. Points outside of what the lens sees land outside of
  /// the image in the same direction, not where the lens polynomial would fold them.
  [[nodiscard]] Eigen::Vector2d pixel_of(const Eigen::Vector3d& point_camera_m) const;
  /// Of the part of the image that the hull of the points reaches, as far as it is before the camera, widened
  /// by the margin.
  [[nodiscard]] PixelRect bounds_of(const std::vector<Eigen::Vector3d>& points_ned_m, double margin_px) const;
};

/// Axes of a thing as rays need them: a pixel's ray in the thing's axes is eye + t local_from_camera (x, y,
/// 1), and t is its depth along the optical axis.
struct LocalView {
  Eigen::Matrix3f local_from_camera;
  Eigen::Vector3f eye;

  LocalView(const View& view, const Rigid& rigid)
      : local_from_camera(
            (rigid.ned_from_local.conjugate().toRotationMatrix() * view.camera_from_ned.transpose())
                .cast<float>()),
        eye(rigid.to_local(view.position_ned_m).cast<float>()) {}
};

/// Linear light of every pixel, how deep it is, and with what it moves.
struct Picture {
  int width = 0, height = 0;
  std::vector<float> red, green, blue;
  std::vector<float> depth_m;        ///< along the optical axis
  std::vector<std::uint8_t> motion;  ///< index into the list of motions

  void resize(int new_width, int new_height) {
    width = new_width;
    height = new_height;
    const auto pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
    for (auto* plane : {&red, &green, &blue, &depth_m}) plane->resize(pixels);
    motion.resize(pixels);
  }
};

/// One row of a picture.
struct PictureRow {
  int v;
  float *red, *green, *blue, *depth_m;
  std::uint8_t* motion;

  PictureRow(Picture& picture, int row) : v(row) {
    const auto start = static_cast<std::ptrdiff_t>(row) * picture.width;
    red = picture.red.data() + start;
    green = picture.green.data() + start;
    blue = picture.blue.data() + start;
    depth_m = picture.depth_m.data() + start;
    motion = picture.motion.data() + start;
  }

  /// Lays light over what is there, with its share of the pixel.
  void lay(int u, const Eigen::Vector3f& light, float share, float depth, std::uint8_t with_motion) const {
    red[u] += share * (light[0] - red[u]);
    green[u] += share * (light[1] - green[u]);
    blue[u] += share * (light[2] - blue[u]);
    if (share < 0.5F) return;
    depth_m[u] = depth;
    motion[u] = with_motion;
  }
};

/// Share of a pixel that lies on the positive side of an edge at that signed distance, edge and pixel side
/// parallel, or the pixel taken as round.
inline float coverage_at(float distance_px) {
  return std::clamp(0.5F + distance_px, 0.0F, 1.0F);
}

/// The exact area of the pixel's square on the positive side of a straight edge. value: signed distance of
/// its centre in any unit; (gu, gv): how that changes from pixel to pixel to the right and down.
inline float coverage_of(float value, float gu, float gv) {
  const float u = std::abs(gu), v = std::abs(gv), longer = std::max(u, v), shorter = std::min(u, v);
  const float size = std::abs(value), corner = (longer + shorter) / 2, side = (longer - shorter) / 2;
  if (size >= corner) return value > 0 ? 1.0F : 0.0F;
  if (size <= side) return 0.5F + value / longer;
  const float cut = (corner - size) * (corner - size) / (2 * longer * shorter);  // a triangle is missing
  return value > 0 ? 1 - cut : cut;
}

}  // namespace stevedore::world
