// What the tracker is made of, part by part.
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <random>
#include <vector>

#include "tracker_proc/assignment.hpp"
#include "tracker_proc/camera_turn.hpp"
#include "tracker_proc/common_motion.hpp"
#include "tracker_proc/picture_motion.hpp"
#include "tracker_proc/surroundings.hpp"
#include "tracker_proc/tracker.hpp"

using namespace stevedore;

namespace {

/// The least sum over all ways to pair rows with columns, by trying them all.
double least_sum(const Eigen::MatrixXd& gain, Eigen::Index row, std::vector<bool>& taken) {
  if (row == gain.rows()) return 0;
  double least = least_sum(gain, row + 1, taken);
  for (Eigen::Index c = 0; c < gain.cols(); ++c) {
    const auto k = static_cast<std::size_t>(c);
    if (taken[k]) continue;
    taken[k] = true;
    least = std::min(least, gain(row, c) + least_sum(gain, row + 1, taken));
    taken[k] = false;
  }
  return least;
}

cv::Mat texture(unsigned seed) {
  cv::Mat coarse(30, 40, CV_8UC1), image;
  cv::RNG(seed).fill(coarse, cv::RNG::UNIFORM, 0, 255);
  cv::resize(coarse, image, {640, 480}, 0, 0, cv::INTER_CUBIC);
  return image;
}

cv::Mat moved(const cv::Mat& image, double du, double dv) {
  cv::Mat result;
  cv::warpAffine(image, result, cv::Matx23d(1, 0, du, 0, 1, dv), image.size(), cv::INTER_LINEAR,
                 cv::BORDER_REFLECT);
  return result;
}

/// A mark that is there, known to 5 px.
Expected known_mark(const Eigen::Vector2d& at_px, double radius_px) {
  Expected e;
  e.ellipse = {at_px.x(), at_px.y(), radius_px, radius_px, 0};
  e.centre_covariance_px2 = 25 * Eigen::Matrix2d::Identity();
  e.log_radius_variance = 1e-4;
  e.found_in_view = 0.95;
  return e;
}

Found seen_at(const Expected& mark, const Eigen::Vector2d& shift_px) {
  Found f;
  f.ellipse = mark.ellipse;
  f.ellipse.u_px += shift_px.x();
  f.ellipse.v_px += shift_px.y();
  f.measurement = {
      {f.ellipse.u_px, f.ellipse.v_px}, 0.1 * Eigen::Matrix2d::Identity(), std::log(mark.ellipse.a_px), 1e-4};
  return f;
}

}  // namespace

TEST_CASE("assignment: as cheap as the best of all, whatever the shape") {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> cost(-10, 5);
  for (int trial = 0; trial < 2000; ++trial) {
    const auto rows = static_cast<Eigen::Index>(random() % 6),
               columns = static_cast<Eigen::Index>(random() % 6);
    Eigen::MatrixXd gain(rows, columns);
    for (Eigen::Index i = 0; i < gain.size(); ++i)
      gain.data()[i] = trial % 3 ? cost(random) : cost(random) + 4;
    const auto match = assign(gain);
    double sum = 0;
    std::vector<bool> taken(static_cast<std::size_t>(columns));
    for (std::size_t r = 0; r < match.size(); ++r) {
      if (!match[r]) continue;
      CHECK_FALSE(taken[*match[r]]);
      taken[*match[r]] = true;
      sum += gain(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(*match[r]));
    }
    std::vector<bool> none(static_cast<std::size_t>(columns));
    CHECK(sum == Approx(least_sum(gain, 0, none)).margin(1e-9));
  }
}

TEST_CASE("the camera's turn: a far point moves by the homography, at any depth") {
  const Pinhole camera{640, 480, 337, 337, 319.5, 239.5};
  CameraTurn turn(camera, CameraMount{});
  const Eigen::Vector3d rate(0.3, -0.2, 0.5);
  const auto attitude = [&](double t) {
    return Eigen::Quaterniond(Eigen::AngleAxisd(rate.norm() * t, rate.normalized()));
  };
  const auto gimbal = [](double t) { return GimbalAngles{0.2 * t, -0.4 * t}; };
  for (int k = 0; k < 20; ++k) {
    turn.add(AttitudeSample{k * 0.02, attitude(k * 0.02), rate});
    turn.add(GimbalSample{k * 0.02, gimbal(k * 0.02)});
  }
  CHECK_FALSE(turn.homography_to(0.1));  // the first
  const auto h = turn.homography_to(0.233);
  REQUIRE(h);
  const auto ned_from_camera = [&](double t) {
    return Eigen::Matrix3d(attitude(t).toRotationMatrix() * body_from_camera(gimbal(t), CameraMount{}));
  };
  for (const double depth_m : {1.0, 50.0}) {
    const Eigen::Vector3d before = depth_m * camera.unproject({200, 300});
    const Eigen::Vector3d after = ned_from_camera(0.233).transpose() * ned_from_camera(0.1) * before;
    const Eigen::Vector2d expected = camera.project(after);
    CHECK(((*h * Eigen::Vector3d(200, 300, 1)).hnormalized() - expected).norm() < 0.01);
    CHECK((expected - Eigen::Vector2d(200, 300)).norm() > 10);
  }
  CHECK_FALSE(turn.homography_to(0.5));  // 0.12 s after the newest: nobody knows
}

TEST_CASE("the picture's shift: to a few pixels, and nothing where the two are different pictures") {
  const cv::Mat image = texture(3);
  for (const Eigen::Vector2d& shift : std::vector<Eigen::Vector2d>{{0, 0}, {40, -25}, {-120, 60}}) {
    PictureMotion motion;
    CHECK_FALSE(motion.shift_to(image));
    const auto seen = motion.shift_to(moved(image, shift.x(), shift.y()));
    REQUIRE(seen);
    CHECK((seen->shift_px - shift).norm() < 3 * std::sqrt(seen->variance_px2));
    CHECK_FALSE(motion.shift_to(texture(4)));
  }
}

TEST_CASE(
    "surroundings: the same ground elsewhere, larger and foreshortened, not another, nothing on even "
    "ground") {
  const cv::Mat image = texture(5);
  const Ellipse e{300, 240, 60, 60, 0};
  Surroundings surroundings;
  surroundings.learn(image, e);
  cv::Mat other;
  cv::warpAffine(image, other, cv::Matx23d(0.8, 0, 90, 0, 0.6, 30), image.size(), cv::INTER_AREA);
  CHECK(surroundings.correlation(other, {330, 174, 48, 36, 0}).value() > 0.9);
  CHECK(surroundings.correlation(image, {300, 120, 60, 60, 0}).value() < 0.5);
  CHECK_FALSE(surroundings.correlation(cv::Mat(480, 640, CV_8UC1, cv::Scalar(90)), e));
  CHECK_FALSE(surroundings.correlation(image, {-100, 240, 60, 60, 0}));
}

TEST_CASE("common motion: two edges of one bucket that could be exchanged leave no doubt about the shift") {
  std::vector<Expected> expected;
  for (int i = 0; i < 4; ++i) {
    const Eigen::Vector2d slot_px(120 + 130 * i, 240);
    expected.push_back(known_mark(slot_px, 45));                             // the circle
    expected.push_back(known_mark(slot_px + Eigen::Vector2d(4, 0), 15));     // the bucket's rim
    expected.push_back(known_mark(slot_px + Eigen::Vector2d(4, -1), 15.2));  // and its wall
  }
  const Eigen::Vector2d shift_px(14, -3);
  std::vector<Found> found;
  for (const Expected& e : expected) found.push_back(seen_at(e, shift_px));
  CommonMotion motion(100);
  motion.predict(0.1, 100);
  const CommonShift shift = motion.find(expected, found, {640, 480}, 0.1);
  CHECK(shift.ambiguous.empty());
  CHECK(shift.marks == expected.size());
  CHECK((shift.shift_px - shift_px).norm() < 1);
}

TEST_CASE("common motion: a row of equal marks whose ends are out of view could have moved by a whole step") {
  std::vector<Expected> expected;
  for (int i = 0; i < 6; ++i) expected.push_back(known_mark({-5 + 130.0 * i, 240}, 45));
  std::vector<Found> found;
  for (std::size_t i = 1; i < 5; ++i) found.push_back(seen_at(expected[i], {65, 0}));
  CommonMotion motion(2000);
  motion.predict(0.1, 100);
  const CommonShift shift = motion.find(expected, found, {640, 480}, 0.1);
  CHECK(std::count(shift.ambiguous.begin(), shift.ambiguous.end(), true) == 4);
}

TEST_CASE("the picture of minutes ago tells no motion of this frame") {
  constexpr double frame_s = 1.0 / 30;
  FrameView told, not_told;
  told.turn = Eigen::Matrix3d::Identity();
  const cv::Mat ground = texture(6);
  Detection mark;
  mark.outer.ellipse = {320, 240, 20, 20, 0};
  mark.label = Label::circle;
  Tracker tracker{TrackerSettings{}};
  int k = 0;
  for (; k < 3; ++k) tracker.step(k * frame_s, ground, {mark}, not_told);
  for (; k < 60; ++k) tracker.step(k * frame_s, moved(ground, k, 0), {mark}, told);
  for (; k < 70; ++k) tracker.step(k * frame_s, moved(ground, 60, 0), {}, told);  // it is hidden
  const auto result = tracker.step(k * frame_s, moved(ground, 60, 0), {}, not_told);
  REQUIRE(result.tracks.size() == 1);
  CHECK(std::abs(result.tracks[0].detection.outer.ellipse.u_px - 320) < 10);
}
