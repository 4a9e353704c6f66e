// What is really there.
#include <algorithm>
#include <cmath>

#include "sim_proc/world/outline.hpp"
#include "sim_proc/world/world_state.hpp"

namespace stevedore::world {
namespace {

bool is_in(const Slot& slot, const Cargo& cargo, const Floor& floor) {
  if (cargo.deck() != slot.deck) return false;
  const Rigid& deck = floor.decks[static_cast<std::size_t>(slot.deck)].rigid;
  const Eigen::Vector3d base_m = deck.to_local(cargo.bucket().rigid.position_ned_m);
  return (base_m.head<2>() - slot.center_deck_m).norm() <= slot.radius_m;
}

CircleTruth truth_of(const Slot& slot, const std::vector<Cargo>& cargoes, const Floor& floor) {
  const Rigid& deck = floor.decks[static_cast<std::size_t>(slot.deck)].rigid;
  CircleTruth circle;
  circle.platform = slot.deck;
  circle.slot = slot.number;
  circle.occupied = std::any_of(cargoes.begin(), cargoes.end(), [&](const Cargo& cargo) {
    return cargo.state() == Cargo::State::standing && is_in(slot, cargo, floor);
  });
  circle.center_ned_m = deck.to_ned({slot.center_deck_m.x(), slot.center_deck_m.y(), 0});
  circle.normal_ned = deck.ned_from_local * -Eigen::Vector3d::UnitZ();
  circle.radius_m = slot.radius_m;
  return circle;
}

CargoTruth truth_of(const Cargo& cargo, const std::vector<Slot>& slots, const Floor& floor) {
  CargoTruth truth;
  truth.index = cargo.bucket().index;
  truth.platform = cargo.deck();
  const auto slot =
      std::find_if(slots.begin(), slots.end(), [&](const Slot& each) { return is_in(each, cargo, floor); });
  truth.slot = slot == slots.end() ? -1 : slot->number;
  truth.center_ned_m = cargo.rim_center_ned_m();
  truth.axis_ned = cargo.axis_ned();
  truth.radius_m = cargo.bucket().rim_radius_m;
  truth.tipped = cargo.tipped();
  return truth;
}

}  // namespace

Truth World::whereabouts() const {
  const State& state = *state_;
  Truth truth;
  truth.time_s = state.time_s();
  for (const Slot& slot : state.slots) truth.circles.push_back(truth_of(slot, state.cargoes, state.floor));
  for (const Cargo& cargo : state.cargoes) truth.cargoes.push_back(truth_of(cargo, state.slots, state.floor));
  const int carried = state.sling.carried();
  if (carried >= 0) truth.cargoes[static_cast<std::size_t>(carried)].on_hook = true;
  truth.aircraft = state.aircraft.body();
  truth.camera = state.camera();
  truth.hook_ned_m = state.sling.hook_ned_m();
  const double down = (truth.camera.ned_from_local * Eigen::Vector3d::UnitZ()).z();
  truth.off_level_rad = std::acos(std::clamp(down, -1.0, 1.0));
  return truth;
}

Truth World::truth() const {
  Truth truth = whereabouts();
  const Scene seen = scene(0);
  for (CircleTruth& circle : truth.circles) {
    const auto outline = outline_of(seen, {circle.center_ned_m, circle.normal_ned, circle.radius_m});
    if (!outline) continue;
    circle.outline = outline->given;
    circle.visible_share = outline->visible_share;
  }
  return truth;
}

}  // namespace stevedore::world
