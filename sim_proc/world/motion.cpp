#include "sim_proc/world/motion.hpp"

#include <array>
#include <cmath>
#include <cstring>

namespace stevedore::world {
namespace {

using Eigen::Vector2f;
using Eigen::Vector3d;
using Eigen::Vector3f;

/// Pixels that are blurred as one where they all move with the same thing: over eight pixels the flow of a
/// rigid thing changes by a hundredth.
constexpr int block_px = 8;

/// Motion over a shorter way than this is not to be seen: a tenth of what the lens blurs.
constexpr float still_px = 0.06F;

constexpr int most_samples = 24;

Motion motion_of(const Rigid& thing, const Rigid& eye) {
  const Eigen::Matrix3d camera_from_ned = eye.ned_from_local.conjugate().toRotationMatrix();
  const Vector3d drift = thing.velocity_at(eye.position_ned_m) - eye.velocity_ned_mps;
  const Vector3d turn = thing.angular_velocity_ned_radps - eye.angular_velocity_ned_radps;
  return {(camera_from_ned * drift).cast<float>(), (camera_from_ned * turn).cast<float>()};
}

/// A pixel that way from the one that is blurred, and its share of the mean.
struct Tap {
  int shift_u, shift_v;
  float weight;
};

struct Taps {
  std::array<Tap, 4 * most_samples> list;
  int count = 0;
  int reach_u = 0, reach_v = 0;  ///< largest shift either way

  void add(int shift_u, int shift_v, float weight) {
    if (weight <= 0) return;
    list[static_cast<size_t>(count++)] = {shift_u, shift_v, weight};
    reach_u = std::max(reach_u, std::abs(shift_u));
    reach_v = std::max(reach_v, std::abs(shift_v));
  }
};

/// Floor; the library's is a call.
int whole_part(float x) {
  const int towards_zero = static_cast<int>(x);
  return towards_zero - (x < static_cast<float>(towards_zero));
}

/// Evenly along a path centred on the pixel, no farther apart than a pixel, bilinear each.
Taps taps_along(const Vector2f& path_px) {
  Taps taps;
  const int samples = std::min(1 + static_cast<int>(std::ceil(path_px.norm())), most_samples);
  const float weight = 1 / static_cast<float>(samples);
  for (int s = 0; s < samples; ++s) {
    const Vector2f at = path_px * ((static_cast<float>(s) + 0.5F) * weight - 0.5F);
    const int u = whole_part(at.x()), v = whole_part(at.y());
    const float p = at.x() - static_cast<float>(u), q = at.y() - static_cast<float>(v);
    taps.add(u, v, weight * (1 - p) * (1 - q));
    taps.add(u + 1, v, weight * p * (1 - q));
    taps.add(u, v + 1, weight * (1 - p) * q);
    taps.add(u + 1, v + 1, weight * p * q);
  }
  return taps;
}

/// A whole block, all of whose taps are inside of the image.
void blur_inside(const float* plane, int width, const Taps& taps, float* out) {
  float sums[block_px] = {};
  for (int i = 0; i < taps.count; ++i) {
    const Tap& tap = taps.list[static_cast<size_t>(i)];
    const float* from = plane + static_cast<std::ptrdiff_t>(tap.shift_v) * width + tap.shift_u;
    for (int k = 0; k < block_px; ++k) sums[k] += tap.weight * from[k];
  }
  std::memcpy(out, sums, sizeof sums);
}

/// One pixel; outside of the image its border goes on.
void blur_pixel(const Picture& picture, int u, int v, const Taps& taps, const RowOut& out) {
  out.red[u] = out.green[u] = out.blue[u] = 0;
  for (int i = 0; i < taps.count; ++i) {
    const Tap& tap = taps.list[static_cast<size_t>(i)];
    const int row = std::clamp(v + tap.shift_v, 0, picture.height - 1);
    const int column = std::clamp(u + tap.shift_u, 0, picture.width - 1);
    const auto at =
        static_cast<size_t>(row) * static_cast<size_t>(picture.width) + static_cast<size_t>(column);
    out.red[u] += tap.weight * picture.red[at];
    out.green[u] += tap.weight * picture.green[at];
    out.blue[u] += tap.weight * picture.blue[at];
  }
}

/// `count` pixels from u on, all on the same path.
void blur_block(const Picture& picture, int u, int v, const Vector2f& path_px, int count, const RowOut& out) {
  const Taps taps = taps_along(path_px);
  const bool inside = count == block_px && u >= taps.reach_u &&
                      u + block_px + taps.reach_u <= picture.width && v >= taps.reach_v &&
                      v + taps.reach_v < picture.height;
  if (!inside) {
    for (int k = 0; k < count; ++k) blur_pixel(picture, u + k, v, taps, out);
    return;
  }
  const auto start = static_cast<std::ptrdiff_t>(v) * picture.width + u;
  blur_inside(picture.red.data() + start, picture.width, taps, out.red + u);
  blur_inside(picture.green.data() + start, picture.width, taps, out.green + u);
  blur_inside(picture.blue.data() + start, picture.width, taps, out.blue + u);
}

void copy_block(const Picture& picture, int u, int v, int count, const RowOut& out) {
  const auto start = static_cast<size_t>(v) * static_cast<size_t>(picture.width) + static_cast<size_t>(u);
  const auto bytes = static_cast<size_t>(count) * sizeof(float);
  std::memcpy(out.red + u, picture.red.data() + start, bytes);
  std::memcpy(out.green + u, picture.green.data() + start, bytes);
  std::memcpy(out.blue + u, picture.blue.data() + start, bytes);
}

bool moves_as_one(const std::uint8_t* motion, int count) {
  for (int k = 1; k < count; ++k)
    if (motion[k] != motion[0]) return false;
  return true;
}

}  // namespace

Motions::Motions(const Scene& scene) : decks_(scene.decks.size()) {
  const Rigid& eye = scene.eye.rigid;
  list_.push_back(motion_of({}, eye));
  for (const Deck& deck : scene.decks) list_.push_back(motion_of(deck.rigid, eye));
  list_.push_back({Vector3f::Zero(), Vector3f::Zero()});
  for (const Bucket& bucket : scene.buckets) list_.push_back(motion_of(bucket.rigid, eye));
}

std::uint8_t Motions::of_place(const Scene& scene, const Vector3d& ned_m, double height_m) const {
  constexpr double beside_m = 0.5;  // people stand at the edge
  for (size_t i = 0; i < scene.decks.size(); ++i) {
    const Deck& deck = scene.decks[i];
    const Vector3d local = deck.rigid.to_local(ned_m);
    if (std::abs(local.x()) < deck.half_size_m.x() + beside_m &&
        std::abs(local.y()) < deck.half_size_m.y() + beside_m && local.z() > -height_m &&
        local.z() < deck.thickness_m + 1)
      return this->deck(i);
  }
  return ned_m.z() > -height_m ? surroundings : static_cast<std::uint8_t>(1 + decks_);
}

bool Motions::is_still() const {
  constexpr float still = 1e-6F;
  for (const Motion& motion : list_)
    if (motion.drift_mps.norm() > still || motion.turn_radps.norm() > still) return false;
  return true;
}

Vector2f flow_at(const LensRays& rays, const Motion& motion, int u, int v, float depth_m) {
  const float x = rays.row_x(v)[u], y = rays.row_y(v)[u];
  const Vector3f ray(x, y, 1);
  // of the point divided by its depth
  const Vector3f change = motion.drift_mps / std::max(depth_m, 0.05F) + motion.turn_radps.cross(ray);
  const float change_x = change.x() - x * change.z(), change_y = change.y() - y * change.z();
  const RaySlopes s = rays.slopes(u, v);
  const float determinant = s.xu * s.yv - s.xv * s.yu;
  return {(s.yv * change_x - s.xv * change_y) / determinant,
          (s.xu * change_y - s.yu * change_x) / determinant};
}

void blur_row(const LensRays& rays, const Motions& motions, const Picture& picture, float exposure_s, int v,
              const RowOut& out) {
  const auto start = static_cast<std::ptrdiff_t>(v) * picture.width;
  const std::uint8_t* motion = picture.motion.data() + start;
  const float* depth_m = picture.depth_m.data() + start;
  const auto blur = [&](int u, int at, int count) {
    const Vector2f path_px = exposure_s * flow_at(rays, motions.at(motion[at]), at, v, depth_m[at]);
    if (path_px.norm() < still_px)
      copy_block(picture, u, v, count, out);
    else
      blur_block(picture, u, v, path_px, count, out);
  };
  for (int u = 0; u < picture.width; u += block_px) {
    const int count = std::min(block_px, picture.width - u);
    if (moves_as_one(motion + u, count)) {
      blur(u, u + count / 2, count);
      continue;
    }
    for (int k = 0; k < count; ++k) blur(u + k, u + k, 1);
  }
}

}  // namespace stevedore::world
