#include "pose_proc/metric_size.hpp"

#include <catch2/catch.hpp>

using namespace stevedore;

namespace {

/// A round thing of this radius on a level deck so far below the camera, taken for a circle of 0.5 m.
SupposedCircle thing(double x_m, double y_m, double radius_m, double coverage = 1, double depth_m = 4) {
  const Eigen::Vector3d center_m(x_m, y_m, depth_m);
  return {center_m * 0.5 / radius_m, -Eigen::Vector3d::UnitZ(), coverage};
}

SupposedCircle with_cargo(SupposedCircle circle) {
  circle.holds_cargo = true;
  return circle;
}

}  // namespace

TEST_CASE("a smaller thing on the circles' deck is none, one a hundredth off is") {
  CHECK(have_marks_size({thing(0, 0, 0.5), thing(1.5, 0, 0.505), thing(0, 1.5, 0.3),
                         thing(1.5, 1.5, 0.495)}) == std::vector<bool>{true, true, false, true});
}

TEST_CASE("circles outvote a larger thing") {
  CHECK(have_marks_size({thing(0, 0, 0.9, 0.4), thing(1.5, 0, 0.5), thing(0, 1.5, 0.5)}) ==
        std::vector<bool>{false, true, true});
}

TEST_CASE("one circle of which two thirds are seen outweighs two smaller things alike") {
  CHECK(have_marks_size({thing(1.5, 0, 0.3), thing(0, 1.5, 0.3), thing(0, 0, 0.5, 0.7)}) ==
        std::vector<bool>{false, false, true});
}

TEST_CASE("a circle that holds a cargo outweighs an empty larger arc") {
  const SupposedCircle arc = thing(0, 0, 0.65, 0.5), circle = thing(1.5, 0, 0.5, 0.7);
  CHECK(have_marks_size({arc, circle}) == std::vector<bool>{true, false});
  CHECK(have_marks_size({arc, with_cargo(circle)}) == std::vector<bool>{false, true});
}

TEST_CASE(
    "a circle on another platform may lie a metre lower, a smaller thing beside the circles may not seem "
    "to") {
  const SupposedCircle circle = thing(-4, 0, 0.5, 1, 6);
  CHECK(have_marks_size({circle, thing(-4, 1.5, 0.5, 1, 6), thing(4, 0, 0.5, 1, 7)}) ==
        std::vector<bool>{true, true, true});
  CHECK(have_marks_size({circle, thing(-4, 1.5, 0.5, 1, 6), thing(-3, 0, 0.43, 1, 6)}) ==
        std::vector<bool>{true, true, false});
}

TEST_CASE("a thing by itself may be a circle, and nothing is nothing") {
  CHECK(have_marks_size({thing(0, 0, 0.2)}) == std::vector<bool>{true});
  CHECK(have_marks_size({}).empty());
}
