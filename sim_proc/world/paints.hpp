// Colours that things come in, and which of them can be told apart.
#pragma once

#include "sim_proc/world/dice.hpp"
#include "sim_proc/world/scene.hpp"

namespace stevedore::world {

/// How clearly two colours differ in an sRGB image, 0..1.
struct Contrast {
  float luminance;  ///< of luma
  float colour;     ///< of the two chroma values, as length
};
Contrast contrast_between(const Eigen::Vector3f& a, const Eigen::Vector3f& b);

/// Whether anyone sees the edge between them at a glance, in sun and shadow: by a fifth of full scale in
/// luma, or by a quarter in chroma.
bool differ_visibly(const Eigen::Vector3f& a, const Eigen::Vector3f& b);

Eigen::Vector3f draw_deck_colour(Dice& dice);
/// Differs visibly from the deck; in one draw of seven by colour rather than by luminance.
Eigen::Vector3f draw_mark_colour(const Eigen::Vector3f& deck, Dice& dice);
Eigen::Vector3f draw_cloth_colour(Dice& dice);
/// Differs visibly from what it stands on.
Eigen::Vector3f draw_bucket_colour(const Eigen::Vector3f& deck, Dice& dice);

Surface make_surface(const Eigen::Vector3f& colour, double grain, double wear, Dice& dice);

}  // namespace stevedore::world
