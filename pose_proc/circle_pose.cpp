#include "pose_proc/circle_pose.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <utility>
#include <vector>

namespace stevedore {
namespace {

/// The eigenvalues below go with the squares of a and b: flatter than this, double precision mixes them up.
constexpr double flattest = 1e-6;

bool usable(const EllipseFit& fit, const Pinhole& camera, double radius_m) {
  return is_valid(fit.ellipse) && fit.ellipse.b_px > flattest * fit.ellipse.a_px &&
         fit.covariance.allFinite() && camera.fx_px > 0 && camera.fy_px > 0 && std::isfinite(radius_m) &&
         radius_m > 0;
}

/// An ellipse as its centre and the symmetric root of its shape, |root^-1 (x - centre)| = 1. Unlike (a, b,
/// alpha) this is smooth where the ellipse is a circle, and alpha means nothing there.
struct Shape {
  Eigen::Vector2d center_px;
  Eigen::Matrix2d root_px;
};

using Vector5d = Eigen::Matrix<double, 5, 1>;

Eigen::Matrix2d rotation(double angle_rad) {
  return Eigen::Rotation2Dd(angle_rad).toRotationMatrix();
}

Shape shape_of(const Ellipse& e) {
  const Eigen::Matrix2d axes = rotation(e.alpha_rad);
  return {{e.u_px, e.v_px}, axes * Eigen::Vector2d(e.a_px, e.b_px).asDiagonal() * axes.transpose()};
}

/// The shape changed by a small step in (u, v, a, b, alpha); exact to first order in the step.
Shape moved(const Shape& shape, const Ellipse& e, const Vector5d& step) {
  const double shear = (e.a_px - e.b_px) * step[4];
  Eigen::Matrix2d change;  // of the root, along the ellipse's own axes
  change << step[2], shear, shear, step[3];
  const Eigen::Matrix2d axes = rotation(e.alpha_rad);
  return {shape.center_px + step.head<2>(), shape.root_px + axes * change * axes.transpose()};
}

/// The cone of rays through the ellipse: x^T Q x = 0 on it, < 0 inside, for directions x in the camera frame.
Eigen::Matrix3d cone_through(const Shape& shape, const Pinhole& camera) {
  const Eigen::Matrix2d inverse = shape.root_px.inverse();
  Eigen::Matrix<double, 2, 3> to_unit_circle;
  to_unit_circle.col(0) = inverse.col(0) * camera.fx_px;
  to_unit_circle.col(1) = inverse.col(1) * camera.fy_px;
  to_unit_circle.col(2) = inverse * (Eigen::Vector2d(camera.cx_px, camera.cy_px) - shape.center_px);
  Eigen::Matrix3d cone = to_unit_circle.transpose() * to_unit_circle;
  cone(2, 2) -= 1;
  return cone;
}

/// Both circles of unit radius on a cone: centre = middle +- side, normal = normal_middle +- normal_side.
/// The sums go smoothly through the case where the two are one; the sides, there zero, do not.
struct CirclePair {
  Eigen::Vector3d middle, side, normal_middle, normal_side;

  void exchange() {
    side = -side;
    normal_side = -normal_side;
  }
  [[nodiscard]] Eigen::Vector3d center(double sign) const { return middle + sign * side; }
  [[nodiscard]] Eigen::Vector3d normal(double sign) const { return normal_middle + sign * normal_side; }
};

/// With eigenvalues l1 >= l2 > 0 > l3 of the cone and their eigenvectors, the planes that cut it in a circle
/// have the normals g e1 -+ h e3, g^2 = (l1 - l2) / (l1 - l3), h^2 = (l2 - l3) / (l1 - l3) (Kanatani and Liu
/// 1993); the centre is the pole of that plane's vanishing line, along Q^-1 normal, scaled to the unit
/// circle.
CirclePair circles_on(const Eigen::Matrix3d& cone) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> eigen(cone);
  const Eigen::Vector3d& l = eigen.eigenvalues();  // ascending: l3, l2, l1
  const double g = std::sqrt((l[2] - l[1]) / (l[2] - l[0])), h = std::sqrt((l[1] - l[0]) / (l[2] - l[0]));
  const double narrowness = std::sqrt(-l[2] / l[0]);
  Eigen::Vector3d axis = eigen.eigenvectors().col(0);
  if (axis.z() < 0) axis = -axis;  // the half of the cone in front of the camera
  const Eigen::Vector3d across = eigen.eigenvectors().col(2);
  return {h * narrowness * axis, g / narrowness * across, -h * axis, g * across};
}

/// The shapes one standard deviation away, to either side, along five independent directions.
std::array<Shape, 10> neighbours(const EllipseFit& fit) {
  const Eigen::LDLT<EllipseCovariance> factor(fit.covariance);
  const EllipseCovariance lower = factor.matrixL();
  const Vector5d sigma = factor.vectorD().cwiseMax(0).cwiseSqrt();
  const EllipseCovariance root = factor.transpositionsP().transpose() * (lower * sigma.asDiagonal());
  const Shape shape = shape_of(fit.ellipse);
  std::array<Shape, 10> out;
  for (int i = 0; i < 5; ++i) {
    out[static_cast<std::size_t>(2 * i)] = moved(shape, fit.ellipse, root.col(i));
    out[static_cast<std::size_t>(2 * i + 1)] = moved(shape, fit.ellipse, -root.col(i));
  }
  return out;
}

/// Adds each solution's spread over the neighbours: first-order propagation wherever the closed form is
/// smooth on the scale of the noise. Where the two solutions merge its derivative is infinite while the
/// spread stays finite; there the noise drives the solutions apart even if the circle faces the camera, so
/// that the whole way back to their middle counts as error too.
bool propagate(const EllipseFit& fit, const Pinhole& camera, double radius_m, const CirclePair& pair,
               const std::array<double, 2>& signs, std::array<CircleSolution, 2>& solutions) {
  const Eigen::Matrix3d split = pair.normal_side * pair.normal_side.transpose();
  double split_variance = 0;  // of |split| = g^2, in which the noise is nearly Gaussian
  for (const Shape& neighbour : neighbours(fit)) {
    if (!(neighbour.root_px.determinant() > 0 && neighbour.root_px.trace() > 0)) return false;
    CirclePair other = circles_on(cone_through(neighbour, camera));
    if (other.normal_side.dot(pair.normal_side) < 0) other.exchange();  // e1 has no sign: nearest to nearest
    split_variance += (other.normal_side * other.normal_side.transpose() - split).squaredNorm() / 2;
    for (std::size_t s = 0; s < 2; ++s) {
      const Eigen::Vector3d offset_m = radius_m * (other.center(signs[s]) - pair.center(signs[s]));
      const Eigen::Vector3d turn = other.normal(signs[s]) - pair.normal(signs[s]);
      solutions[s].covariance_m2 += offset_m * offset_m.transpose() / 2;
      solutions[s].normal_variance_rad2 += turn.squaredNorm() / 4;
    }
  }
  if (!(split_variance > 0)) return true;
  const double merged = std::exp(-split.squaredNorm() / (2 * split_variance));
  for (CircleSolution& solution : solutions) {
    solution.covariance_m2 += merged * radius_m * radius_m * pair.side * pair.side.transpose();
    solution.normal_variance_rad2 += merged * pair.normal_side.squaredNorm() / 2;
  }
  return true;
}

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

std::optional<std::array<CircleSolution, 2>> conic_pose(const EllipseFit& fit, const Pinhole& camera,
                                                        double radius_m) {
  if (!usable(fit, camera, radius_m)) return std::nullopt;
  const CirclePair pair = circles_on(cone_through(shape_of(fit.ellipse), camera));
  std::array<double, 2> signs{1, -1};
  if (pair.normal_side.z() > 0) std::swap(signs[0], signs[1]);  // first the one more against the view
  std::array<CircleSolution, 2> solutions;
  for (std::size_t s = 0; s < 2; ++s)
    solutions[s] = {radius_m * pair.center(signs[s]), pair.normal(signs[s]), Eigen::Matrix3d::Zero(), 0};
  if (!propagate(fit, camera, radius_m, pair, signs, solutions)) return std::nullopt;
  for (const CircleSolution& solution : solutions)
    if (!solution.center_camera_m.allFinite() || !solution.covariance_m2.allFinite()) return std::nullopt;
  return solutions;
}

std::optional<CircleSolution> four_point_pose(const EllipseFit& fit, const Pinhole& camera, double radius_m) {
  if (!usable(fit, camera, radius_m)) return std::nullopt;
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
  return CircleSolution{
      center_camera_m, normal_camera, covariance.bottomRightCorner<3, 3>(),
      (normal_by_turn.transpose() * covariance.topLeftCorner<3, 3>() * normal_by_turn).trace() / 2};
}

}  // namespace stevedore
