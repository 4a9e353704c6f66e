// Poses against what they should be: the truth of the world, or a second source of poses.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "geometry/camera.hpp"
#include "lcmtypes/channels.hpp"
#include "pose_proc/pose_settings.hpp"
#include "tools/evaluate_spread.hpp"

namespace stevedore {

/// Something that a pose can be of.
struct Mark {
  enum class Kind { circle, cargo };
  Kind kind = Kind::circle;
  std::string name;  ///< the same in every frame
  Eigen::Vector3d center_camera_m;
  Eigen::Vector3d normal_camera;  ///< unit, towards the camera
  double radius_m = 0;
  bool is_whole = false;  ///< wholly in the image and hidden by nothing

  /// Between its normal and the line of sight to its centre.
  [[nodiscard]] double theta_rad() const;
};
using MarksByTime = std::map<std::int64_t, std::vector<Mark>>;  ///< by capture time

/// As marks of TRUTH are named.
std::string name_of_circle(int platform, int slot);
MarksByTime marks_of(const std::vector<truth_t>& truth);
/// A second source of poses: its marks are named by its track ids.
MarksByTime marks_of(const std::vector<poses_t>& poses);

/// A measured pose beside its mark.
struct PoseSample {
  std::int64_t utime = 0;
  Mark::Kind kind = Mark::Kind::circle;
  std::string mark;    ///< its name
  double range_m = 0;  ///< these two as they should be
  double theta_rad = 0;
  double range_error_m = 0;  ///< positive: said to be farther away than it is
  double center_error_m = 0;
  bool has_two = false;              ///< solutions; of one alone none is the wrong one
  bool is_wrong = false;             ///< the other solution's normal is nearer to the mark's
  double probability = 1;            ///< of the chosen solution, as published
  std::optional<double> nees3;       ///< NEES / 3 of the right solution's centre; nothing: no covariance
  std::optional<double> nees3_with;  ///< the same with the errors that all poses of a flight share
};

/// One bin of published probabilities, for both solutions of each pose that has two.
struct ProbabilityBin {
  std::int64_t count = 0, right = 0;
  double sum = 0;  ///< of the probabilities
};

struct PoseComparison {
  std::vector<PoseSample> samples;
  std::int64_t frames = 0;             ///< with POSES and marks of the same capture time
  std::int64_t frames_alone = 0;       ///< with POSES only
  std::int64_t frames_unanswered = 0;  ///< with marks only, between the first POSES and the last
  std::int64_t poses = 0;              ///< measured, with a solution
  std::int64_t without_solution = 0;   ///< measured, but no pose could be told
  std::int64_t predicted = 0;          ///< carried on by the tracker; not compared
  std::int64_t ambiguous = 0;          ///< two marks fit about as well; not compared
  std::int64_t doubled = 0;            ///< another pose is nearer to the same mark; not compared
  std::int64_t of_nothing = 0;         ///< no mark is there
  std::int64_t other_size = 0;         ///< taken for a circle and is a cargo's rim, or the other way
  std::int64_t whole_circles = 0;      ///< seen whole, summed over the frames, also those without POSES
  std::int64_t whole_found = 0;        ///< of them, those with a pose
  std::int64_t marks = 0;              ///< that ever had a pose
  std::int64_t switches = 0;           ///< a mark has another track id than within the last 2 s
  std::int64_t after_exit = 0;         ///< the same after more than 2 s; allowed
  std::int64_t taken_over = 0;         ///< a track id that was another mark's before
  std::vector<ProbabilityBin> probabilities = std::vector<ProbabilityBin>(10);
};

/// What is added to the covariances for nees3_with.
struct CommonError {
  Pinhole camera;
  PoseSettings sigmas;
};

PoseComparison compare_poses(const std::vector<poses_t>& poses, const MarksByTime& marks,
                             const std::optional<CommonError>& common);

/// Difference between published probability and share of right ones, over the ten bins.
double calibration_error(const PoseComparison& comparison);

/// Errors of some of the samples.
struct PoseRow {
  std::string name;
  Spread range_m;
  Spread center_m;
  std::int64_t judged = 0;  ///< with two solutions, theta >= 4 deg: below, they are about the same
  std::int64_t wrong = 0;
  std::int64_t wrong_above_99 = 0;  ///< of them, those published with more than 0.99
  double nees3 = 0;                 ///< means; NaN: none
  double nees3_with = 0;
};

PoseRow row_of(std::string name, const std::vector<PoseSample>& samples);
/// Of those samples for which pick is true.
template <class Pick>
PoseRow row_of(std::string name, const std::vector<PoseSample>& samples, const Pick& pick) {
  std::vector<PoseSample> picked;
  for (const PoseSample& sample : samples)
    if (pick(sample)) picked.push_back(sample);
  return row_of(std::move(name), picked);
}

std::vector<PoseRow> rows_by_range(const PoseComparison& comparison, Mark::Kind kind);
std::vector<PoseRow> rows_by_theta(const PoseComparison& comparison);  ///< of circles
std::vector<PoseRow> rows_by_mark(const PoseComparison& comparison);

/// A position of the paper's Table 1.
struct TableOneRow {
  char image;
  double range_m;  ///< by Vicon
  double paper_error_m;
  PoseRow ours;  ///< circles within 10 % of that range
};
std::vector<TableOneRow> table_one(const PoseComparison& comparison);

}  // namespace stevedore
