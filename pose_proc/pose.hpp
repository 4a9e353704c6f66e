// From the marks of one frame to the poses of their circles: method, radius, ring, deck and choice in one
// call.
#pragma once

#include <optional>
#include <vector>

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

enum class NoPose { none, radius_unknown, not_solvable, another_size };

/// Short text for people and messages; empty for none.
const char* reason_text(NoPose reason);

struct CirclePose {
  std::vector<PoseSolution>
      solutions;        ///< the chosen one first; two by conic, one by four_point, none on failure
  double radius_m = 0;  ///< assumed; 0 when unknown
  Label label =
      Label::unknown;  ///< the mark's own; unknown for a circle of another size than the deck's others
  ChosenBy chosen_by = ChosenBy::none;
  NoPose reason = NoPose::none;  ///< why there is no solution
  int deck = -1;  ///< marks of one frame with the same number were solved on one plane; -1: alone
};

/// One mark of a frame, in pixels of the camera given.
struct MarkImage {
  EllipseFit outer;
  std::optional<EllipseFit> inner;  ///< of a painted ring
  Label label = Label::unknown;
  std::optional<PreviousChoice> previous;
  double coverage = 1;       ///< share of the outer edge that was found
  bool holds_cargo = false;  ///< of a circle: a cargo's rim was found in it
  bool measured = true;  ///< false: where the tracker thinks it is; it gets a pose and has no say in others'
};

/// The radius a label stands for; nothing for unknown.
std::optional<double> radius_of(Label label, const PoseSettings& settings);

/// The poses of all marks of one frame, in their order. Painted circles that agree on a plane share it: their
/// centres and normals are then those of the joint fit, whose error they have in common.
std::vector<CirclePose> estimate_poses(const std::vector<MarkImage>& marks, const Pinhole& camera,
                                       const PoseContext& context, const PoseSettings& settings);

/// One mark by itself.
CirclePose estimate_pose(const MarkImage& mark, const Pinhole& camera, const PoseContext& context,
                         const PoseSettings& settings);

}  // namespace stevedore
