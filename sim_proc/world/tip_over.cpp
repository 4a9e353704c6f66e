#include "sim_proc/world/tip_over.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "sim_proc/world/gravity.hpp"

namespace stevedore::world {
namespace {

/// Leaning by less, the whole base meets the floor at once: 0.5 deg, 2 mm of 0.26 m, about a deck's
/// unevenness.
constexpr double flat_sine = 0.009;

/// Turning about an edge of its base. Per kilogram.
struct Rocking {
  Eigen::Vector3d edge_to_center_m;
  Eigen::Vector3d up;  ///< against gravity
  double inertia_m2;   ///< about the edge

  [[nodiscard]] double height_m() const { return edge_to_center_m.dot(up); }
  [[nodiscard]] double energy_to_tip() const { return gravity_mps2 * (edge_to_center_m.norm() - height_m()); }
  [[nodiscard]] bool tips(double rate_radps) const {
    return inertia_m2 * rate_radps * rate_radps / 2 >= energy_to_tip();
  }
};

/// Standing flat and turning about the edge on the side of `towards`.
Rocking flat(const Bucket& bucket, const Touchdown& t, const Eigen::Vector3d& towards) {
  const double height_m = center_height_m(bucket), radius_m = bucket.base_radius_m;
  return {height_m * t.floor_up - radius_m * towards, -t.gravity_down,
          inertia_m2(bucket) + height_m * height_m + radius_m * radius_m};
}

Landing judged(bool tips, const Eigen::Vector3d& towards) {
  return tips ? Landing{false, towards} : Landing{};
}

Landing land_flat(const Bucket& bucket, const Touchdown& t) {
  const double height_m = center_height_m(bucket);
  const Eigen::Vector3d sideways_mps = t.velocity_mps - t.velocity_mps.dot(t.floor_up) * t.floor_up;
  // of the centre's way and of the spin: towards where the rim goes
  const Eigen::Vector3d momentum =
      height_m * sideways_mps + inertia_m2(bucket) * t.spin_radps.cross(t.floor_up);
  if (momentum.norm() < 1e-9) return {};
  const Eigen::Vector3d towards = momentum.normalized();
  const Rocking rocking = flat(bucket, t, towards);
  return judged(rocking.tips(momentum.norm() / rocking.inertia_m2), towards);
}

/// It has come back upright, turning: on about the edge opposite to the one that it leant over.
Landing slap_down(const Bucket& bucket, const Touchdown& t, const Eigen::Vector3d& lean, double rate_radps) {
  const double height_m = center_height_m(bucket), radius_m = bucket.base_radius_m;
  const Rocking rocking = flat(bucket, t, -lean);
  const double kept = (inertia_m2(bucket) + height_m * height_m - radius_m * radius_m) / rocking.inertia_m2;
  return judged(rocking.tips(std::max(0.0, kept) * rate_radps), -lean);
}

}  // namespace

double center_height_m(const Bucket& bucket) {
  return bucket.height_m / 2;
}

double inertia_m2(const Bucket& bucket) {
  const double radius_m = (bucket.base_radius_m + bucket.rim_radius_m) / 2;
  return radius_m * radius_m / 2 + bucket.height_m * bucket.height_m / 12;
}

Landing land(const Bucket& bucket, const Touchdown& t) {
  const double cosine = t.axis.dot(t.floor_up);
  const Eigen::Vector3d sideways = t.axis - cosine * t.floor_up;
  const double sine = sideways.norm();
  if (cosine > 0 && sine < flat_sine) return land_flat(bucket, t);
  if (cosine <= 0) return {false, sine > 0 ? Eigen::Vector3d(sideways / sine) : t.axis.unitOrthogonal()};

  const Eigen::Vector3d lean = sideways / sine;
  const Eigen::Vector3d to_edge = cosine * lean - sine * t.floor_up;  // along the base, to its lowest point
  const Eigen::Vector3d arm_m = center_height_m(bucket) * t.axis - bucket.base_radius_m * to_edge;
  const Rocking rocking{arm_m, -t.gravity_down, inertia_m2(bucket) + arm_m.squaredNorm()};
  const Eigen::Vector3d momentum = arm_m.cross(t.velocity_mps) + inertia_m2(bucket) * t.spin_radps;
  const double rate_radps = momentum.dot(t.floor_up.cross(lean)) / rocking.inertia_m2;  // > 0: leans more
  const bool past_the_edge = arm_m.dot(lean) - arm_m.dot(t.gravity_down) * t.gravity_down.dot(lean) > 0;
  if (past_the_edge || rate_radps > 0) return judged(past_the_edge || rocking.tips(rate_radps), lean);

  const double fall_m = rocking.height_m() - flat(bucket, t, lean).height_m();
  const double upright_radps =
      std::sqrt(std::max(0.0, rate_radps * rate_radps + 2 * gravity_mps2 * fall_m / rocking.inertia_m2));
  return slap_down(bucket, t, lean, upright_radps);
}

}  // namespace stevedore::world
