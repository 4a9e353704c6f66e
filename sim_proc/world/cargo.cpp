#include "sim_proc/world/cargo.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>

#include "sim_proc/world/gravity.hpp"

namespace stevedore::world {
namespace {

Footing footing_number(const Floor& floor, int deck) {
  if (deck < 0) return {};
  return {deck, floor.decks[static_cast<std::size_t>(deck)].rigid};
}

bool off_the_edge(const Floor& floor, int deck, const Eigen::Vector3d& at_m) {
  if (deck < 0) return false;
  const Eigen::Vector2d& half_m = floor.decks[static_cast<std::size_t>(deck)].half_size_m;
  return (at_m.head<2>().cwiseAbs().array() > half_m.array()).any();
}

Eigen::Vector3d level_with(const Footing& on, const Eigen::Vector3d& direction_ned) {
  const Eigen::Vector3d up_ned = on.up_ned();
  const Eigen::Vector3d level = direction_ned - direction_ned.dot(up_ned) * up_ned;
  return level.norm() > 0 ? Eigen::Vector3d(level.normalized()) : Eigen::Vector3d(up_ned.unitOrthogonal());
}

constexpr double push_mps = 0.5;  ///< that a bucket rolls off another with

}  // namespace

void keep_apart(std::vector<Cargo>& cargoes, std::size_t landed, const Floor& floor) {
  for (std::size_t i = 0; i < cargoes.size(); ++i) {
    const bool in_the_way = i != landed && cargoes[i].deck() == cargoes[landed].deck() &&
                            cargoes[i].state() != Cargo::State::sunk;
    const Eigen::Vector3d away_m =
        cargoes[landed].bucket().rigid.position_ned_m - cargoes[i].bucket().rigid.position_ned_m;
    const double room_m = cargoes[landed].bucket().rim_radius_m + cargoes[i].bucket().rim_radius_m;
    if (in_the_way && away_m.norm() < room_m) cargoes[landed].topple(floor, away_m);
  }
}

Cargo::Cargo(const Bucket& look, int deck, const Eigen::Vector2d& base_deck_m, double heading_rad,
             const Floor& floor)
    : bucket_(look), deck_(deck) {
  base_on_floor_m_ << base_deck_m, 0;
  floor_from_bucket_ = Eigen::AngleAxisd(heading_rad, Eigen::Vector3d::UnitZ());
  ride(floor);
}

void Cargo::step(const Floor& floor, double step_s) {
  switch (state_) {
    case State::standing:
      ride(floor);
      break;
    case State::lying:
      roll(floor, step_s);
      break;
    case State::falling:
      fall(floor, step_s);
      break;
    case State::hanging:
    case State::sunk:
      break;
  }
}

/// Where what it is on takes it.
void Cargo::ride(const Floor& floor) {
  const Rigid on = footing_number(floor, deck_).rigid;
  bucket_.rigid.position_ned_m = on.to_ned(base_on_floor_m_);
  bucket_.rigid.ned_from_local = on.ned_from_local * floor_from_bucket_;
  bucket_.rigid.velocity_ned_mps = on.velocity_at(bucket_.rigid.position_ned_m);
  bucket_.rigid.angular_velocity_ned_radps = on.angular_velocity_ned_radps;
}

void Cargo::roll(const Floor& floor, double step_s) {
  const double speed_mps = rolling_mps_.norm();
  if (speed_mps > 0) {
    base_on_floor_m_.head<2>() += rolling_mps_ * step_s;
    rolling_mps_ *= std::max(0.0, 1 - rolling_friction_mps2 * step_s / speed_mps);
  }
  ride(floor);
  const Eigen::Vector3d drift_ned_mps = footing_number(floor, deck_).rigid.ned_from_local *
                                        Eigen::Vector3d(rolling_mps_.x(), rolling_mps_.y(), 0);
  bucket_.rigid.velocity_ned_mps += drift_ned_mps;
  if (off_the_edge(floor, deck_, base_on_floor_m_)) state_ = State::falling;
}

void Cargo::fall(const Floor& floor, double step_s) {
  Rigid& rigid = bucket_.rigid;
  const Eigen::Vector3d center_m = center_of_mass_ned_m();
  const Eigen::Vector3d velocity_mps =
      rigid.velocity_at(center_m) + gravity_mps2 * step_s * Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d turn_rad = rigid.angular_velocity_ned_radps * step_s;
  if (turn_rad.norm() > 0) {
    const Eigen::AngleAxisd turn(turn_rad.norm(), turn_rad.normalized());
    rigid.ned_from_local = (turn * rigid.ned_from_local).normalized();
  }
  rigid.position_ned_m = center_m + velocity_mps * step_s - center_height_m(bucket_) * axis_ned();
  rigid.velocity_ned_mps =
      velocity_mps + rigid.angular_velocity_ned_radps.cross(-center_height_m(bucket_) * axis_ned());
  if (footing(floor).height_of(lowest_ned_m(footing(floor).up_ned())) <= 0) touch_down(floor);
}

void Cargo::hang(const Eigen::Vector3d& center_ned_m, const Eigen::Vector3d& velocity_ned_mps,
                 const Eigen::Vector3d& up_ned, double step_s) {
  Rigid& rigid = bucket_.rigid;
  const bool was_hanging = state_ == State::hanging;
  const Eigen::Quaterniond turn = Eigen::Quaterniond::FromTwoVectors(axis_ned(), up_ned);
  rigid.ned_from_local = (turn * rigid.ned_from_local).normalized();
  rigid.angular_velocity_ned_radps =
      was_hanging ? Eigen::Vector3d(2 / step_s * turn.vec()) : Eigen::Vector3d(0, 0, 0);
  rigid.position_ned_m = center_ned_m - center_height_m(bucket_) * up_ned;
  rigid.velocity_ned_mps =
      velocity_ned_mps - center_height_m(bucket_) * rigid.angular_velocity_ned_radps.cross(up_ned);
  bucket_.handle_rad = 0;
  state_ = State::hanging;
}

void Cargo::let_go() {
  if (state_ == State::hanging) state_ = State::falling;
}

Landing Cargo::landing_on(const Footing& on) const {
  const Rigid& rigid = bucket_.rigid;
  const Eigen::Vector3d center_m = center_of_mass_ned_m();
  return land(bucket_, {on.up_ned(), Eigen::Vector3d::UnitZ(), axis_ned(),
                        rigid.velocity_at(center_m) - on.rigid.velocity_at(center_m),
                        rigid.angular_velocity_ned_radps - on.rigid.angular_velocity_ned_radps});
}

bool Cargo::would_stand(const Floor& floor) const {
  return landing_on(footing(floor)).stands;
}

void Cargo::touch_down(const Floor& floor) {
  const Footing on = footing(floor);
  deck_ = on.deck;
  if (on.deck < 0 && floor.water) {
    state_ = State::sunk;
    return;
  }
  const Rigid& rigid = bucket_.rigid;
  const Eigen::Vector3d center_m = center_of_mass_ned_m();
  const Eigen::Vector3d velocity_mps = rigid.velocity_at(center_m) - on.rigid.velocity_at(center_m);
  const Eigen::Vector3d in_floor_mps = on.rigid.ned_from_local.conjugate() * velocity_mps;
  const Landing landing = landing_on(on);
  if (!tipped_ && landing.stands) {
    settle(on);
  } else {
    lie_down(on, tipped_ ? axis_ned() : landing.falls_to);
    rolling_mps_ = in_floor_mps.head<2>() / 2;  // the other half goes into turning over
  }
  ride(floor);
}

void Cargo::topple(const Floor& floor, const Eigen::Vector3d& towards_ned) {
  const Footing on = footing_number(floor, deck_);
  lie_down(on, towards_ned);
  const Eigen::Vector3d away = on.rigid.ned_from_local.conjugate() * level_with(on, towards_ned);
  rolling_mps_ = push_mps * away.head<2>();
  ride(floor);
}

void Cargo::settle(const Footing& on) {
  state_ = State::standing;
  const Eigen::Quaterniond upright = Eigen::Quaterniond::FromTwoVectors(axis_ned(), on.up_ned());
  floor_from_bucket_ =
      (on.rigid.ned_from_local.conjugate() * upright * bucket_.rigid.ned_from_local).normalized();
  base_on_floor_m_ = on.rigid.to_local(bucket_.rigid.position_ned_m);
  base_on_floor_m_.z() = 0;
}

/// On its side: over the edge of its base, resting on base and rim.
void Cargo::lie_down(const Footing& on, const Eigen::Vector3d& towards_ned) {
  const bool fresh = !tipped_;
  const Eigen::Vector3d towards = level_with(on, towards_ned), up_ned = on.up_ned();
  const double slope = (bucket_.rim_radius_m - bucket_.base_radius_m) / bucket_.height_m;
  const Eigen::Vector3d axis = (towards + slope * up_ned).normalized();
  const Eigen::Quaterniond over = Eigen::Quaterniond::FromTwoVectors(axis_ned(), axis);
  floor_from_bucket_ =
      (on.rigid.ned_from_local.conjugate() * over * bucket_.rigid.ned_from_local).normalized();
  const Eigen::Vector3d base_ned_m =
      bucket_.rigid.position_ned_m + (fresh ? bucket_.base_radius_m : 0) * towards;
  base_on_floor_m_ = on.rigid.to_local(base_ned_m);
  base_on_floor_m_.z() = -bucket_.base_radius_m * axis.dot(towards);
  rolling_mps_.setZero();
  tipped_ = true;
  state_ = State::lying;
}

int Cargo::deck() const {
  return state_ == State::standing || state_ == State::lying ? deck_ : -1;
}

Eigen::Vector3d Cargo::center_of_mass_ned_m() const {
  return bucket_.rigid.position_ned_m + center_height_m(bucket_) * axis_ned();
}

Eigen::Vector3d Cargo::rim_center_ned_m() const {
  return bucket_.rigid.position_ned_m + bucket_.height_m * axis_ned();
}

Eigen::Vector3d Cargo::handle_apex_ned_m() const {
  return bucket_.rigid.to_ned({bucket_.handle_rise_m * std::sin(bucket_.handle_rad), 0,
                               -bucket_.height_m - bucket_.handle_rise_m * std::cos(bucket_.handle_rad)});
}

double Cargo::drop_of_center_m() const {
  return bucket_.handle_rise_m + bucket_.height_m - center_height_m(bucket_);
}

Footing Cargo::footing(const Floor& floor) const {
  return footing_below(floor, bucket_.rigid.position_ned_m);
}

double Cargo::clearance_m(const Floor& floor) const {
  const Footing below = footing(floor);
  if (below.deck < 0 && floor.water) return std::numeric_limits<double>::infinity();
  return below.height_of(lowest_ned_m(below.up_ned()));
}

/// Of the edges of base and rim.
Eigen::Vector3d Cargo::lowest_ned_m(const Eigen::Vector3d& up_ned) const {
  const Eigen::Vector3d axis = axis_ned(), across = -up_ned + up_ned.dot(axis) * axis;
  const double length = across.norm();
  const Eigen::Vector3d down_the_face =
      length > 0 ? Eigen::Vector3d(across / length) : Eigen::Vector3d(0, 0, 0);
  const Eigen::Vector3d base_m = bucket_.rigid.position_ned_m + bucket_.base_radius_m * down_the_face;
  const Eigen::Vector3d rim_m = rim_center_ned_m() + bucket_.rim_radius_m * down_the_face;
  return base_m.dot(up_ned) < rim_m.dot(up_ned) ? base_m : rim_m;
}

}  // namespace stevedore::world
