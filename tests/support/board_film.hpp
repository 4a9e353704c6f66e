// Pictures of a calibration board through a known lens.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <random>
#include <vector>

#include "geometry/lens.hpp"
#include "tools/calibrate_board.hpp"

namespace stevedore {

inline const cv::Size example_px(640, 480);

/// Wide lenses: 93 degrees with plumb_bob, 126 with equidistant.
inline CameraModel example_lens(Distortion kind) {
  CameraModel camera;
  camera.distortion = kind;
  if (kind == Distortion::plumb_bob) {
    camera.given = {example_px.width, example_px.height, 302.0, 301.4, 321.3, 238.2};
    camera.coefficients = {-0.28, 0.075, 0.0006, -0.0004, 0};
  } else {
    camera.given = {example_px.width, example_px.height, 290.0, 289.5, 317.0, 243.0};
    camera.coefficients = {0.02, -0.01, 0.004, -0.001};
  }
  camera.rectified = camera.given;
  return camera;
}

struct BoardPose {
  Eigen::Matrix3d turn;     ///< board to camera
  Eigen::Vector3d place_m;  ///< of the board's origin, the outer corner of its first square
};

inline Eigen::Vector2d middle_m(const Board& board) {
  return Eigen::Vector2d(board.corners.width + 1, board.corners.height + 1) * board.square_m / 2;
}

/// Turned by these angles about the camera's axes, its middle at `middle_camera_m`.
inline BoardPose board_pose(const Board& board, const Eigen::Vector3d& degrees,
                            const Eigen::Vector3d& middle_camera_m) {
  const Eigen::Vector3d a = degrees * M_PI / 180;
  const Eigen::Matrix3d turn = (Eigen::AngleAxisd(a.y(), Eigen::Vector3d::UnitY()) *
                                Eigen::AngleAxisd(a.x(), Eigen::Vector3d::UnitX()) *
                                Eigen::AngleAxisd(a.z(), Eigen::Vector3d::UnitZ()))
                                   .toRotationMatrix();
  const Eigen::Vector2d m = middle_m(board);
  return {turn, middle_camera_m - turn * Eigen::Vector3d(m.x(), m.y(), 0)};
}

/// Where the lens shows a point of the board; far outside for one behind.
inline Eigen::Vector2d board_pixel(const CameraModel& camera, const BoardPose& pose,
                                   const Eigen::Vector3d& point_m) {
  const auto seen = project(camera, pose.turn * point_m + pose.place_m);
  return seen ? seen->pixel_px : Eigen::Vector2d(-1e6, -1e6);
}

/// Its corners as they truly are, with Gaussian noise.
inline View true_view(const Board& board, const CameraModel& camera, const BoardPose& pose, double noise_px,
                      std::mt19937& dice) {
  std::normal_distribution<double> noise(0, 1);
  View view;
  view.name = "true";
  for (int id = 0; id < board.corners.area(); ++id) {
    const cv::Point3f p = board.point_m(id);
    const Eigen::Vector2d px = board_pixel(camera, pose, {p.x, p.y, 0});
    view.ids.push_back(id);
    const double dv = noise_px * noise(dice), du = noise_px * noise(dice);
    view.corners_px.emplace_back(static_cast<float>(px.x() + du), static_cast<float>(px.y() + dv));
  }
  return view;
}

/// A careful person's set: boards to all sides and in all corners of the picture that face the camera but for
/// a tilt, each twice; and once more in the corners, without.
inline std::vector<BoardPose> good_poses(const Board& board, const CameraModel& camera, unsigned seed) {
  std::mt19937 dice(seed);
  std::uniform_real_distribution<double> any(-1, 1);
  const double w = (board.corners.width + 1) * board.square_m,
               h = (board.corners.height + 1) * board.square_m;
  const auto inside = [&](const BoardPose& pose) {
    for (const double x : {0.0, w / 2, w})
      for (const double y : {0.0, h / 2, h}) {
        const Eigen::Vector2d px = board_pixel(camera, pose, {x, y, 0});
        if (!(px.x() > 4 && px.y() > 4 && px.x() < camera.given.width_px - 5 &&
              px.y() < camera.given.height_px - 5))
          return false;
      }
    return true;
  };
  std::vector<BoardPose> poses;
  for (int round = 0; round < 3; ++round)
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y) {
        if (round == 2 && (x == 0 || y == 0)) continue;
        Eigen::Vector3d tilt(round ? -25 : 25, round == (x + y) % 2 ? 25 : -25, 0);
        if (round == 2) tilt.setZero();
        const double z = any(dice), y_more = any(dice), x_more = any(dice);
        tilt += Eigen::Vector3d(8 * x_more, 8 * y_more, (round == 2 ? 4 : 15) * z);
        const double distance_m = w * (0.85 + 0.25 * any(dice));
        std::optional<BoardPose> last;
        Eigen::Vector2d out(0, 0);
        const auto move = [&](double dx, double dy) {  // outwards until it would leave the picture
          for (Eigen::Vector2d next = out; next.maxCoeff() < 1; next += Eigen::Vector2d(dx, dy)) {
            const auto ray = unproject(camera, {(camera.given.width_px - 1) * (1 + next.x() * x) / 2,
                                                (camera.given.height_px - 1) * (1 + next.y() * y) / 2});
            if (!ray) return;
            const Eigen::Vector3d sight = ray->point.homogeneous().normalized();
            const BoardPose pose = board_pose(board, tilt, Eigen::Vector3d::Zero());
            const Eigen::Matrix3d facing =
                Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), sight).toRotationMatrix();
            const BoardPose there = {facing * pose.turn, facing * pose.place_m + distance_m * sight};
            if (!inside(there)) return;
            last = there;
            out = next;
          }
        };
        move(0.01, 0.01);
        move(0.01, 0);
        move(0, 0.01);
        if (last) poses.push_back(*last);
      }
  return poses;
}

class BoardFilm {
 public:
  BoardFilm(const Board& board, const CameraModel& camera)
      : board_(board), camera_(camera), drawn_(draw_board(board, square_px)) {
    const int w = camera.given.width_px * finer, h = camera.given.height_px * finer;
    Eigen::Matrix2Xd pixels(2, static_cast<Eigen::Index>(w) * h);
    for (int v = 0; v < h; ++v)
      for (int u = 0; u < w; ++u)
        pixels.col(static_cast<Eigen::Index>(v) * w + u) =
            Eigen::Vector2d((u + 0.5) / finer - 0.5, (v + 0.5) / finer - 0.5);
    CameraModel unit = camera;
    unit.rectified = {camera.given.width_px, camera.given.height_px, 1, 1, 0, 0};
    rays_ = undistort_points(unit, pixels);
  }

  /// Grey levels: 40 the board's black, 210 its white, 120 around it. `blur_px`: lens; `moved_px`: motion to
  /// the right while exposing.
  cv::Mat take(const BoardPose& pose, double noise_levels, unsigned seed, double blur_px = 0.6,
               int moved_px = 0) const {
    const int w = camera_.given.width_px * finer, h = camera_.given.height_px * finer;
    const Eigen::Matrix3d back = pose.turn.transpose();
    const Eigen::Vector3d eye = -back * pose.place_m;
    cv::Mat map(h, w, CV_32FC2), fine, image;
    for (int v = 0; v < h; ++v)
      for (int u = 0; u < w; ++u) {
        const Eigen::Index i = static_cast<Eigen::Index>(v) * w + u;
        cv::Point2f& at = map.at<cv::Point2f>(v, u);
        at = {-1e4F, -1e4F};
        if (!rays_.valid[i]) continue;
        const Eigen::Vector3d ray = back * rays_.point_px.col(i).homogeneous();
        const double reach = -eye.z() / ray.z();
        if (!(reach > 0)) continue;
        const Eigen::Vector3d point = eye + reach * ray;
        const double scale = square_px / board_.square_m;
        // the drawing has a margin of a square; a pixel's centre is half a pixel in
        at = {static_cast<float>(point.x() * scale + square_px - 0.5),
              static_cast<float>(point.y() * scale + square_px - 0.5)};
      }
    cv::Mat levels;
    drawn_.convertTo(levels, CV_32F, (210.0 - 40) / 255, 40);
    cv::remap(levels, fine, map, {}, cv::INTER_LINEAR, cv::BORDER_CONSTANT, cv::Scalar(120));
    cv::GaussianBlur(fine, fine, {}, blur_px * finer);
    if (moved_px > 0) cv::blur(fine, fine, {moved_px * finer, 1});
    cv::resize(fine, image, {camera_.given.width_px, camera_.given.height_px}, 0, 0, cv::INTER_AREA);
    cv::Mat noise(image.size(), CV_32F);
    cv::RNG dice(seed + 1);
    dice.fill(noise, cv::RNG::NORMAL, 0, noise_levels);
    image += noise;
    image.convertTo(image, CV_8U);
    return image;
  }

 private:
  static constexpr int finer = 3, square_px = 64;
  Board board_;
  CameraModel camera_;
  cv::Mat drawn_;
  IdealPoints rays_;
};

}  // namespace stevedore
