// A bucket's life: it stands on a deck and moves with it, hangs, falls, lands, tips, rolls, sinks.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstddef>
#include <vector>

#include "sim_proc/world/footing.hpp"
#include "sim_proc/world/scene.hpp"
#include "sim_proc/world/tip_over.hpp"

namespace stevedore::world {

class Cargo {
 public:
  static constexpr double mass_kg = 1.5;
  static constexpr double rolling_friction_mps2 = 1;  ///< of thin steel on paint and grit, about a tenth of g

  enum class State { standing, lying, falling, hanging, sunk };

  /// Upright on deck number `deck` at this place and heading; `look` gives sizes and surfaces.
  Cargo(const Bucket& look, int deck, const Eigen::Vector2d& base_deck_m, double heading_rad,
        const Floor& floor);

  /// Moves it on by itself, unless it hangs.
  void step(const Floor& floor, double step_s);

  /// Hung up by its handle: where the rope has its centre of mass, its axis along the line.
  void hang(const Eigen::Vector3d& center_ned_m, const Eigen::Vector3d& velocity_ned_mps,
            const Eigen::Vector3d& up_ned, double step_s);
  void let_go();  ///< of one that hangs: it falls
  /// Whether it would stay on its base if it were left to itself on the floor that it touches.
  [[nodiscard]] bool would_stand(const Floor& floor) const;
  /// It touches the floor: it stands or lies, and State says which.
  void touch_down(const Floor& floor);
  /// Another one stood in the way: it falls to this side.
  void topple(const Floor& floor, const Eigen::Vector3d& towards_ned);

  [[nodiscard]] const Bucket& bucket() const { return bucket_; }
  [[nodiscard]] State state() const { return state_; }
  [[nodiscard]] bool tipped() const { return tipped_; }
  [[nodiscard]] int deck() const;  ///< on which it stands or lies; -1: none
  [[nodiscard]] Eigen::Vector3d axis_ned() const {
    return bucket_.rigid.ned_from_local * -Eigen::Vector3d::UnitZ();
  }
  [[nodiscard]] Eigen::Vector3d center_of_mass_ned_m() const;
  [[nodiscard]] Eigen::Vector3d rim_center_ned_m() const;
  [[nodiscard]] Eigen::Vector3d handle_apex_ned_m() const;
  /// From the apex of its upright handle to its centre of mass.
  [[nodiscard]] double drop_of_center_m() const;
  [[nodiscard]] Footing footing(const Floor& floor) const;  ///< what is below it
  /// Of its lowest point over what is below it; of one over water: infinite.
  [[nodiscard]] double clearance_m(const Floor& floor) const;

 private:
  void ride(const Floor& floor);
  void roll(const Floor& floor, double step_s);
  void fall(const Floor& floor, double step_s);
  void settle(const Footing& on);
  void lie_down(const Footing& on, const Eigen::Vector3d& towards_ned);
  [[nodiscard]] Landing landing_on(const Footing& on) const;
  [[nodiscard]] Eigen::Vector3d lowest_ned_m(const Eigen::Vector3d& up_ned) const;

  Bucket bucket_;
  State state_ = State::standing;
  bool tipped_ = false;
  int deck_ = -1;
  Eigen::Vector3d base_on_floor_m_ = Eigen::Vector3d::Zero();  ///< in the axes of what it is on
  Eigen::Quaterniond floor_from_bucket_ = Eigen::Quaterniond::Identity();
  Eigen::Vector2d rolling_mps_ = Eigen::Vector2d::Zero();  ///< over what it lies on
};

/// One has just come to stand: where it stands on or in another, it topples to the side away from that.
void keep_apart(std::vector<Cargo>& cargoes, std::size_t landed, const Floor& floor);

}  // namespace stevedore::world
