// Which of the two circles that one ellipse allows is the real one: evidence, multiplied as Bayes has it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>

#include "geometry/attitude.hpp"
#include "pose_proc/circle_pose.hpp"
#include "pose_proc/expected_normal.hpp"
#include "pose_proc/pose_settings.hpp"

namespace stevedore {

/// What weighed most.
enum class ChosenBy { none, attitude, continuity, optical_axis };

/// What was believed of the same circle in its previous frame.
struct PreviousChoice {
  /// Of the two solutions, the chosen one first, in the camera frame of now (as far as the camera's turn is
  /// known).
  std::array<Eigen::Vector3d, 2> normal_camera;
  double probability = 1;  ///< that the first was right
  double elapsed_s = 1.0 / 30;
};

/// The laser: distance along its beam to whatever it hits, which need not be what the circle is painted on.
struct BeamRange {
  Eigen::Vector3d origin_camera_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d direction_camera = Eigen::Vector3d::UnitZ();  ///< unit
  double range_m = 0;
  double sigma_m = 0.05;
};

/// What is known besides the image.
struct PoseContext {
  std::optional<Gravity> gravity;
  std::optional<BeamRange> beam;
};

/// Where normals are expected: against gravity, give or take attitude and deck; without gravity against the
/// optical axis, since the camera is held roughly level.
ExpectedNormal expected_normal(const std::optional<Gravity>& gravity, const PoseSettings& settings);

/// What was believed in the previous frame, carried over by the likeness of the normals.
struct Carried {
  double log_odds = 0;  ///< of the first
  double share =
      1;  ///< of the belief; 0: the normals of then could be either one now, 1: each is one of them
};

/// Logarithms of first over second. now: what this frame says by itself.
struct LogOdds {
  double now = 0;
  std::optional<Carried> before;
  double elapsed_s = 0;  ///< since `before`
};

/// log-odds that the beam gives: it hits the circle's plane or anything else, with even chances.
double beam_log_odds(const std::array<CircleSolution, 2>& solutions, const BeamRange& beam);

/// What the previous frame gives.
Carried carried_over(const std::array<CircleSolution, 2>& solutions, const PreviousChoice& previous,
                     const PoseSettings& settings);

/// Probability of the first. Deck tilt and attitude error change slowly, so that the frames of one second
/// don't say the same thing thirty times: after the first, a frame's own evidence counts by the time that has
/// gone by, and by what of it was not carried over.
double probability_of(const LogOdds& odds);

/// What of it weighed most.
ChosenBy chosen_by(const LogOdds& odds, bool with_gravity);

}  // namespace stevedore
