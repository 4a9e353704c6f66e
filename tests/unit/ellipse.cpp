#include "geometry/ellipse.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <numbers>

using namespace stevedore;
using std::numbers::pi;

TEST_CASE("an ellipse survives the way through its conic") {
  for (const double alpha : {-1.5, -0.7, 0.0, 0.3, 1.2}) {
    const Ellipse e{320.5, 17.25, 61, 24, alpha};
    const auto back = ellipse_from_conic(-3.7 * conic_from_ellipse(e));
    REQUIRE(back);
    CHECK(back->u_px == Approx(e.u_px));
    CHECK(back->v_px == Approx(e.v_px));
    CHECK(back->a_px == Approx(e.a_px));
    CHECK(back->b_px == Approx(e.b_px));
    CHECK(back->alpha_rad == Approx(e.alpha_rad).margin(1e-9));
  }
}

TEST_CASE("a conic that is no ellipse gives nothing") {
  CHECK_FALSE(ellipse_from_conic(Eigen::Vector3d(1, -1, -1).asDiagonal()));
  CHECK_FALSE(ellipse_from_conic(Eigen::Vector3d(1, 1, 1).asDiagonal()));
  CHECK_FALSE(ellipse_from_conic(Eigen::Matrix3d::Constant(std::numeric_limits<double>::quiet_NaN())));
}

TEST_CASE("normalized puts the major axis first and alpha between -pi/2 and pi/2") {
  const Ellipse e = normalized({0, 0, 10, 20, 0.1 + 2 * pi});
  CHECK(e.a_px == 20);
  CHECK(e.b_px == 10);
  CHECK(e.alpha_rad == Approx(0.1 - pi / 2));
}

TEST_CASE("points of an ellipse satisfy eq. (4) and its conic") {
  const Ellipse e{100, 50, 30, 12, 0.4};
  for (double t = 0; t < 6; t += 0.5) {
    const Eigen::Vector2d p = point_at(e, t);
    CHECK(normalized_radius_squared(e, p) == Approx(1));
    CHECK(p.homogeneous().dot(conic_from_ellipse(e) * p.homogeneous()) == Approx(0).margin(1e-9));
  }
  CHECK(normalized_radius_squared(e, {e.u_px, e.v_px}) == 0);
}

TEST_CASE("alpha is clockwise: from +u towards +v") {
  const Eigen::Vector2d tip = point_at({0, 0, 10, 1, 0.5}, 0);
  CHECK(tip.x() > 0);
  CHECK(tip.y() > 0);
}

TEST_CASE("perimeter of a circle and of a flat ellipse") {
  CHECK(perimeter_px({0, 0, 7, 7, 0}) == Approx(14 * pi));
  CHECK(perimeter_px({0, 0, 10, 1, 0}) == Approx(40.6397418).epsilon(1e-4));
}
