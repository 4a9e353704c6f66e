// A pilot by script, who knows the truth: for films and for seeing the line at work before there is a
// mission.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "sim_proc/world/truth.hpp"
#include "sim_proc/world/velocity_command.hpp"

namespace stevedore::world {

/// Takes off, climbs to 12 m, searches over both platforms, then by turns descends over a circle of one
/// platform until the camera is 1 m over it, climbs, goes to the other platform, and so on without end. Never
/// faster than 3 m/s over ground, 1 m/s down; over a circle it keeps the platform's pace.
class ScriptedPilot {
 public:
  static constexpr double search_height_m = 12, transit_height_m = 8, low_height_m = 1;
  static constexpr double max_horizontal_mps = 3, max_up_mps = 1.5, max_down_mps = 1;
  static constexpr double max_acceleration_mps2 = 1.5;  ///< half of what the aircraft can

  /// Any number of times a second; time goes by truth.time_s.
  VelocityCommand fly(const Truth& truth);

 private:
  enum class Leg { take_off, search, go_over, descend, stay, climb };

  /// Where the camera is to be: over a point that moves with a platform, at a height over its circles.
  struct Goal {
    Eigen::Vector3d place_ned_m;
    Eigen::Vector3d velocity_ned_mps;
  };
  struct Sighting {
    double time_s = -1;
    Eigen::Vector3d middle_ned_m = Eigen::Vector3d::Zero();
    Eigen::Vector3d velocity_ned_mps = Eigen::Vector3d::Zero();
  };

  void look(const Truth& truth);
  void decide(const Truth& truth, const Goal& goal);
  [[nodiscard]] Goal goal(const Truth& truth) const;
  [[nodiscard]] Goal search_goal() const;
  [[nodiscard]] Goal circle_goal(const Truth& truth, double height_m) const;
  [[nodiscard]] VelocityCommand towards(const Goal& goal, const Truth& truth) const;
  void begin(Leg leg, double time_s);

  Leg leg_ = Leg::take_off;
  double leg_began_s_ = 0;
  int search_point_ = 0;
  int visit_ = 0;  ///< counts descents: even ones are over platform 0
  std::array<Sighting, 2> platforms_;
  Eigen::Vector3d velocity_ned_mps_ = Eigen::Vector3d::Zero();  ///< last commanded
  double last_s_ = 0;
};

}  // namespace stevedore::world
