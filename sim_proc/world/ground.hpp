// The surroundings, and the light that a plane sends to the eye.
#pragma once

#include "sim_proc/world/plane_row.hpp"
#include "sim_proc/world/scene.hpp"
#include "sim_proc/world/texture.hpp"

namespace stevedore::world {

/// Reflectance and mirrored light of tarmac, grass or water; sun and sky must hold the shares that reach it.
void lay_surroundings(const Surroundings& surroundings, const Light& light, const Textures& textures,
                      const PlaneView& plane, PlaneRow& row);

/// The sun's sheen on a glossy plane.
void add_gloss(float gloss, const Light& light, const Eigen::Vector3f& to_sun_local, const PlaneView& plane,
               PlaneRow& row);

/// Light of a plane whose upward normal makes that cosine with the sun: into red, green, blue in place of the
/// reflectance.
void light_plane(const Light& light, float sun_cosine, PlaneRow& row);

/// Light of the sky in that direction (unit, NED).
Eigen::Vector3f sky_light(const Light& light, const Eigen::Vector3f& direction_ned);

}  // namespace stevedore::world
