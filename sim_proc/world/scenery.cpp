#include "sim_proc/world/scenery.hpp"

#include <cmath>
#include <numbers>

#include "sim_proc/world/clutter.hpp"
#include "sim_proc/world/deck_marks.hpp"
#include "sim_proc/world/paints.hpp"

namespace stevedore::world {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::Vector3f;
using std::numbers::pi;

double radians(double degrees) {
  return degrees * pi / 180;
}

double log_uniform(double lowest, double highest, Dice& dice) {
  return std::exp(dice.uniform(std::log(lowest), std::log(highest)));
}

Light draw_light(Dice& dice) {
  Light light;
  const double elevation = radians(dice.uniform(12, 75)), azimuth = dice.uniform(-pi, pi);
  light.to_sun_ned = {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                      -std::sin(elevation)};
  const auto low = static_cast<float>(std::exp(-elevation / radians(15)));  // redder near the horizon
  light.sun = Vector3f(1, 0.97F - 0.15F * low, 0.92F - 0.4F * low);
  light.sky = Vector3f(0.24F, 0.28F, 0.34F);
  if (dice.chance(0.25)) {  // overcast
    light.sun *= static_cast<float>(dice.chance(0.5) ? 0 : dice.uniform(0.05, 0.25));
    light.sky = Vector3f(0.75F, 0.78F, 0.8F);
    light.sun_radius_rad = 0.08;
  } else if (dice.chance(0.3)) {  // hazy
    light.sun *= 0.7F;
    light.sky = Vector3f(0.42F, 0.44F, 0.46F);
    light.sun_radius_rad = 0.02;
  }
  return light;
}

/// Lighter or darker by a factor, rougher or smoother, from lowest to highest.
Surface draw_ground(const Vector3f& colour, double darkest, double lightest, double smoothest,
                    double roughest, Dice& dice) {
  const double grain = dice.uniform(smoothest, roughest);
  const auto lightness = static_cast<float>(dice.uniform(darkest, lightest));
  return make_surface(colour * lightness, grain, 0, dice);
}

Surroundings draw_surroundings(bool easy, Dice& dice) {
  using Kind = Surroundings::Kind;
  Surroundings around;
  around.kind = static_cast<Kind>(dice.whole(0, 2));
  switch (around.kind) {
    case Kind::tarmac:
      around.surface = draw_ground(Vector3f(0.11F, 0.11F, 0.115F), 0.7, 1.8, 0.15, 0.35, dice);
      break;
    case Kind::grass:
      around.surface = draw_ground(Vector3f(0.07F, 0.12F, 0.03F), 0.8, 1.4, 0.25, 0.45, dice);
      break;
    case Kind::water:
      around.surface = draw_ground(Vector3f(0.02F, 0.06F, 0.07F), 0.6, 1.4, 0.15, 0.45, dice);
      break;
  }
  around.wave_phase_s = dice.uniform(0, 100);
  if (easy) return around;
  around.haze = static_cast<float>(dice.chance(0.4) ? dice.uniform(0, 0.08) : 0);
  const bool wet = around.kind == Kind::water && dice.chance(0.4);
  around.spray = static_cast<float>(wet ? dice.uniform(0.002, 0.015) : 0);
  around.glare = static_cast<float>(dice.chance(0.35) ? dice.uniform(0.01, 0.12) : 0);
  return around;
}

Deck draw_platform(const Plan& plan, double circle_radius_m, bool easy, Dice& dice) {
  Deck deck;
  deck.half_size_m = plan.half_size_m;
  deck.thickness_m = dice.uniform(0.25, 0.6);
  const double grain = easy ? 0.05 : dice.uniform(0.06, 0.22);
  const auto colour = draw_deck_colour(dice);
  deck.ground = make_surface(colour, grain, 0, dice);
  if (!easy && dice.chance(0.3)) deck.ground.gloss = static_cast<float>(dice.uniform(0.05, 0.3));  // wet
  deck.marks = draw_marks(plan, circle_radius_m, deck.ground, !easy, dice);
  if (easy)
    for (Mark& mark : deck.marks) mark.paint.wear = 0;
  return deck;
}

Deck draw_pad(double circle_radius_m, bool easy, Dice& dice) {
  Plan plan;
  plan.half_size_m = Vector2d::Constant(dice.uniform(1.0, 1.6));
  plan.slots_deck_m = {Vector2d::Zero()};
  Deck pad = draw_platform(plan, circle_radius_m, easy, dice);
  pad.thickness_m = 0.05;
  return pad;
}

Bucket draw_bucket(int index, const Deck& deck, Dice& dice) {
  Bucket bucket;
  bucket.index = index;
  const Vector3f colour = draw_bucket_colour(deck.ground.colour, dice);
  bucket.outside = make_surface(colour, 0.08, 0, dice);
  bucket.outside.gloss = static_cast<float>(dice.uniform(0, 0.3));
  bucket.inside = bucket.outside;
  if (dice.chance(0.3))  // painted outside, metal or plastic inside
    bucket.inside.colour = Vector3f::Constant(static_cast<float>(dice.uniform(0.15, 0.5)));
  const double side = dice.chance(0.5) ? 1 : -1;
  bucket.handle_rad = dice.chance(0.5) ? dice.normal(0.06)  // upright
                                       : side * radians(dice.uniform(82, 96));
  return bucket;
}

}  // namespace

Scenery draw_scenery(const SceneryDraw& draw) {
  Dice dice(draw.seed, "scenery");
  Scenery scenery;
  scenery.circle_radius_m = draw.circle_radius_m;
  scenery.layout = dice.chance(0.5) ? Layout::square : Layout::row;
  scenery.light = draw_light(dice);
  scenery.surroundings = draw_surroundings(draw.easy, dice);
  scenery.exposure_s = draw.easy ? 0.001 : log_uniform(0.001, 0.006, dice);
  scenery.noise_levels = draw.easy ? 1 : static_cast<float>(log_uniform(1, 8, dice));
  scenery.lens_blur_sigma_px = static_cast<float>(dice.uniform(0.45, 0.9));
  for (int platform = 0; platform < 2; ++platform) {
    const Plan plan = draw_plan(scenery.layout, scenery.circle_radius_m, dice);
    scenery.decks.push_back(draw_platform(plan, scenery.circle_radius_m, draw.easy, dice));
    if (!draw.easy) scenery.clutter.push_back(draw_clutter(platform, plan, scenery.circle_radius_m, dice));
  }
  scenery.decks.push_back(draw_pad(scenery.circle_radius_m, draw.easy, dice));
  for (int i = 0; i < 4; ++i) scenery.buckets.push_back(draw_bucket(i, scenery.decks[0], dice));
  return scenery;
}

Scene Scenery::place(const std::vector<Rigid>& deck_rigids) const {
  Scene scene;
  scene.light = light;
  scene.surroundings = surroundings;
  scene.decks = decks;
  scene.buckets = buckets;
  scene.eye.exposure_s = exposure_s;
  scene.eye.noise_levels = noise_levels;
  scene.eye.blur_sigma_px = lens_blur_sigma_px;
  for (size_t i = 0; i < decks.size(); ++i) scene.decks[i].rigid = deck_rigids.at(i);
  for (const OnDeck& on_deck : clutter) {
    const Rigid& deck = deck_rigids.at(static_cast<size_t>(on_deck.deck));
    for (Tyre tyre : on_deck.tyres) {
      const Vector3d at = deck.to_ned(tyre.rigid.position_ned_m);
      tyre.rigid.ned_from_local = deck.ned_from_local * tyre.rigid.ned_from_local;
      tyre.rigid.position_ned_m = at;
      tyre.rigid.velocity_ned_mps = deck.velocity_at(at);
      tyre.rigid.angular_velocity_ned_radps = deck.angular_velocity_ned_radps;
      scene.tyres.push_back(tyre);
    }
    for (Capsule capsule : on_deck.capsules) {
      capsule.from_ned_m = deck.to_ned(capsule.from_ned_m);
      capsule.to_ned_m = deck.to_ned(capsule.to_ned_m);
      scene.capsules.push_back(capsule);
    }
    for (Strand strand : on_deck.strands) {
      for (Vector3d& point : strand.points_ned_m) point = deck.to_ned(point);
      scene.strands.push_back(strand);
    }
  }
  return scene;
}

}  // namespace stevedore::world
