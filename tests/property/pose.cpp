// Pose of a circle from exact ellipses: circles in space are projected by hand, without the code under test.
#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "pose_proc/circle_image.hpp"
#include "pose_proc/circle_pose.hpp"
#include "tests/support/measured_circle.hpp"

using namespace stevedore;
using std::numbers::pi;

namespace {

const Pinhole camera{640, 480, 337, 337, 319.5, 239.5};
constexpr double deg = pi / 180;

Circle circle_at(double u_px, double v_px, double depth_m, double tilt_rad, double azimuth_rad,
                 double radius_m = 0.5) {
  return stevedore::circle_at(camera, u_px, v_px, depth_m, tilt_rad, azimuth_rad, radius_m);
}

std::optional<Ellipse> image_of(const Circle& circle) {
  return stevedore::image_of(camera, circle);
}

EllipseFit exact(const Ellipse& ellipse) {
  return {ellipse, EllipseCovariance::Zero()};
}

const CircleSolution& nearer(const std::array<CircleSolution, 2>& solutions, const Circle& truth) {
  const auto off = [&](int i) {
    const auto& s = solutions[static_cast<std::size_t>(i)];
    return (s.center_camera_m - truth.center_m).norm() + (s.normal_camera - truth.normal).norm();
  };
  return solutions[off(0) <= off(1) ? 0 : 1];
}

double normal_error(const CircleSolution& solution, const Circle& truth) {
  return std::atan2(solution.normal_camera.cross(truth.normal).norm(),
                    solution.normal_camera.dot(truth.normal));
}

/// Calls visit(circle, ellipse) for circles all over the image.
template <class Visit>
void for_each_circle(const std::vector<double>& tilts_deg, const std::vector<double>& depths_m, Visit visit) {
  for (const double tilt : tilts_deg)
    for (const double depth : depths_m)
      for (double u = 0; u <= 640; u += 80)
        for (double v = 0; v <= 480; v += 80)
          for (int azimuth = 0; azimuth < 360; azimuth += 30) {
            const Circle circle = circle_at(u, v, depth, tilt * deg, azimuth * deg);
            if (const auto ellipse = image_of(circle)) visit(circle, *ellipse);
          }
}

/// An ellipse as an edge fit with equal noise all round measures it: the centre, and the root of its shape,
/// moved at random. The covariance is the one such a fit would state, at the measured ellipse.
EllipseFit measured(const Ellipse& truth, double sigma_px, std::mt19937& random) {
  std::normal_distribution<double> normal;
  const Eigen::Matrix2d axes = Eigen::Rotation2Dd(truth.alpha_rad).toRotationMatrix();
  Eigen::Matrix2d root = axes * Eigen::Vector2d(truth.a_px, truth.b_px).asDiagonal() * axes.transpose();
  const double shear_px = sigma_px * normal(random);  // off-diagonal
  root(0, 0) += std::sqrt(2) * sigma_px * normal(random);
  root(1, 1) += std::sqrt(2) * sigma_px * normal(random);
  root(0, 1) += shear_px;
  root(1, 0) += shear_px;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(root);
  const Eigen::Vector2d major = eigen.eigenvectors().col(1);
  EllipseFit fit;
  fit.ellipse =
      normalized({truth.u_px + sigma_px * normal(random), truth.v_px + sigma_px * normal(random),
                  eigen.eigenvalues()[1], eigen.eigenvalues()[0], std::atan2(major.y(), major.x())});
  const double v = sigma_px * sigma_px;
  fit.covariance.diagonal() << v, v, 2 * v, 2 * v, v / std::pow(fit.ellipse.a_px - fit.ellipse.b_px, 2);
  return fit;
}

/// Some covariance with correlations of every pair, of the size sigma_px.
EllipseCovariance correlated(const Ellipse& e, double sigma_px) {
  EllipseCovariance root;
  root << 1, 0, 0, 0, 0,       //
      0.3, 1, 0, 0, 0,         //
      -0.2, 0.1, 1.2, 0, 0,    //
      0.1, -0.3, 0.5, 1.1, 0,  //
      0.2, 0.1, -0.1, 0.2, 1 / (e.a_px - e.b_px);
  return sigma_px * sigma_px * root * root.transpose();
}

struct Spread {
  Eigen::Matrix3d center_m2 = Eigen::Matrix3d::Zero();
  double normal_rad2 = 0;  // mean of two directions
};

/// Second moments, about the estimate, of what `solve` finds for ellipses drawn from the fit's Gaussian.
template <class Solve>
Spread monte_carlo(const EllipseFit& fit, const CircleSolution& estimate, Solve solve) {
  constexpr int draws = 20000;
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  const EllipseCovariance root = fit.covariance.llt().matrixL();
  const Ellipse& e = fit.ellipse;
  Spread spread;
  for (int i = 0; i < draws; ++i) {
    Eigen::Matrix<double, 5, 1> x;
    for (double& value : x) value = normal(random);
    x = root * x;
    const CircleSolution drawn =
        solve(normalized({e.u_px + x[0], e.v_px + x[1], e.a_px + x[2], e.b_px + x[3], e.alpha_rad + x[4]}));
    const Eigen::Vector3d off_m = drawn.center_camera_m - estimate.center_camera_m;
    spread.center_m2 += off_m * off_m.transpose() / draws;
    spread.normal_rad2 += (drawn.normal_camera - estimate.normal_camera).squaredNorm() / 2 / draws;
  }
  return spread;
}

double relative_difference(const Eigen::Matrix3d& a, const Eigen::Matrix3d& b) {
  return (a - b).norm() / b.norm();
}

}  // namespace

TEST_CASE("conic: one of the two solutions is the circle, all over the image") {
  double worst_m = 0, worst_rad = 0;
  int count = 0;
  for_each_circle(
      {0, 1, 5, 15, 30, 45}, {0.5, 1.6, 5, 12}, [&](const Circle& circle, const Ellipse& ellipse) {
        const auto solutions = conic_pose(exact(ellipse), camera, circle.radius_m);
        REQUIRE(solutions);
        const CircleSolution& best = nearer(solutions->solutions, circle);
        worst_m = std::max(worst_m, (best.center_camera_m - circle.center_m).norm());
        const double apart =
            (solutions->solutions.at(0).normal_camera - solutions->solutions.at(1).normal_camera).norm();
        // nearer to merging, the normal goes with the square root of the last digit
        if (apart > 0.01) worst_rad = std::max(worst_rad, normal_error(best, circle));
        ++count;
      });
  CHECK(count > 15000);
  CHECK(worst_m < 1e-7);
  CHECK(worst_rad < 1e-9);
}

TEST_CASE("conic: circles seen almost from the side") {
  double worst_m = 0;
  for_each_circle({70, 80, 85}, {1.6, 5}, [&](const Circle& circle, const Ellipse& ellipse) {
    if (ellipse.b_px < 0.1) return;  // the plane goes through the camera
    const auto solutions = conic_pose(exact(ellipse), camera, circle.radius_m);
    REQUIRE(solutions);
    worst_m =
        std::max(worst_m, (nearer(solutions->solutions, circle).center_camera_m - circle.center_m).norm());
  });
  CHECK(worst_m < 1e-6);
}

TEST_CASE("conic: both solutions have the same image, face the camera and come in the stated order") {
  double worst_px = 0;
  for_each_circle({0, 5, 30, 45}, {1.6, 5}, [&](const Circle& circle, const Ellipse& ellipse) {
    const auto solutions = conic_pose(exact(ellipse), camera, circle.radius_m);
    REQUIRE(solutions);
    for (const CircleSolution& s : solutions->solutions) {
      REQUIRE(s.normal_camera.norm() == Approx(1));
      REQUIRE(s.normal_camera.dot(s.center_camera_m) < 0);
      const auto again = image_of({s.center_camera_m, s.normal_camera, circle.radius_m});
      REQUIRE(again);
      for (double t = 0; t < 6; t += 1) {
        const double radius = std::sqrt(normalized_radius_squared(ellipse, point_at(*again, t)));
        worst_px = std::max(worst_px, std::abs(radius - 1) * ellipse.a_px);
      }
    }
    REQUIRE(solutions->solutions.at(0).normal_camera.z() <=
            solutions->solutions.at(1).normal_camera.z() + 1e-12);
  });
  CHECK(worst_px < 1e-6);
}

TEST_CASE("conic: a circle that faces the camera lies between its two solutions, within their covariance") {
  for (const Eigen::Vector2d& at : {Eigen::Vector2d(319.5, 239.5), Eigen::Vector2d(90, 400)}) {
    Circle circle = circle_at(at.x(), at.y(), 2, 0, 0);
    circle.normal = -circle.center_m.normalized();
    EllipseFit fit = exact(image_of(circle).value());
    fit.covariance.diagonal() << 0.01, 0.01, 0.02, 0.02, 1e-5;
    const auto solutions = conic_pose(fit, camera, circle.radius_m);
    REQUIRE(solutions);
    const auto& [first, second] = solutions->solutions;
    CHECK(((first.center_camera_m + second.center_camera_m) / 2 - circle.center_m).norm() < 2e-3);
    for (const CircleSolution& s : solutions->solutions) {
      const Eigen::Vector3d off_m = s.center_camera_m - circle.center_m;
      CHECK(off_m.dot(s.covariance_m2.ldlt().solve(off_m)) < 7.8);  // 95 % of three degrees of freedom
      CHECK(std::sqrt(s.covariance_m2.trace()) < 0.05);
    }
  }
}

TEST_CASE("conic: the covariance is that of ellipses drawn from the fit's Gaussian") {
  for (const double tilt : {15, 30, 45, 65})
    for (const double depth : {1.6, 5.0}) {
      const Circle circle = circle_at(200, 330, depth, tilt * deg, 2);
      EllipseFit fit = exact(image_of(circle).value());
      fit.covariance = correlated(fit.ellipse, 0.02);
      const auto solutions = conic_pose(fit, camera, circle.radius_m);
      REQUIRE(solutions);
      for (const CircleSolution& s : solutions->solutions) {
        const Spread spread = monte_carlo(fit, s, [&](const Ellipse& e) {
          return nearer(conic_pose(exact(e), camera, circle.radius_m)->solutions,
                        {s.center_camera_m, s.normal_camera, 0});
        });
        INFO(tilt << " deg at " << depth << " m");
        CHECK(relative_difference(s.covariance_m2, spread.center_m2) < 0.05);
        CHECK(s.normal_covariance_rad2.trace() / 2 == Approx(spread.normal_rad2).epsilon(0.05));
      }
    }
}

TEST_CASE("conic: the covariance keeps the two solutions apart all over the image") {
  for_each_circle({20, 45, 65}, {1.6, 5}, [](const Circle& circle, const Ellipse& ellipse) {
    EllipseFit fit = exact(ellipse);
    fit.covariance = 1e-6 * EllipseCovariance::Identity();
    const auto solutions = conic_pose(fit, camera, circle.radius_m);
    REQUIRE(solutions);
    const double apart_m =
        (solutions->solutions.at(0).center_camera_m - solutions->solutions.at(1).center_camera_m).norm();
    if (apart_m < 0.05) return;  // a thousandth of a pixel moves either by far less than that
    for (const CircleSolution& s : solutions->solutions)
      REQUIRE(std::sqrt(s.covariance_m2.trace()) < apart_m / 10);
  });
}

TEST_CASE("conic: the covariance is honest from facing the camera to steep") {
  // mean of e^T C^-1 e over noisy measurements: 3 for a Gaussian error
  std::mt19937 random(5);
  for (const double tilt : {0, 1, 2, 4, 8, 15, 30, 60})
    for (const double depth : {1.6, 5.0}) {
      const Circle circle = circle_at(319.5, 239.5, depth, tilt * deg, 0.7);
      const Ellipse ellipse = image_of(circle).value();
      double sum = 0;
      constexpr int draws = 2000;
      for (int i = 0; i < draws; ++i) {
        const auto solutions = conic_pose(measured(ellipse, 0.05, random), camera, circle.radius_m);
        REQUIRE(solutions);
        const CircleSolution& best = nearer(solutions->solutions, circle);
        const Eigen::Vector3d off_m = best.center_camera_m - circle.center_m;
        sum += off_m.dot(best.covariance_m2.ldlt().solve(off_m));
      }
      INFO(tilt << " deg at " << depth << " m");
      CHECK(sum / draws > 1.5);
      CHECK(sum / draws < 4);
    }
}

TEST_CASE("four_point: exact without tilt, all over the image") {
  double worst_m = 0;
  for_each_circle({0}, {1.6, 5}, [&](const Circle& circle, const Ellipse& ellipse) {
    const auto solution = four_point_pose(exact(ellipse), camera, circle.radius_m);
    REQUIRE(solution);
    REQUIRE(solution->normal_camera.z() == Approx(-1));
    worst_m = std::max(worst_m, (solution->center_camera_m - circle.center_m).norm());
  });
  CHECK(worst_m < 1e-6);
}

TEST_CASE("four_point: its error grows with tilt, the price of Assumption 1") {
  // tilt in degrees, least and most error in m over the image at 1.6 m
  const std::vector<std::array<double, 3>> expected{{5, 0.003, 0.015}, {15, 0.010, 0.050}, {30, 0.020, 0.11}};
  for (const auto& [tilt, least_m, most_m] : expected)
    for_each_circle({tilt}, {1.6},
                    [&, least = least_m, most = most_m](const Circle& circle, const Ellipse& ellipse) {
                      const auto solution = four_point_pose(exact(ellipse), camera, circle.radius_m);
                      REQUIRE(solution);
                      const double error_m = (solution->center_camera_m - circle.center_m).norm();
                      REQUIRE(error_m > least);
                      REQUIRE(error_m < most);
                      REQUIRE(solution->normal_camera.dot(solution->center_camera_m) < 0);
                    });
}

TEST_CASE("four_point: the normal is towards the camera for circles seen almost from the side") {
  for_each_circle({60, 80}, {1.6, 5}, [](const Circle& circle, const Ellipse& ellipse) {
    if (const auto solution = four_point_pose(exact(ellipse), camera, circle.radius_m))
      REQUIRE(solution->normal_camera.dot(solution->center_camera_m) <= 0);
  });
}

TEST_CASE("four_point: the covariance is that of ellipses drawn from the fit's Gaussian") {
  for (const double tilt : {0, 15, 30}) {
    const Circle circle = circle_at(200, 330, 1.6, tilt * deg, 2);
    EllipseFit fit = exact(image_of(circle).value());
    fit.ellipse.a_px += 0.5;  // so that at tilt 0 too there is an alpha
    fit.covariance = correlated(fit.ellipse, 0.02);
    const auto solution = four_point_pose(fit, camera, circle.radius_m);
    REQUIRE(solution);
    const Spread spread = monte_carlo(fit, *solution, [&](const Ellipse& e) {
      return *four_point_pose(exact(e), camera, circle.radius_m);
    });
    INFO(tilt << " deg");
    // solvePnP's residuals are not small where its model is wrong, and the covariance takes them to be
    CHECK(relative_difference(solution->covariance_m2, spread.center_m2) < 0.3);
    CHECK(solution->normal_covariance_rad2.trace() / 2 == Approx(spread.normal_rad2).epsilon(0.4));
  }
}

TEST_CASE("circle_image: the image of exact circles, and its derivatives") {
  for_each_circle({1, 15, 45}, {1.6, 5}, [](const Circle& circle, const Ellipse& ellipse) {
    if (ellipse.b_px < 3) return;
    const CircleImage image = circle_image(circle.center_m, circle.normal, circle.radius_m);
    const Vector5d measured_value = edge_image(exact(ellipse), camera).value;
    REQUIRE((image.value - measured_value).norm() < 1e-9);
    constexpr double step = 1e-6;
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d d = step * Eigen::Vector3d::Unit(k);
      const auto value = [&](const Eigen::Vector3d& c, const Eigen::Vector3d& n, double r) {
        return circle_image(c, n, r).value;
      };
      const Eigen::Vector3d &c = circle.center_m, &n = circle.normal;
      const double r = circle.radius_m;
      REQUIRE((image.by_center.col(k) - (value(c + d, n, r) - value(c - d, n, r)) / (2 * step)).norm() <
              1e-6);
      REQUIRE((image.by_normal.col(k) - (value(c, n + d, r) - value(c, n - d, r)) / (2 * step)).norm() <
              1e-6);
      REQUIRE((image.by_radius - (value(c, n, r + step) - value(c, n, r - step)) / (2 * step)).norm() < 1e-6);
    }
  });
}
