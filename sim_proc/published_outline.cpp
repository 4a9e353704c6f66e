#include "sim_proc/published_outline.hpp"

#include "geometry/rectify.hpp"
#include "sim_proc/world/outline.hpp"

namespace stevedore {
namespace {

/// Far outside the image a lens model means nothing, and need not have an inverse. An outline's part within
/// a quarter of the image around it is enough to carry the rest.
bool near_image(const Eigen::Vector2d& px, const Pinhole& camera) {
  const double margin_u_px = 0.25 * camera.width_px, margin_v_px = 0.25 * camera.height_px;
  return px.x() > -margin_u_px && px.x() < camera.width_px + margin_u_px && px.y() > -margin_v_px &&
         px.y() < camera.height_px + margin_v_px;
}

}  // namespace

std::optional<Ellipse> published_outline(const world::Scene& scene, const world::CircleTruth& circle,
                                         const CameraModel& told) {
  if (!circle.outline) return std::nullopt;
  if (told.distortion == Distortion::none) return circle.outline;  // the picture is published as it is
  const CameraModel& lens = scene.eye.lens;
  const auto outline = world::outline_of(scene, {circle.center_ned_m, circle.normal_ned, circle.radius_m});
  if (!outline) return std::nullopt;
  return bent(outline->ideal, [&](const Eigen::Vector2d& ideal_px) -> std::optional<Eigen::Vector2d> {
    const Eigen::Vector2d given_px = distort(lens, ideal_px);
    return near_image(given_px, lens.given) ? undistort(told, given_px) : std::nullopt;
  });
}

}  // namespace stevedore
