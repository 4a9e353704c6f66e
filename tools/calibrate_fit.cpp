#include "tools/calibrate_fit.hpp"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/calib3d.hpp>
#include <opencv2/core/eigen.hpp>
#include <optional>
#include <stdexcept>

#include "geometry/lens.hpp"

namespace stevedore {
namespace {

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr int steps = 100;
constexpr double converged = 1e-10;  ///< of the sum of squares: far below what one corner's noise adds

/// The scatter of a view's rms over 20 corners is 1 / sqrt(80) = 11 %; near and far, steep and flat boards
/// differ by half. Below the least a view harms nothing.
constexpr double outlier_factor = 2.5, outlier_least_px = 0.15;

/// Of the misfit of a given lens. Harmless: the detector's ellipses are good to 0.05 px (docs/results.md).
/// Chance: chi squared of nine parameters, of a thousand right files one has more.
constexpr double harmless_px = 0.05, chance = 27.9;

std::vector<cv::Point3f> board_points(const Board& board, const View& view) {
  std::vector<cv::Point3f> points;
  for (const int id : view.ids) points.push_back(board.point_m(id));
  return points;
}

/// Rotation vector, then translation, of the board in the camera frame, as OpenCV has them.
struct Pose {
  cv::Vec3d turn, place_m;
};

cv::Matx33d matrix_of(const Pinhole& p) {
  return {p.fx_px, 0, p.cx_px, 0, p.fy_px, p.cy_px, 0, 0, 1};
}

/// A view's residuals, and how its projection follows lens and pose.
struct Linear {
  Eigen::VectorXd miss;     ///< seen - projected; u and v by turns
  Eigen::MatrixXd by_lens;  ///< columns as parameters()
  Eigen::MatrixXd by_pose;  ///< six columns
};

Linear linear(const Board& board, const View& view, const CameraModel& camera, const Pose& pose) {
  const auto points = board_points(board, view);
  std::vector<cv::Point2f> projected;
  std::vector<cv::Point3d> exact(points.begin(), points.end());
  std::vector<cv::Point2d> pixels;
  cv::Mat jacobian;
  const auto n = static_cast<Eigen::Index>(points.size());
  const auto lenses = static_cast<Eigen::Index>(4 + camera.coefficients.size());
  const auto more = static_cast<Eigen::Index>(camera.coefficients.size());
  Linear out{Eigen::VectorXd(2 * n), Eigen::MatrixXd(2 * n, lenses), Eigen::MatrixXd(2 * n, 6)};
  Eigen::MatrixXd j;
  if (camera.distortion == Distortion::equidistant) {  // f, c, k, turn, place, skew
    cv::fisheye::projectPoints(exact, pixels, pose.turn, pose.place_m, matrix_of(camera.given),
                               camera.coefficients, 0, jacobian);
    cv::cv2eigen(jacobian, j);
    out.by_lens = j.leftCols(lenses);
    out.by_pose = j.middleCols(lenses, 6);
  } else {  // turn, place, f, c, k
    cv::projectPoints(exact, pose.turn, pose.place_m, matrix_of(camera.given), camera.coefficients, pixels,
                      jacobian);
    cv::cv2eigen(jacobian, j);
    out.by_pose = j.leftCols(6);
    out.by_lens.leftCols(4) = j.middleCols(6, 4);
    out.by_lens.rightCols(more) = j.middleCols(10, more);
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto at = static_cast<std::size_t>(i);
    out.miss[2 * i] = view.corners_px[at].x - pixels[at].x;
    out.miss[2 * i + 1] = view.corners_px[at].y - pixels[at].y;
  }
  return out;
}

/// The pose that the lens gives a view, to start from.
Pose pose_of(const Board& board, const View& view, const CameraModel& camera) {
  std::vector<cv::Point3f> points;
  std::vector<cv::Point2d> rays;
  for (std::size_t i = 0; i < view.ids.size(); ++i) {
    const auto ray = unproject(camera, {view.corners_px[i].x, view.corners_px[i].y});
    if (!ray) continue;  // beyond where the model has an inverse
    points.push_back(board.point_m(view.ids[i]));
    rays.emplace_back(ray->point.x(), ray->point.y());
  }
  Pose pose;
  if (points.size() < 4 || !cv::solvePnP(points, rays, cv::Matx33d::eye(), cv::noArray(), pose.turn,
                                         pose.place_m, false, cv::SOLVEPNP_IPPE))
    throw std::runtime_error(view.name + ": the lens gives the board no pose");
  return pose;
}

/// The least squares of all views' residuals over lens and poses, the poses eliminated (Schur's complement).
class Adjustment {
 public:
  Adjustment(const Board& board, const std::vector<View>& views, CameraModel camera, std::vector<Pose> poses)
      : board_(&board), views_(&views), camera_(std::move(camera)), poses_(std::move(poses)) {
    linearise();
  }

  /// Gauss and Newton's steps, damped as Levenberg's where one leads uphill.
  void solve(bool with_lens) {
    double damping = 0;
    for (int step = 0; step < steps; ++step) {
      Adjustment next = *this;
      next.move(with_lens, damping);
      if (!(next.squares_ < squares_)) {
        if (squares_ - next.squares_ > -converged * squares_) return;
        damping = damping == 0 ? 1e-4 : damping * 10;
        continue;
      }
      const bool done = squares_ - next.squares_ < converged * squares_;
      *this = std::move(next);
      damping /= 10;
      if (done) return;
    }
  }

  [[nodiscard]] const CameraModel& camera() const { return camera_; }
  [[nodiscard]] double squares() const { return squares_; }
  [[nodiscard]] double noise_variance(bool with_lens) const {
    Eigen::Index freedom = with_lens ? -static_cast<Eigen::Index>(4 + camera_.coefficients.size()) : 0;
    for (const auto& v : linear_) freedom += v.miss.size() - 6;
    return squares_ / static_cast<double>(std::max<Eigen::Index>(1, freedom));
  }

  [[nodiscard]] Fit result(double variance) const {
    Fit fit;
    fit.camera = camera_;
    for (std::size_t i = 0; i < views_->size(); ++i) {
      const Eigen::VectorXd& miss = linear_[i].miss;
      FittedView v{(*views_)[i], rms(miss.squaredNorm(), (*views_)[i].ids.size()), {}, {}};
      for (Eigen::Index c = 0; c < miss.size(); c += 2)
        v.misses_px.emplace_back(static_cast<float>(miss[c]), static_cast<float>(miss[c + 1]));
      cv::Matx33d turn;
      cv::Rodrigues(poses_[i].turn, turn);
      v.normal = Eigen::Vector3d(turn(0, 2), turn(1, 2), turn(2, 2));
      const auto& place = poses_[i].place_m;
      if (v.normal.dot(Eigen::Vector3d(place[0], place[1], place[2])) > 0) v.normal = -v.normal;
      fit.views.push_back(std::move(v));
      fit.corners += (*views_)[i].ids.size();
    }
    fit.rms_px = rms(squares_, fit.corners);
    const Eigen::MatrixXd information = reduced(0).information;
    fit.covariance = variance * information.ldlt().solve(
                                    Eigen::MatrixXd::Identity(information.rows(), information.cols()));
    return fit;
  }

  static double rms(double squares, std::size_t corners) {
    return std::sqrt(std::max(0.0, squares) / static_cast<double>(std::max<std::size_t>(1, corners)));
  }

 private:
  void linearise() {
    squares_ = 0;
    linear_.clear();
    for (std::size_t i = 0; i < views_->size(); ++i) {
      linear_.push_back(linear(*board_, (*views_)[i], camera_, poses_[i]));
      squares_ += linear_.back().miss.squaredNorm();
    }
  }

  /// What is left of the normal equations for the lens once each view's pose follows it.
  struct Reduced {
    Eigen::MatrixXd information;
    Eigen::VectorXd gradient;
  };
  [[nodiscard]] Reduced reduced(double damping) const {
    const auto count = static_cast<Eigen::Index>(4 + camera_.coefficients.size());
    Reduced r{Eigen::MatrixXd::Zero(count, count), Eigen::VectorXd::Zero(count)};
    for (const Linear& v : linear_) r.information += v.by_lens.transpose() * v.by_lens;
    r.information.diagonal() *= 1 + damping;
    for (const Linear& v : linear_) {
      const Eigen::MatrixXd cross = v.by_lens.transpose() * v.by_pose;
      const auto own = damped_own(v, damping).ldlt();
      r.information -= cross * own.solve(cross.transpose());
      r.gradient += v.by_lens.transpose() * v.miss - cross * own.solve(v.by_pose.transpose() * v.miss);
    }
    return r;
  }

  static Matrix6d damped_own(const Linear& v, double damping) {
    Matrix6d own = v.by_pose.transpose() * v.by_pose;
    own.diagonal() *= 1 + damping;
    return own;
  }

  void move(bool with_lens, double damping) {
    Eigen::VectorXd lens = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(4 + camera_.coefficients.size()));
    if (with_lens) {
      const Reduced r = reduced(damping);
      lens = r.information.ldlt().solve(r.gradient);
    }
    for (std::size_t i = 0; i < views_->size(); ++i) {
      const Linear& v = linear_[i];
      const Vector6d pose =
          damped_own(v, damping).ldlt().solve(v.by_pose.transpose() * (v.miss - v.by_lens * lens));
      for (int k = 0; k < 3; ++k) {
        poses_[i].turn[k] += pose[k];
        poses_[i].place_m[k] += pose[k + 3];
      }
    }
    Pinhole& p = camera_.given;
    p.fx_px += lens[0];
    p.fy_px += lens[1];
    p.cx_px += lens[2];
    p.cy_px += lens[3];
    for (std::size_t k = 0; k < camera_.coefficients.size(); ++k)
      camera_.coefficients[k] += lens[static_cast<Eigen::Index>(k) + 4];
    linearise();
  }

  const Board* board_;
  const std::vector<View>* views_;
  CameraModel camera_;
  std::vector<Pose> poses_;
  std::vector<Linear> linear_;
  double squares_ = 0;
};

/// A lens of this kind that is `degrees` wide, without coefficients.
CameraModel plain_lens(Distortion lens, const cv::Size& image_px, double degrees) {
  const double half_rad = degrees / 2 * std::numbers::pi / 180, half_px = image_px.width / 2.0;
  const bool fisheye = lens == Distortion::equidistant;
  const double focal_px = half_px / (fisheye ? half_rad : std::tan(half_rad));
  CameraModel camera;
  camera.distortion = lens;
  camera.coefficients.assign(fisheye ? 4 : 5, 0);
  camera.given = {image_px.width,
                  image_px.height,
                  focal_px,
                  focal_px,
                  (image_px.width - 1) / 2.0,
                  (image_px.height - 1) / 2.0};
  return camera;
}

/// From the width, of a few, that explains the views best by itself. (cv::fisheye::calibrate, which finds its
/// start itself, gives up on good views.)
Adjustment adjusted(const Board& board, const std::vector<View>& views, const cv::Size& image_px,
                    Distortion lens) {
  std::optional<Adjustment> best;
  for (const double degrees : {30, 50, 70, 90, 110, 130, 150}) {
    const CameraModel camera = plain_lens(lens, image_px, degrees);
    std::vector<Pose> poses;
    try {
      for (const View& view : views) poses.push_back(pose_of(board, view, camera));
    } catch (const std::runtime_error&) {
      continue;
    }
    Adjustment start(board, views, camera, std::move(poses));
    start.solve(false);
    if (!best || start.squares() < best->squares()) best.emplace(start);
  }
  if (best) best->solve(true);
  if (!best || !std::isfinite(best->squares()))
    throw std::runtime_error(
        "no lens explains these views: more are needed, tilted and all over the picture, or it is another "
        "board");
  return *best;
}

double median_rms(const Fit& fit) {
  std::vector<double> values;
  for (const FittedView& v : fit.views) values.push_back(v.rms_px);
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

std::vector<std::string> parameter_names(const CameraModel& camera) {
  std::vector<std::string> names = {"fx", "fy", "cx", "cy", "k1", "k2"};
  const std::vector<std::string> rest = camera.distortion == Distortion::equidistant
                                            ? std::vector<std::string>{"k3", "k4"}
                                            : std::vector<std::string>{"p1", "p2", "k3"};
  names.insert(names.end(), rest.begin(), rest.end());
  return names;
}

Eigen::VectorXd parameters(const CameraModel& camera) {
  const auto more = static_cast<Eigen::Index>(camera.coefficients.size());
  Eigen::VectorXd all(4 + more);
  all << camera.given.fx_px, camera.given.fy_px, camera.given.cx_px, camera.given.cy_px,
      Eigen::Map<const Eigen::VectorXd>(camera.coefficients.data(), more);
  return all;
}

Fit fit(const Board& board, const std::vector<View>& views, const cv::Size& image_px, Distortion lens) {
  if (views.size() < fewest_views)
    throw std::runtime_error(
        fmt::format("{} good views; at least {} are needed", views.size(), fewest_views));
  const Adjustment adjustment = adjusted(board, views, image_px, lens);
  Fit out = adjustment.result(adjustment.noise_variance(true));
  out.camera.rectified = out.camera.given;
  if (!out.covariance.allFinite() || !(out.covariance.diagonal().minCoeff() > 0))
    throw std::runtime_error("these views leave the lens undetermined: tilted ones are needed");
  return out;
}

Fit fit_without_outliers(const Board& board, std::vector<View> views, const cv::Size& image_px,
                         Distortion lens, std::vector<RefusedView>& refused) {
  for (;;) {
    Fit out = fit(board, views, image_px, lens);
    const auto worst = std::max_element(out.views.begin(), out.views.end(),
                                        [](const auto& a, const auto& b) { return a.rms_px < b.rms_px; });
    const double usual = median_rms(out);
    if (worst->rms_px <= std::max(outlier_least_px, outlier_factor * usual)) return out;
    refused.push_back({worst->view.name,
                       {fmt::format("its residual is {:.2f} px where {:.2f} is usual: a bent or "
                                    "wrong board, or a moving one",
                                    worst->rms_px, usual)}});
    views.erase(views.begin() + (worst - out.views.begin()));
  }
}

Check check(const Board& board, const std::vector<View>& views, const CameraModel& given) {
  CameraModel camera = given;
  if (camera.distortion == Distortion::none) {
    camera.distortion = Distortion::plumb_bob;
    camera.coefficients.assign(5, 0);
  }
  std::vector<Pose> poses;
  for (const View& view : views) poses.push_back(pose_of(board, view, camera));
  Adjustment adjustment(board, views, camera, std::move(poses));
  adjustment.solve(false);
  Adjustment free = adjustment;
  free.solve(true);
  Check out;
  const double noise = free.noise_variance(true);
  out.as_it_is = adjustment.result(noise);
  out.better = parameters(free.camera());
  out.free_rms_px = Adjustment::rms(free.squares(), out.as_it_is.corners);
  out.systematic_px = Adjustment::rms(adjustment.squares() - free.squares(), out.as_it_is.corners);
  out.allowed_px =
      std::max(harmless_px, std::sqrt(noise * chance / static_cast<double>(out.as_it_is.corners)));
  return out;
}

}  // namespace stevedore
