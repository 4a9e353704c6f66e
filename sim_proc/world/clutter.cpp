#include "sim_proc/world/clutter.hpp"

#include <cmath>
#include <numbers>

#include "sim_proc/world/paints.hpp"

namespace stevedore::world {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

Capsule capsule(const Vector3d& from, const Vector3d& to, double radius_m, const Surface& surface) {
  Capsule out;
  out.from_ned_m = from;
  out.to_ned_m = to;
  out.radius_m = radius_m;
  out.surface = surface;
  return out;
}

/// At the deck's edge, on it or just beside it.
Vector2d draw_edge_place(const Vector2d& half_size_m, Dice& dice) {
  const double beyond_m = dice.uniform(-0.2, 0.1);
  const Vector2d half = half_size_m.array() + beyond_m;
  const bool on_x_side = dice.chance(half.y() / (half.x() + half.y()));
  const double side = dice.chance(0.5) ? 1 : -1;
  if (on_x_side) return {side * half.x(), dice.uniform(-half.y(), half.y())};
  return {dice.uniform(-half.x(), half.x()), side * half.y()};
}

Tyre draw_tyre(const Vector2d& at_deck_m, double radius_m, Dice& dice) {
  Tyre tyre;
  tyre.radius_m = radius_m;
  tyre.tube_m = radius_m * dice.uniform(0.25, 0.33);
  tyre.rigid.position_ned_m = {at_deck_m.x(), at_deck_m.y(), 0};
  const auto grey = static_cast<float>(dice.uniform(0.02, 0.06));
  tyre.rubber = make_surface(Eigen::Vector3f(grey, grey, grey), 0.2, 0, dice);
  return tyre;
}

}  // namespace

std::vector<Capsule> draw_person(const Vector2d& at_deck_m, Dice& dice) {
  const double facing = dice.uniform(-pi, pi), size = dice.uniform(0.92, 1.08),
               stride = dice.uniform(0, 0.15);
  const double raised = dice.chance(0.3) ? dice.uniform(0.2, 0.6) : 0;  // an arm that points or waves
  const auto at = [&](double forward, double right, double up) -> Vector3d {
    const double c = std::cos(facing), s = std::sin(facing);
    return {at_deck_m.x() + size * (c * forward - s * right),
            at_deck_m.y() + size * (s * forward + c * right), -size * up};
  };
  const Surface trousers = make_surface(draw_cloth_colour(dice), 0.2, 0, dice);
  const Surface jacket = make_surface(draw_cloth_colour(dice), 0.2, 0, dice);
  const Surface head = dice.chance(0.5) ? make_surface({0.70F, 0.55F, 0.05F}, 0.05, 0, dice)  // helmet
                                        : make_surface({0.06F, 0.04F, 0.03F}, 0.3, 0, dice);  // hair
  const double leg_m = 0.075 * size, arm_m = 0.05 * size;
  return {capsule(at(stride, 0.1, 0.08), at(0, 0.09, 0.82), leg_m, trousers),
          capsule(at(-stride, -0.1, 0.08), at(0, -0.09, 0.82), leg_m, trousers),
          capsule(at(0, 0, 0.95), at(0.02, 0, 1.36), 0.165 * size, jacket),
          capsule(at(0, 0.21, 1.42), at(0.1, 0.27, 0.92), arm_m, jacket),
          capsule(at(0, -0.21, 1.42), at(0.1 + raised, -0.27, 0.92 + raised), arm_m, jacket),
          capsule(at(0.03, 0, 1.62), at(0.04, 0, 1.68), 0.115 * size, head)};
}

Strand draw_lying_rope(const Vector2d& half_size_m, Dice& dice) {
  Strand rope;
  rope.radius_m = dice.uniform(0.004, 0.011);
  const auto pale = static_cast<float>(dice.uniform(0.15, 0.6));
  rope.surface = make_surface({pale, 0.93F * pale, 0.8F * pale}, 0.2, 0, dice);
  const double y = dice.uniform(-1, 1), x = dice.uniform(-1, 1);
  Vector2d at(x * half_size_m.x(), y * half_size_m.y());
  double heading = dice.uniform(-pi, pi), bend = 0;
  constexpr double step_m = 0.06;
  for (int i = dice.whole(15, 55); i > 0; --i) {
    const bool on_deck = std::abs(at.x()) < half_size_m.x() && std::abs(at.y()) < half_size_m.y();
    if (!on_deck) break;
    rope.points_ned_m.emplace_back(at.x(), at.y(), -rope.radius_m);
    bend = 0.85 * bend + dice.normal(0.12);  // it keeps its bend for a few hand's breadths
    heading += bend;
    at += step_m * Vector2d(std::cos(heading), std::sin(heading));
  }
  return rope;
}

Scenery::OnDeck draw_clutter(int deck, const Plan& plan, double circle_radius_m, Dice& dice) {
  Scenery::OnDeck clutter;
  clutter.deck = deck;
  for (int i = dice.whole(0, 3); i > 0; --i) {
    const double radius_m = dice.uniform(0.26, 0.36);
    if (const auto place = draw_free_place(plan, circle_radius_m, radius_m * 0.9, dice)) {
      const Vector2d inside = place->cwiseAbs() - plan.half_size_m;
      if (inside.maxCoeff() < -radius_m) clutter.tyres.push_back(draw_tyre(*place, radius_m, dice));
    }
  }
  for (int i = dice.whole(0, 3); i > 0; --i)
    for (const Capsule& part : draw_person(draw_edge_place(plan.half_size_m, dice), dice))
      clutter.capsules.push_back(part);
  if (dice.chance(0.3)) {  // poles at the corners
    const Surface metal = make_surface({0.4F, 0.4F, 0.4F}, 0.1, 0, dice);
    const double height_m = dice.uniform(0.4, 1.1);
    for (const double sx : {-1.0, 1.0})
      for (const double sy : {-1.0, 1.0}) {
        const Vector2d at = Vector2d(sx, sy).cwiseProduct(plan.half_size_m) * 0.97;
        clutter.capsules.push_back(capsule({at.x(), at.y(), 0}, {at.x(), at.y(), -height_m}, 0.025, metal));
      }
  }
  for (int i = dice.whole(0, 2); i > 0; --i)
    clutter.strands.push_back(draw_lying_rope(plan.half_size_m, dice));
  return clutter;
}

}  // namespace stevedore::world
