#include "mission_proc/hanging.hpp"

#include <algorithm>
#include <cmath>

namespace stevedore {

void Hanging::hear(const Eigen::Quaterniond& ned_from_body, std::int64_t utime) {
  constexpr double mean_over_s = 3;  // two swings of the rope, a few corrections of the pilot's
  const double passed_s = utime_ > 0 ? static_cast<double>(utime - utime_) * 1e-6 : mean_over_s;
  const double share = std::clamp(passed_s / mean_over_s, 0.0, 1.0);
  const Eigen::Matrix3d axes = ned_from_body.toRotationMatrix();
  mean_down_ned_ = (mean_down_ned_ + share * (axes.col(2) - mean_down_ned_)).normalized();
  heading_rad_ = std::atan2(axes(1, 0), axes(0, 0));
  utime_ = utime;
}

Eigen::Vector3d Hanging::hook_ned_m(bool loaded) const {
  const Eigen::Vector3d down = Eigen::Vector3d::UnitZ(), lean = mean_down_ned_ - down;
  const Eigen::Vector3d rope =
      (down + (loaded ? settings_.loaded_lean : settings_.empty_lean) * lean).normalized();
  const Eigen::Vector3d ahead(std::cos(heading_rad_), std::sin(heading_rad_), 0);
  const Eigen::Vector3d right(-ahead.y(), ahead.x(), 0);
  return settings_.hook_forward_m * ahead + settings_.hook_right_m * right +
         settings_.hook_down_m * mean_down_ned_ + settings_.rope_m * rope;
}

}  // namespace stevedore
