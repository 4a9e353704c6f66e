// Which of the two circles that one ellipse allows is the real one.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "geometry/attitude.hpp"
#include "pose_proc/circle_pose.hpp"
#include "pose_proc/pose_settings.hpp"

namespace stevedore {

enum class ChosenBy { none, attitude, continuity, optical_axis };

/// What was chosen for the same circle in its previous frame.
struct PreviousChoice {
  Eigen::Vector3d normal_camera;  ///< in the camera frame of now, if the camera's turn is known
  double probability = 1;         ///< of having been right
};

struct SolutionChoice {
  std::array<CircleSolution, 2> solutions;  ///< the chosen one first
  std::array<double, 2> probability;        ///< of each being right, given that one of them is
  ChosenBy chosen_by = ChosenBy::none;
};

/// The best evidence at hand decides, the first of: gravity (the circle lies on a roughly level deck), the
/// previous choice, the optical axis (the camera is held roughly level). Each says where the normal is
/// expected and how far off it may be; the probabilities follow from Gaussian likelihoods of the two angles.
SolutionChoice choose_solution(const std::array<CircleSolution, 2>& solutions,
                               const std::optional<Gravity>& gravity,
                               const std::optional<PreviousChoice>& previous, const PoseSettings& settings);

}  // namespace stevedore
