#include "sim_proc/world/planes.hpp"

#include <cmath>

#include "sim_proc/world/ground.hpp"
#include "sim_proc/world/motion.hpp"
#include "sim_proc/world/surface.hpp"

namespace stevedore::world {
namespace {

using Eigen::Vector3f;

/// Farther than this everything is horizon.
constexpr float farthest_m = 2000;

void clear_light(PlaneRow& row) {
  const int count = row.last - row.first;
  std::fill_n(row.sun.data() + row.first, count, 1.0F);
  std::fill_n(row.sky.data() + row.first, count, 1.0F);
  for (auto* glow : {&row.glow_red, &row.glow_green, &row.glow_blue})
    std::fill_n(glow->data() + row.first, count, 0.0F);
}

}  // namespace

DeckLayer::DeckLayer(const View& view, const Scene& scene, size_t index, std::uint8_t motion)
    : rays_(view.rays),
      deck_(scene.decks[index]),
      light_(scene.light),
      plane_(view, deck_.rigid),
      marks_(view, deck_),
      shadows_(view, scene, deck_.rigid, static_cast<int>(index)),
      body_(Solid::of(view, deck_, motion)),
      to_sun_((deck_.rigid.ned_from_local.conjugate() * scene.light.to_sun_ned).cast<float>()),
      half_x_m_(static_cast<float>(deck_.half_size_m.x())),
      half_y_m_(static_cast<float>(deck_.half_size_m.y())),
      motion_(motion) {}

float DeckLayer::cover_at(const PlaneRow& row, int column) const {
  const auto u = static_cast<size_t>(column);
  if (!(row.depth_m[u] > 0) || row.depth_m[u] > farthest_m) return 0;
  const float inside_x = half_x_m_ - std::abs(row.x_m[u]), inside_y = half_y_m_ - std::abs(row.y_m[u]);
  const float share_x = plane_.coverage(row, column, inside_x, row.x_m[u] > 0 ? -1.0F : 1.0F, 0);
  if (share_x <= 0) return 0;
  return share_x * plane_.coverage(row, column, inside_y, 0, row.y_m[u] > 0 ? -1.0F : 1.0F);
}

bool DeckLayer::meet(int v, PlaneRow& row) const {
  const PixelRect& rect = body_.rect();
  row.v = v;
  row.first = rect.left;
  row.last = rect.has_row(v) && plane_.from_above() ? rect.right : rect.left;
  if (row.first >= row.last) return false;
  plane_.meet(row);
  for (int u = row.first; u < row.last; ++u) row.cover[static_cast<size_t>(u)] = cover_at(row, u);
  const auto covered = [&](int u) { return row.cover[static_cast<size_t>(u)] > 0; };
  while (row.first < row.last && !covered(row.first)) ++row.first;
  while (row.first < row.last && !covered(row.last - 1)) --row.last;
  return row.first < row.last;
}

void DeckLayer::draw_body(const Textures& textures, int first, int last, Picture& picture,
                          Solid::Scratch& scratch) const {
  body_.draw(rays_, light_, textures, first, last, picture, scratch);
}

void DeckLayer::draw_top(const Textures& textures, PlaneRow& row, const PictureRow& picture) const {
  clear_light(row);
  lay_ground(deck_.ground, textures, plane_, row);
  marks_.paint(plane_, textures, row);
  shadows_.cast(plane_, row);
  add_gloss(deck_.ground.gloss, light_, to_sun_, plane_, row);
  light_plane(light_, -to_sun_.z(), row);
  for (int column = row.first; column < row.last; ++column) {
    const auto u = static_cast<size_t>(column);
    if (row.cover[u] > 0 && row.depth_m[u] < picture.depth_m[column] + 0.01F)
      picture.lay(column, {row.red[u], row.green[u], row.blue[u]}, row.cover[u], row.depth_m[u], motion_);
  }
}

GroundLayer::GroundLayer(const View& view, const Scene& scene)
    : surroundings_(scene.surroundings),
      light_(scene.light),
      plane_(view, level_),
      shadows_(view, scene, level_, -1) {}

void GroundLayer::draw(const Textures& textures, PlaneRow& row, const PictureRow& picture) const {
  plane_.meet(row);
  const auto seen = [&](int u) {
    const float depth = row.depth_m[static_cast<size_t>(u)];
    return depth > 0 && depth < farthest_m;
  };
  for (int u = row.first; u < row.last; ++u)
    if (!seen(u)) {
      const auto i = static_cast<size_t>(u);
      row.depth_m[i] = farthest_m;
      row.x_m[i] = row.y_m[i] = 0;
    }
  clear_light(row);
  shadows_.cast(plane_, row);
  lay_surroundings(surroundings_, light_, textures, plane_, row);
  light_plane(light_, static_cast<float>(-light_.to_sun_ned.z()), row);
  for (int column = row.first; column < row.last; ++column) {
    const auto u = static_cast<size_t>(column);
    picture.red[column] = row.red[u];
    picture.green[column] = row.green[u];
    picture.blue[column] = row.blue[u];
    picture.depth_m[column] = row.depth_m[u];
    picture.motion[column] = Motions::surroundings;
  }
  draw_sky(row, picture);
}

void GroundLayer::draw_sky(const PlaneRow& row, const PictureRow& picture) const {
  for (int u = row.first; u < row.last; ++u) {
    if (picture.depth_m[u] < farthest_m) continue;
    const Vector3f direction = (plane_.local().local_from_camera *
                                Vector3f(plane_.rays().row_x(row.v)[u], plane_.rays().row_y(row.v)[u], 1))
                                   .normalized();
    const Vector3f light = sky_light(light_, direction);
    picture.red[u] = light[0];
    picture.green[u] = light[1];
    picture.blue[u] = light[2];
  }
}

void add_haze(const Scene& scene, int width, const PictureRow& picture) {
  const float haze = scene.surroundings.haze;
  if (haze <= 0) return;
  const Vector3f air = scene.light.sky + 0.3F * scene.light.sun;
  constexpr float told_for_m = 10;
  const float per_m = haze / (1 - std::min(haze, 0.99F)) / told_for_m;
  for (int u = 0; u < width; ++u) {
    const float thickness = per_m * picture.depth_m[u], share = thickness / (1 + thickness);
    picture.red[u] += share * (air[0] - picture.red[u]);
    picture.green[u] += share * (air[1] - picture.green[u]);
    picture.blue[u] += share * (air[2] - picture.blue[u]);
  }
}

}  // namespace stevedore::world
