#include "sim_proc/world/sling.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

namespace stevedore::world {

Sling::Sling(std::uint64_t seed, const Eigen::Vector3d& anchor_ned_m, double rope_m)
    : dice_(seed, "sling"),
      rope_(anchor_ned_m, {rope_m, hook_drag_per_s}),
      rope_m_(rope_m),
      hook_ned_m_(rope_.weight_ned_m()) {}

void Sling::step(const Eigen::Vector3d& anchor_ned_m, const Eigen::Vector3d& wind_ned_mps, const Floor& floor,
                 std::vector<Cargo>& cargoes, double step_s) {
  Cargo* cargo = carried_ < 0 ? nullptr : &cargoes[static_cast<std::size_t>(carried_)];
  if (!close_) {
    open(cargo);
    cargo = nullptr;
  }
  if (cargo != nullptr) {
    carry(anchor_ned_m, wind_ned_mps, floor, *cargo, step_s);
  } else {
    swing_empty(anchor_ned_m, wind_ned_mps, floor, step_s);
    if (close_ && !closed_) reach_for(cargoes, step_s);
  }
}

void Sling::open(Cargo* cargo) {
  closed_ = false;
  grip_.reset();
  if (cargo != nullptr) lose(*cargo);
}

/// The bucket goes its own way; the hook goes on from where it is.
void Sling::lose(Cargo& cargo) {
  const Eigen::Vector3d velocity_mps = cargo.bucket().rigid.velocity_at(hook_ned_m_);
  cargo.let_go();
  carried_ = -1;
  rope_.carry(hook_ned_m_, velocity_mps, {rope_m_, hook_drag_per_s});
}

void Sling::swing_empty(const Eigen::Vector3d& anchor_ned_m, const Eigen::Vector3d& wind_ned_mps,
                        const Floor& floor, double step_s) {
  rope_.step(anchor_ned_m, wind_ned_mps, step_s);
  rope_.rest_on(floor);
  hook_ned_m_ = rope_.weight_ned_m();
  load_n_ = 0;  // the cell is tared with the hook on it
}

void Sling::reach_for(const std::vector<Cargo>& cargoes, double step_s) {
  int nearest = -1;
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < cargoes.size(); ++i) {
    if (cargoes[i].state() != Cargo::State::standing) continue;
    const double away_m = (cargoes[i].handle_apex_ned_m() - hook_ned_m_).norm();
    if (away_m < nearest_m) nearest = static_cast<int>(i), nearest_m = away_m;
  }
  if (nearest < 0) return;
  const Cargo& cargo = cargoes[static_cast<std::size_t>(nearest)];
  const Eigen::Vector3d apex_m = cargo.handle_apex_ned_m(), miss_m = hook_ned_m_ - apex_m;
  const double speed_mps = (rope_.velocity_ned_mps() - cargo.bucket().rigid.velocity_at(apex_m)).norm();
  const auto share_of_limits = grip_.step(nearest, {miss_m.head<2>().norm(), miss_m.z(), speed_mps}, step_s);
  if (share_of_limits) take(nearest, *share_of_limits, miss_m.norm());
}

void Sling::take(int index, double share_of_limits, double missing_m) {
  closed_ = true;
  carried_ = index;
  missing_m_ = missing_m;
  hung_s_ = 0;
  slips_after_s_.reset();
  if (dice_.chance(Grip::chance_to_slip(share_of_limits))) slips_after_s_ = dice_.uniform(3, 15);
}

/// Standing, its rope slack, until the rope is taut; then hanging until it touches.
void Sling::carry(const Eigen::Vector3d& anchor_ned_m, const Eigen::Vector3d& wind_ned_mps,
                  const Floor& floor, Cargo& cargo, double step_s) {
  load_n_ = 0;
  if (cargo.state() == Cargo::State::lying) return lose(cargo);  // it was set down upon another
  missing_m_ = std::max(0.0, missing_m_ - draw_up_mps * step_s);
  if (cargo.state() == Cargo::State::standing) {
    hook_ned_m_ = cargo.handle_apex_ned_m();
    if ((hook_ned_m_ - anchor_ned_m).norm() > rope_m_ + missing_m_) lift(anchor_ned_m, cargo, step_s);
    return;
  }
  rope_.lengthen_to(rope_m_ + missing_m_ + cargo.drop_of_center_m());
  rope_.step(anchor_ned_m, wind_ned_mps, step_s);
  cargo.hang(rope_.weight_ned_m(), rope_.velocity_ned_mps(), rope_.up_ned(), step_s);
  hook_ned_m_ = cargo.handle_apex_ned_m();
  load_n_ = Cargo::mass_kg * rope_.pull_mps2();
  hung_s_ += step_s;
  if (cargo.clearance_m(floor) <= 0) meet_the_floor(anchor_ned_m, floor, cargo, step_s);
  const bool torn_out = cargo.state() == Cargo::State::lying || -rope_.up_ned().z() < slips_at_cosine;
  if (torn_out || (slips_after_s_ && hung_s_ > *slips_after_s_)) lose(cargo);
}

/// Held by its handle a bucket drags until it stands; leaning so far that its weight is past its edge, it
/// tips.
void Sling::meet_the_floor(const Eigen::Vector3d& anchor_ned_m, const Floor& floor, Cargo& cargo,
                           double step_s) {
  const Bucket& bucket = cargo.bucket();
  const Footing on = cargo.footing(floor);
  const double edge_cosine = std::cos(std::atan2(bucket.base_radius_m, center_height_m(bucket)));
  const bool past_the_edge = cargo.axis_ned().dot(on.up_ned()) < edge_cosine;
  const bool being_lifted = hung_s_ < lift_off_s;
  if (past_the_edge || (!being_lifted && cargo.would_stand(floor))) {
    cargo.touch_down(floor);
    missing_m_ = std::max(0.0, (cargo.handle_apex_ned_m() - anchor_ned_m).norm() - rope_m_) + play_m;
  } else {
    rope_.drag_over(on, -cargo.clearance_m(floor), step_s);
  }
}

void Sling::lift(const Eigen::Vector3d& anchor_ned_m, Cargo& cargo, double step_s) {
  const Eigen::Vector3d up_ned = (anchor_ned_m - hook_ned_m_).normalized();
  const double length_m = rope_m_ + missing_m_ + cargo.drop_of_center_m();
  const Eigen::Vector3d center_m = anchor_ned_m - length_m * up_ned;
  rope_.carry(center_m, cargo.bucket().rigid.velocity_at(cargo.center_of_mass_ned_m()),
              {length_m, bucket_drag_per_s});
  cargo.hang(center_m, rope_.velocity_ned_mps(), up_ned, step_s);
  hung_s_ = 0;
}

}  // namespace stevedore::world
