#include "sim_proc/world/rope.hpp"

#include <algorithm>
#include <cmath>

#include "sim_proc/world/gravity.hpp"

namespace stevedore::world {

Rope::Rope(const Eigen::Vector3d& anchor_ned_m, const Load& load)
    : anchor_ned_m_(anchor_ned_m),
      load_(load),
      weight_ned_m_(anchor_ned_m + Eigen::Vector3d(0, 0, load.length_m)) {}

void Rope::carry(const Eigen::Vector3d& weight_ned_m, const Eigen::Vector3d& velocity_ned_mps,
                 const Load& load) {
  weight_ned_m_ = weight_ned_m;
  velocity_ned_mps_ = velocity_ned_mps;
  load_ = load;
}

/// Free flight, then back to the rope's length (position based dynamics, Mueller et al. 2007): the way back
/// is what the rope's pull has done in the step.
void Rope::step(const Eigen::Vector3d& anchor_ned_m, const Eigen::Vector3d& wind_ned_mps, double step_s) {
  const Eigen::Vector3d anchor_mps = (anchor_ned_m - anchor_ned_m_) / step_s;
  anchor_ned_m_ = anchor_ned_m;
  const Eigen::Vector3d fall_mps2 = gravity_mps2 * Eigen::Vector3d::UnitZ() +
                                    load_.drag_per_s * (wind_ned_mps - velocity_ned_mps_) +
                                    friction_per_s * (anchor_mps - velocity_ned_mps_);
  const Eigen::Vector3d free_m = weight_ned_m_ + (velocity_ned_mps_ + fall_mps2 * step_s) * step_s;
  const Eigen::Vector3d line_m = free_m - anchor_ned_m;
  const double stretch_m = line_m.norm() - load_.length_m;
  const Eigen::Vector3d held_m =
      stretch_m > 0 ? Eigen::Vector3d(anchor_ned_m + load_.length_m * line_m.normalized()) : free_m;
  pull_mps2_ = stretch_m > 0 ? stretch_m / (step_s * step_s) : 0;
  velocity_ned_mps_ = (held_m - weight_ned_m_) / step_s;
  weight_ned_m_ = held_m;
}

void Rope::rest_on(const Floor& floor) {
  const Footing below = footing_below(floor, weight_ned_m_);
  const double height_m = below.height_of(weight_ned_m_);
  if (height_m > 0) return;
  weight_ned_m_ -= height_m * below.up_ned();
  velocity_ned_mps_ = below.rigid.velocity_at(weight_ned_m_);
  pull_mps2_ = 0;
}

void Rope::drag_over(const Footing& on, double raised_m, double step_s) {
  constexpr double friction_time_s = 0.2;  // of 1 m/s at half a g, about the friction of steel on paint
  const Eigen::Vector3d up_ned = on.up_ned(), floor_mps = on.rigid.velocity_at(weight_ned_m_);
  weight_ned_m_ += raised_m * up_ned;
  const Eigen::Vector3d over_mps = velocity_ned_mps_ - floor_mps;
  const double rising_mps = over_mps.dot(up_ned);
  const Eigen::Vector3d sideways_mps = over_mps - rising_mps * up_ned;
  velocity_ned_mps_ =
      floor_mps + std::max(0.0, rising_mps) * up_ned + std::exp(-step_s / friction_time_s) * sideways_mps;
}

Eigen::Vector3d Rope::up_ned() const {
  return (anchor_ned_m_ - weight_ned_m_).normalized();
}

}  // namespace stevedore::world
