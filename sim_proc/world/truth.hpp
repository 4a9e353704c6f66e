// What is really there: for evaluation, and for the pilot that is part of the simulator.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "geometry/ellipse.hpp"
#include "sim_proc/world/rigid.hpp"

namespace stevedore::world {

struct CircleTruth {
  int platform = 0;  ///< 0, 1; 2: the take-off pad
  int slot = 0;
  bool occupied = false;  ///< a bucket stands in it
  Eigen::Vector3d center_ned_m;
  Eigen::Vector3d normal_ned;  ///< up from the deck
  double radius_m = 0;
  std::optional<Ellipse> outline;  ///< in the image as given; nothing: not in view
  double visible_share = 0;
};

struct CargoTruth {
  int index = 0;
  int platform = -1;             ///< that it is on; -1: on none
  int slot = -1;                 ///< whose circle its base's centre is in; -1: none
  Eigen::Vector3d center_ned_m;  ///< of the rim
  Eigen::Vector3d axis_ned;      ///< unit, from base to rim
  double radius_m = 0;           ///< of the rim
  bool on_hook = false;
  bool tipped = false;
};

struct Truth {
  double time_s = 0;
  std::vector<CircleTruth> circles;
  std::vector<CargoTruth> cargoes;
  Rigid aircraft;
  Rigid camera;
  Eigen::Vector3d hook_ned_m;
  double off_level_rad = 0;  ///< angle between optical axis and gravity
};

}  // namespace stevedore::world
