// Which round things have a painted circle's size: all that lie on one deck must say so together.
#pragma once

#include <Eigen/Core>
#include <vector>

namespace stevedore {

/// What the image calls a circle, solved as one of the known radius.
struct SupposedCircle {
  Eigen::Vector3d center_camera_m;
  Eigen::Vector3d normal_camera;  ///< of the deck it lies on, as well as is known; unit
  double coverage = 1;            ///< share of its edge that was found
  bool holds_cargo = false;       ///< a rim was found in it
};

/// For each: whether it may be a circle of that radius. A smaller thing, taken for a circle, seems to lie
/// below the deck by as much as it is smaller. The deck is where most circles agree, the better seen ones
/// and those that hold a cargo counting more; where few do it is the nearer one, because marks are the
/// largest round things on a deck. A thing by itself may be one.
std::vector<bool> have_marks_size(const std::vector<SupposedCircle>& circles);

}  // namespace stevedore
