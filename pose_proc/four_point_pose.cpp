#include "pose_proc/circle_pose.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <vector>

namespace stevedore {
namespace {

using ImagePoints = std::array<cv::Point2d, 4>;

/// Step 1 of Algorithm 3: m1 to m4.
ImagePoints vertexes(const Ellipse& e) {
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad), a = e.a_px, b = e.b_px;
  return {{{e.u_px + a * c, e.v_px + a * s},
           {e.u_px - b * s, e.v_px + b * c},
           {e.u_px - a * c, e.v_px - a * s},
           {e.u_px + b * s, e.v_px - b * c}}};
}

/// d(m1, ..., m4) / d(u, v, a, b, alpha), rows m1.u, m1.v, m2.u, ...
Eigen::Matrix<double, 8, 5> vertex_jacobian(const Ellipse& e) {
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad), a = e.a_px, b = e.b_px;
  Eigen::Matrix<double, 8, 5> jacobian;
  jacobian << 1, 0, c, 0, -a * s,  //
      0, 1, s, 0, a * c,           //
      1, 0, 0, -s, -b * c,         //
      0, 1, 0, c, -b * s,          //
      1, 0, -c, 0, a * s,          //
      0, 1, -s, 0, -a * c,         //
      1, 0, 0, s, b * c,           //
      0, 1, 0, -c, b * s;
  return jacobian;
}

template <int rows, int columns>
Eigen::Matrix<double, rows, columns> block_of(const cv::Mat& matrix) {
  return Eigen::Map<const Eigen::Matrix<double, rows, Eigen::Dynamic, Eigen::RowMajor>>(matrix.ptr<double>(),
                                                                                        rows, matrix.cols)
      .template leftCols<columns>();
}

/// Covariance of the pose (rotation vector, centre) that minimises the distances of the four reprojected
/// points.
Eigen::Matrix<double, 6, 6> pose_covariance(const EllipseFit& fit,
                                            const Eigen::Matrix<double, 8, 6>& by_pose) {
  const Eigen::Matrix<double, 6, 5> by_ellipse =
      (by_pose.transpose() * by_pose).ldlt().solve(by_pose.transpose() * vertex_jacobian(fit.ellipse));
  return by_ellipse * fit.covariance * by_ellipse.transpose();
}

}  // namespace

std::optional<CircleSolution> four_point_pose(const EllipseFit& fit, const Pinhole& camera, double radius_m) {
  if (!can_be_posed(fit, camera, radius_m)) return std::nullopt;
  // Step 2. m1 to m4 go round clockwise as seen; these go round the other way about +Z. So +Z comes towards
  // the camera: that is the axis convention in which the paper's (0, -r, 0) belongs to m2. Its r is the
  // radius.
  const double r = radius_m;
  const std::array<cv::Point3d, 4> circle{{{r, 0, 0}, {0, -r, 0}, {-r, 0, 0}, {0, r, 0}}};
  const cv::Matx33d intrinsics(camera.fx_px, 0, camera.cx_px, 0, camera.fy_px, camera.cy_px, 0, 0, 1);
  cv::Vec3d turn, center_m;
  if (!cv::solvePnP(circle, vertexes(fit.ellipse), intrinsics, cv::noArray(), turn, center_m))
    return std::nullopt;
  if (!(std::isfinite(cv::norm(center_m)) && center_m[2] > 0)) return std::nullopt;

  std::vector<cv::Point2d> reprojected;
  cv::Mat by_pose, by_turn;
  cv::projectPoints(circle, turn, center_m, intrinsics, cv::noArray(), reprojected, by_pose);
  const Eigen::Matrix<double, 6, 6> covariance = pose_covariance(fit, block_of<8, 6>(by_pose));
  if (!covariance.allFinite() || (covariance.diagonal().array() < 0).any()) return std::nullopt;
  cv::Matx33d camera_from_circle;
  cv::Rodrigues(turn, camera_from_circle, by_turn);  // by_turn: 3 x 9, a column for each entry, row by row
  const Eigen::Matrix<double, 3, 9> turned = block_of<3, 9>(by_turn);
  Eigen::Matrix3d normal_by_turn;
  normal_by_turn << turned.col(2), turned.col(5), turned.col(8);
  const Eigen::Vector3d center_camera_m(center_m[0], center_m[1], center_m[2]);
  Eigen::Vector3d normal_camera(camera_from_circle(0, 2), camera_from_circle(1, 2), camera_from_circle(2, 2));
  if (normal_camera.dot(center_camera_m) > 0)
    normal_camera = -normal_camera;  // edge on, its error may tip it over
  return CircleSolution{center_camera_m, normal_camera, covariance.bottomRightCorner<3, 3>(),
                        normal_by_turn.transpose() * covariance.topLeftCorner<3, 3>() * normal_by_turn};
}

}  // namespace stevedore
