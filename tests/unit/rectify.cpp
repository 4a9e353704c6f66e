#include "geometry/rectify.hpp"

#include <Eigen/Core>
#include <catch2/catch.hpp>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

using namespace stevedore;

namespace {

CameraModel camera_with(Distortion distortion, std::vector<double> coefficients) {
  CameraModel camera;
  camera.given = {640, 480, 302, 301.4, 321.3, 238.2};
  camera.rectified = {640, 480, 250, 250, 319.5, 239.5};
  camera.distortion = distortion;
  camera.coefficients = std::move(coefficients);
  return camera;
}

std::vector<CameraModel> cameras() {
  return {camera_with(Distortion::none, {}),
          camera_with(Distortion::plumb_bob, {-0.28, 0.075, 0.0006, -0.0004, 0.001}),
          camera_with(Distortion::equidistant, {-0.02, 0.004, -0.001, 0.0002})};
}

cv::Point2d opencv_distort(const CameraModel& camera, const Eigen::Vector3d& ray) {
  const auto& g = camera.given;
  const cv::Matx33d k(g.fx_px, 0, g.cx_px, 0, g.fy_px, g.cy_px, 0, 0, 1);
  const std::vector<cv::Point3d> point{{ray.x(), ray.y(), ray.z()}};
  const cv::Vec3d zero;
  std::vector<cv::Point2d> out;
  if (camera.distortion == Distortion::equidistant)
    cv::fisheye::projectPoints(point, out, zero, zero, k, camera.coefficients);
  else
    cv::projectPoints(point, zero, zero, k, camera.coefficients, out);
  return out.front();
}

}  // namespace

TEST_CASE("points go to the image as given and back, all over the image, for every lens") {
  for (const CameraModel& camera : cameras())
    for (double u = 0; u < 640; u += 39.9)
      for (double v = 0; v < 480; v += 39.9) {
        const auto back = undistort(camera, distort(camera, Eigen::Vector2d(u, v)));
        REQUIRE(back);
        REQUIRE((*back - Eigen::Vector2d(u, v)).norm() < 1e-6);
      }
}

TEST_CASE("the lens models are OpenCV's, with which cameras are calibrated") {
  for (const CameraModel& camera : cameras())
    for (double u = 0; u < 640; u += 79.9)
      for (double v = 0; v < 480; v += 79.9) {
        const Eigen::Vector2d ours = distort(camera, Eigen::Vector2d(u, v));
        const cv::Point2d theirs = opencv_distort(camera, camera.rectified.unproject({u, v}));
        REQUIRE(std::hypot(ours.x() - theirs.x, ours.y() - theirs.y) < 1e-9);
      }
}

TEST_CASE("a spot in the image as given appears where its ray belongs") {
  for (const CameraModel& camera : cameras()) {
    const RectifyMaps maps = make_rectify_maps(camera);
    for (const Eigen::Vector2d& rectified :
         {Eigen::Vector2d(320, 240), Eigen::Vector2d(150, 120), Eigen::Vector2d(420, 330)}) {
      const Eigen::Vector2d given = distort(camera, rectified);
      cv::Mat image(480, 640, CV_32F);
      for (int v = 0; v < 480; ++v)
        for (int u = 0; u < 640; ++u)
          image.at<float>(v, u) =
              static_cast<float>(std::exp(-((Eigen::Vector2d(u, v) - given).squaredNorm()) / 4.5));
      const cv::Moments moments = cv::moments(rectify(image, maps));
      CHECK(std::abs(moments.m10 / moments.m00 - rectified.x()) < 0.1);
      CHECK(std::abs(moments.m01 / moments.m00 - rectified.y()) < 0.1);
    }
  }
}

TEST_CASE("without distortion the image itself comes back") {
  CameraModel camera = camera_with(Distortion::none, {});
  camera.rectified = camera.given;
  const cv::Mat image(480, 640, CV_8U, cv::Scalar(7));
  CHECK(rectify(image, make_rectify_maps(camera)).data == image.data);
}

TEST_CASE("an outline in the image as given lies on the distorted points") {
  const Ellipse ellipse{420, 150, 40, 25, 0.5};
  for (const CameraModel& camera : cameras()) {
    const auto outline = distort(camera, ellipse);
    REQUIRE(outline);
    for (double t = 0; t < 6.3; t += 0.3) {
      const double radius =
          std::sqrt(normalized_radius_squared(*outline, distort(camera, point_at(ellipse, t))));
      CHECK(std::abs(radius - 1) * outline->a_px < 0.4);  // a bent ellipse is not quite one
    }
  }
}

TEST_CASE("an outline keeps its axes and angle where the lens does nothing but shift") {
  CameraModel camera = camera_with(Distortion::none, {});
  camera.rectified = camera.given;
  camera.rectified.cx_px += 10;
  for (const double alpha : {-1.5, -0.8, 0.0, 0.4, 1.3}) {
    const auto outline = distort(camera, Ellipse{300, 200, 60, 30, alpha});
    REQUIRE(outline);
    CHECK(outline->u_px == Approx(290).margin(1e-9));
    CHECK(outline->v_px == Approx(200).margin(1e-9));
    CHECK(outline->a_px == Approx(60).margin(1e-9));
    CHECK(outline->b_px == Approx(30).margin(1e-9));
    CHECK(outline->alpha_rad == Approx(alpha).margin(1e-9));
  }
}

TEST_CASE("light from grey levels") {
  const auto linear = linear_light({Response::Curve::linear, 1});
  const auto srgb = linear_light({Response::Curve::srgb, 1});
  const auto gamma = linear_light({Response::Curve::gamma, 2});
  for (const auto& light : {linear, srgb, gamma}) {
    CHECK(light[0] == 0);
    CHECK(light[255] == Approx(1));
  }
  CHECK(linear[51] == Approx(0.2));
  CHECK(gamma[51] == Approx(0.04));
  CHECK(srgb[188] == Approx(0.5).margin(0.005));  // half the light is written as 73 % of the scale
}
