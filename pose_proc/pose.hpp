// From one detection to the pose of its circle: method, radius and choice between solutions in one call.
#pragma once

#include <optional>
#include <vector>

#include "geometry/attitude.hpp"
#include "geometry/camera.hpp"
#include "geometry/detection.hpp"
#include "pose_proc/circle_pose.hpp"
#include "pose_proc/pose_settings.hpp"
#include "pose_proc/solution_choice.hpp"

namespace stevedore {

struct PoseSolution {
  CircleSolution circle;
  double probability = 0;
};

enum class NoPose { none, radius_unknown, not_solvable };

/// Short text for people and messages; empty for none.
const char* reason_text(NoPose reason);

struct CirclePose {
  std::vector<PoseSolution>
      solutions;        ///< the chosen one first; two by conic, one by four_point, none on failure
  double radius_m = 0;  ///< assumed; 0 when unknown
  ChosenBy chosen_by = ChosenBy::none;
  NoPose reason = NoPose::none;  ///< why there is no solution
};

/// The radius a label stands for; nothing for unknown.
std::optional<double> radius_of(Label label, const PoseSettings& settings);

/// Pose from the detection's outer ellipse, in pixels of the camera given.
CirclePose estimate_pose(const EllipseFit& outer, Label label, const Pinhole& camera,
                         const std::optional<Gravity>& gravity, const std::optional<PreviousChoice>& previous,
                         const PoseSettings& settings);

}  // namespace stevedore
