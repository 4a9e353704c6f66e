// Whether an ellipse of this frame is a mark followed so far: odds, in natural logarithms.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "geometry/detection.hpp"
#include "tracker_proc/mark_motion.hpp"

namespace stevedore {

/// Where a mark followed so far is expected in this frame, and what it looks like.
struct Expected {
  Ellipse ellipse;
  Eigen::Matrix2d centre_covariance_px2 = Eigen::Matrix2d::Zero();  ///< of its own motion
  double log_radius_variance = 0;
  double found_in_view = 0;          ///< probability of being found where the whole of it is in view, 0..1
  bool is_doubtful = false;          ///< seen too seldom to be sure that there is such a mark
  double unseen_s = 0;               ///< since it was last measured
  Label label = Label::unknown;      ///< unknown: not told yet
  std::optional<double> inner_edge;  ///< of a ring, as a share of the outer one
};

/// An ellipse of this frame.
struct Found {
  Ellipse ellipse;
  MarkMeasurement measurement;
  Label label = Label::unknown;
  std::optional<double> inner_edge;
};

/// What an unusable ellipse (not finite, no size, far outside any image) gives: nothing.
std::optional<Found> found_in(const Detection& detection);

std::optional<double> inner_edge_of(const Detection& detection);

/// How far two ellipses differ in form and direction, place and size taken away: 0 for equal ones. Distance
/// of two normal distributions (Givens and Shortt 1984) of unit mean radius; a circle's meaningless alpha
/// does not matter.
double form_distance(const Ellipse& one, const Ellipse& other);

/// How far in that sense a mark may have turned that was measured so long ago.
double form_sigma(double unseen_s);

/// Log likelihood of size, form, label and ring, 0 for equal ones. It never speaks for a pair: marks come in
/// sets that look alike, so that looking alike tells the same mark from a sibling not at all.
double log_likeness(const Expected& expected, const Found& found);

/// Log density (1/px^2) of finding a mark `off_px` from where it is expected with this covariance. Now and
/// then something jerks (a gust, a wheel on a kerb, a frame that is missing): then it may be farther, but not
/// as far as where a touching neighbour would be.
double log_place_density(const Eigen::Vector2d& off_px, const Eigen::Matrix2d& covariance_px2,
                         double radius_px);

/// Log density (1/px^2) of a mark not seen before, anywhere in a frame of this size.
double log_newcomer_density(const cv::Size& frame);

/// Probability of finding a mark `off_px` from where it is expected: less where the border cuts it, next to
/// nothing where its centre is outside.
double found_probability(const Expected& expected, const Eigen::Vector2d& off_px, const cv::Size& frame);

/// Costs of taking each found ellipse for each expected mark, relative to "the mark was missed and this is a
/// newcomer": below zero where taking it is the better explanation. Rows: expected, columns: found.
Eigen::MatrixXd association_costs(const std::vector<Expected>& expected, const std::vector<Found>& found,
                                  const cv::Size& frame);

}  // namespace stevedore
