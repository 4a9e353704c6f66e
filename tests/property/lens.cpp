// The lens models: ways there and back, derivatives against differences, out to the corners of a wide lens.
#include "geometry/lens.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>

#include "geometry/rectify.hpp"

using namespace stevedore;

namespace {

constexpr double deg = std::numbers::pi / 180;
const Eigen::Vector2d corner_ray(std::tan(43.5 * deg), std::tan(35.5 * deg));  // of an 87 x 71 degree lens

CameraModel camera_with(Distortion distortion, std::vector<double> coefficients) {
  CameraModel camera;
  camera.distortion = distortion;
  camera.coefficients = std::move(coefficients);
  camera.given = {640, 480, 302, 301.4, 321.3, 238.2};
  camera.rectified = {640, 480, 250, 251, 319.5, 239.5};
  return camera;
}

/// As calibrations of wide lenses give them, with and without the tangential part.
std::vector<CameraModel> cameras() {
  return {camera_with(Distortion::none, {}),
          camera_with(Distortion::plumb_bob, {-0.28, 0.075, 0.0006, -0.0004, 0.001}),
          camera_with(Distortion::plumb_bob, {0.12, -0.03, -0.002, 0.003, 0.004}),
          camera_with(Distortion::equidistant, {0, 0, 0, 0}),
          camera_with(Distortion::equidistant, {-0.02, 0.004, -0.001, 0.0002})};
}

/// Directions all over the field of view, its four corners and the axis among them.
std::vector<Eigen::Vector2d> rays() {
  std::vector<Eigen::Vector2d> out{{0, 0}, {1e-10, -1e-10}};
  for (const double u : {-1.0, 1.0})
    for (const double v : {-1.0, 1.0}) out.emplace_back(u * corner_ray.x(), v * corner_ray.y());
  std::mt19937 random(3);
  std::uniform_real_distribution<double> share(-1, 1);
  for (int i = 0; i < 300; ++i)
    out.emplace_back(share(random) * corner_ray.x(), share(random) * corner_ray.y());
  return out;
}

/// Central differences of f at p.
template <int rows, int columns>
Eigen::Matrix<double, rows, columns> differences(
    const std::function<Eigen::Matrix<double, rows, 1>(const Eigen::Matrix<double, columns, 1>&)>& f,
    const Eigen::Matrix<double, columns, 1>& p, double step) {
  Eigen::Matrix<double, rows, columns> out;
  for (int i = 0; i < columns; ++i) {
    const Eigen::Matrix<double, columns, 1> d = step * Eigen::Matrix<double, columns, 1>::Unit(i);
    out.col(i) = (f(p + d) - f(p - d)) / (2 * step);
  }
  return out;
}

}  // namespace

TEST_CASE("every lens: rays come back from the image, to the corners of an 87 x 71 degree lens") {
  for (const CameraModel& camera : cameras())
    for (const Eigen::Vector2d& ray : rays()) {
      const auto back = undistort_ray(camera, distort_ray(camera, ray).point);
      REQUIRE(back);
      REQUIRE((back->point - ray).norm() < 1e-10);
    }
}

TEST_CASE("every lens: the derivatives of bending and of straightening are the differences'") {
  for (const CameraModel& camera : cameras())
    for (const Eigen::Vector2d& ray : rays()) {
      const MappedPoint bent = distort_ray(camera, ray);
      const auto there = differences<2, 2>(
          [&](const Eigen::Vector2d& p) { return distort_ray(camera, p).point; }, ray, 1e-5);
      REQUIRE((bent.jacobian - there).norm() < 1e-8);
      const auto back = undistort_ray(camera, bent.point);
      REQUIRE(back);
      REQUIRE((back->jacobian * bent.jacobian - Eigen::Matrix2d::Identity()).norm() < 1e-9);
    }
}

TEST_CASE("every lens: points project to pixels, pixels unproject to their rays, with derivatives") {
  for (const CameraModel& camera : cameras())
    for (const Eigen::Vector2d& ray : rays())
      for (const double depth_m : {0.4, 9.0}) {
        const Eigen::Vector3d point = depth_m * ray.homogeneous();
        const auto image = project(camera, point);
        REQUIRE(image);
        const auto by_point = differences<2, 3>(
            [&](const Eigen::Vector3d& p) { return project(camera, p)->pixel_px; }, point, 1e-5 * depth_m);
        REQUIRE((image->jacobian - by_point).norm() < 1e-7 * image->jacobian.norm());
        const auto back = unproject(camera, image->pixel_px);
        REQUIRE(back);
        REQUIRE((back->point - ray).norm() < 1e-10);
        const auto by_pixel = differences<2, 2>(
            [&](const Eigen::Vector2d& p) { return unproject(camera, p)->point; }, image->pixel_px, 1e-2);
        REQUIRE((back->jacobian - by_pixel).norm() < 1e-6 * back->jacobian.norm());
      }
}

TEST_CASE("many points at once are each what undistort says") {
  for (const CameraModel& camera : cameras()) {
    const auto all = rays();
    Eigen::Matrix2Xd given_px(2, all.size());
    for (std::size_t i = 0; i < all.size(); ++i)
      given_px.col(static_cast<Eigen::Index>(i)) =
          camera.given.project(distort_ray(camera, all[i]).point.homogeneous());
    const IdealPoints ideal = undistort_points(camera, given_px);
    REQUIRE(ideal.valid.all());
    for (Eigen::Index i = 0; i < given_px.cols(); ++i)
      REQUIRE((ideal.point_px.col(i) - *undistort(camera, given_px.col(i))).norm() < 1e-7);
  }
}

TEST_CASE("where the lens has folded back there is no ray") {
  const CameraModel folded = camera_with(Distortion::plumb_bob, {-0.3, 0, 0, 0, 0});
  // r (1 - 0.3 r^2) is at most 0.70, at r = 1.05
  CHECK(undistort_ray(folded, {0.69, 0}));
  CHECK_FALSE(undistort_ray(folded, {0.72, 0}));
  CHECK_FALSE(undistort_points(folded, folded.given.project({0.72, 0, 1})).valid[0]);
  CHECK_FALSE(project(folded, {0.1, 0.1, 0}));
  CHECK_FALSE(project(folded, {0.1, 0.1, -1}));
}
