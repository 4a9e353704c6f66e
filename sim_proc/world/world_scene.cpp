// What the camera sees of a world.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "sim_proc/world/world_state.hpp"

namespace stevedore::world {
namespace {

using Points = std::vector<Eigen::Vector3d>;

/// Taut a line; slack an arc that hangs out sideways. The sag of a flat arc of length l over distance d is
/// sqrt(3 d (l - d) / 8).
Points rope_points(const Eigen::Vector3d& from_m, const Eigen::Vector3d& to_m, double length_m,
                   const Eigen::Vector3d& sideways) {
  const Eigen::Vector3d line_m = to_m - from_m;
  const double distance_m = line_m.norm();
  const double sag_m = std::sqrt(3.0 / 8 * distance_m * std::max(0.0, length_m - distance_m));
  const int pieces = sag_m > 0.005 ? 8 : 1;  // thinner than the rope: a line
  Points points;
  for (int i = 0; i <= pieces; ++i) {
    const double share = static_cast<double>(i) / pieces;
    points.push_back(from_m + share * line_m + 4 * share * (1 - share) * sag_m * sideways);
  }
  return points;
}

/// A shank and three quarters of a ring: what hangs in it rests at `throat`.
Points hook_points(const Eigen::Vector3d& throat_m, const Eigen::Vector3d& up,
                   const Eigen::Vector3d& sideways) {
  constexpr double radius_m = 0.02, shank_m = 0.06;
  Points points{throat_m + shank_m * up};
  for (int i = 0; i <= 8; ++i) {
    const double angle_rad = 1.5 * std::numbers::pi * i / 8;
    points.push_back(throat_m + radius_m * (std::cos(angle_rad) * up - std::sin(angle_rad) * sideways));
  }
  return points;
}

Surface paint(float red, float green, float blue) {
  Surface surface;
  surface.colour = {red, green, blue};
  return surface;
}

}  // namespace

Scene World::State::surroundings() const {
  std::vector<Rigid> decks;
  for (const DeckFloor& deck : floor.decks) decks.push_back(deck.rigid);
  Scene scene = scenery.place(decks);
  scene.buckets.clear();
  for (const Cargo& cargo : cargoes) {
    if (cargo.state() != Cargo::State::sunk) scene.buckets.push_back(cargo.bucket());
  }
  scene.surroundings.wave_phase_s += time_s();
  return scene;
}

Scene World::scene(std::int64_t frame) const {
  const State& state = *state_;
  Scene scene = state.surroundings();
  const Eigen::Vector3d anchor_m = state.anchor_ned_m(), hook_m = state.sling.hook_ned_m();
  const Eigen::Vector3d up = (anchor_m - hook_m).normalized(), sideways = up.unitOrthogonal();
  scene.strands.push_back(
      {rope_points(anchor_m, hook_m, state.self.arms.rope_m, sideways), 0.004, paint(0.55F, 0.5F, 0.4F)});
  scene.strands.push_back({hook_points(hook_m, up, sideways), 0.004, paint(0.3F, 0.3F, 0.32F)});
  scene.aircraft.body = state.aircraft.body();
  scene.eye.rigid = state.camera();
  scene.eye.lens = state.self.camera;
  scene.eye.gain = static_cast<float>(std::exp(state.exposure.at(state.time_s()).value));
  scene.eye.noise_seed = Dice(state.seed + static_cast<std::uint64_t>(frame), "picture").next();
  return scene;
}

}  // namespace stevedore::world
