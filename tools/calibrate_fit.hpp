// The lens that explains the corners of all views, how sure it is, and whether a given lens explains new
// ones.
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "geometry/camera_model.hpp"
#include "tools/calibrate_board.hpp"

namespace stevedore {

/// fx, fy, cx, cy, then the coefficients: the order of every vector and matrix of parameters here.
std::vector<std::string> parameter_names(const CameraModel& camera);
Eigen::VectorXd parameters(const CameraModel& camera);

/// A view as a lens explains it.
struct FittedView {
  View view;
  double rms_px = 0;                   ///< of the distances between corners seen and projected
  std::vector<cv::Point2f> misses_px;  ///< seen - projected, corner by corner
  Eigen::Vector3d normal;              ///< of the board, in the camera frame, towards the camera
};

struct Fit {
  CameraModel camera;
  double rms_px = 0;
  std::vector<FittedView> views;
  std::size_t corners = 0;
  /// Of parameters(): the scatter of the residuals carried through the fit, poses of the board eliminated. A
  /// bent board or a lens of another kind is not in it.
  Eigen::MatrixXd covariance;
};

/// Corners of a sharp board are found to 0.1 px or better. Where no lens of a kind leaves less than this, the
/// lens is of another kind or the board is not flat.
constexpr double most_rms_px = 0.3;

/// At least `fewest_views`, of images of this size. Throws std::runtime_error in words where no lens fits.
constexpr std::size_t fewest_views = 8;
Fit fit(const Board& board, const std::vector<View>& views, const cv::Size& image_px, Distortion lens);

struct RefusedView {
  std::string name;
  Refusal refusal;
};

/// The same without the views whose residual sticks out, which go to `refused`.
Fit fit_without_outliers(const Board& board, std::vector<View> views, const cv::Size& image_px,
                         Distortion lens, std::vector<RefusedView>& refused);

struct Check {
  Fit as_it_is;  ///< the given lens on these views; its covariance is what they could say by themselves
  Eigen::VectorXd better;    ///< parameters that would fit these views best
  double free_rms_px = 0;    ///< what would be left with them
  double systematic_px = 0;  ///< rms of the part of the residuals that the given lens makes
  double allowed_px = 0;     ///< as much of it is none, or does no harm
  [[nodiscard]] bool fits() const { return systematic_px <= allowed_px && free_rms_px <= most_rms_px; }
};

Check check(const Board& board, const std::vector<View>& views, const CameraModel& camera);

}  // namespace stevedore
