// Rope, hook, and the bucket that hangs on it.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim_proc/world/cargo.hpp"
#include "sim_proc/world/dice.hpp"
#include "sim_proc/world/footing.hpp"
#include "sim_proc/world/grip.hpp"
#include "sim_proc/world/rope.hpp"

namespace stevedore::world {

/// Its jaws close on a handle only (see Grip); closed, they stay so until told to open, even when a bucket
/// that was badly taken has slipped off.
class Sling {
 public:
  /// A handle lifts out of the hook when the line swings further than this from upright: 45 deg, where the
  /// hook's throat opens towards the ground.
  static constexpr double slips_at_cosine = 0.7071;
  /// Of the handle in the hook: what was set down leaning has stood up before it is drawn up again.
  static constexpr double play_m = 0.03;
  /// A bucket that is lifted askew drags over the deck for so long before it may stand again.
  static constexpr double lift_off_s = 0.3;

  /// A handle that is taken from some centimetres above is drawn up to the hook at this speed.
  static constexpr double draw_up_mps = 0.1;

  /// Half a kilogram of hook with 50 cm2 to the wind; 1.5 kg of bucket with 900 cm2: at about 5 m/s.
  static constexpr double hook_drag_per_s = 0.03, bucket_drag_per_s = 0.15;

  Sling(std::uint64_t seed, const Eigen::Vector3d& anchor_ned_m, double rope_m);

  void command(bool close) { close_ = close; }
  void step(const Eigen::Vector3d& anchor_ned_m, const Eigen::Vector3d& wind_ned_mps, const Floor& floor,
            std::vector<Cargo>& cargoes, double step_s);

  [[nodiscard]] const Eigen::Vector3d& hook_ned_m() const { return hook_ned_m_; }
  [[nodiscard]] bool closed() const { return closed_; }
  [[nodiscard]] int carried() const { return carried_; }  ///< index into cargoes; -1: none
  [[nodiscard]] double load_n() const { return load_n_; }

 private:
  void open(Cargo* cargo);
  void carry(const Eigen::Vector3d& anchor_ned_m, const Eigen::Vector3d& wind_ned_mps, const Floor& floor,
             Cargo& cargo, double step_s);
  void meet_the_floor(const Eigen::Vector3d& anchor_ned_m, const Floor& floor, Cargo& cargo, double step_s);
  void lift(const Eigen::Vector3d& anchor_ned_m, Cargo& cargo, double step_s);
  void swing_empty(const Eigen::Vector3d& anchor_ned_m, const Eigen::Vector3d& wind_ned_mps,
                   const Floor& floor, double step_s);
  void reach_for(const std::vector<Cargo>& cargoes, double step_s);
  void take(int index, double share_of_limits, double missing_m);
  void lose(Cargo& cargo);

  Dice dice_;
  Rope rope_;
  double rope_m_;
  Grip grip_;
  Eigen::Vector3d hook_ned_m_;
  bool close_ = false;
  bool closed_ = false;
  int carried_ = -1;
  double missing_m_ = 0;  ///< between hook and handle when it was taken or set down, less what is drawn up
  double hung_s_ = 0;     ///< since it was lifted
  std::optional<double> slips_after_s_;
  double load_n_ = 0;
};

}  // namespace stevedore::world
