#include "pose_proc/ring_pose.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "pose_proc/plane_fit.hpp"

namespace stevedore {
namespace {

/// 99.9 % of chi squared with the four degrees of freedom that a ring leaves, for covariances that are right,
/// and as much again for those that say half of the standard deviation.
constexpr double most_chi_squared = 18.5 * 4;

/// A shadow or a rim along the inner edge moves its centre, one time in a hundred, by enough to mislead.
constexpr double misled = 0.01;

CircleSolution solution_of(const PlaneFit& fit) {
  return {fit.center_camera_m[0], fit.normal_camera, fit.covariance_m2[0], fit.normal_covariance_rad2};
}

/// Log-odds capped by the chance of being misled.
double bounded(double log_odds) {
  const double p = misled / 2 + (1 - misled) / (1 + std::exp(-log_odds));
  return std::log(p / (1 - p));
}

double spread(const CircleSolution& circle) {
  return circle.normal_covariance_rad2.trace();
}

/// The two closed-form solutions are within their noise of each other. That noise is not Gaussian there, and
/// a fit of either does not know.
bool merged(const std::array<CircleSolution, 2>& pair) {
  constexpr double sigmas2 = 4 * 4;
  return (pair[0].normal_camera - pair[1].normal_camera).squaredNorm() <
         sigmas2 * (spread(pair[0]) + spread(pair[1])) / 2;
}

bool same(const CircleSolution& a, const CircleSolution& b) {
  return (a.normal_camera - b.normal_camera).squaredNorm() < std::min(spread(a), spread(b)) / 4;
}

/// How much less likely than the fit's normal another one is, as half a chi squared.
double half_distance2(const CircleSolution& fit, const CircleSolution& other) {
  const Eigen::Vector3d off = other.normal_camera - fit.normal_camera;
  const Eigen::Matrix3d noise = fit.normal_covariance_rad2 + other.normal_covariance_rad2 +
                                1e-12 * Eigen::Matrix3d::Identity();  // along the normal there is none
  return off.dot(noise.inverse() * off) / 2;
}

/// Both starts led to one circle: it takes the place of the nearer one.
RingPose one_circle(const CircleSolution& fit, const std::array<CircleSolution, 2>& start) {
  const auto distance2 = [&](std::size_t i) {
    return (start[i].normal_camera - fit.normal_camera).squaredNorm();
  };
  const std::size_t mine = distance2(0) <= distance2(1) ? 0 : 1;
  RingPose ring{start, 0};
  if (spread(fit) < spread(start[mine])) ring.solutions[mine] = fit;
  const double against_other = half_distance2(fit, start[1 - mine]) - half_distance2(fit, start[mine]);
  ring.log_odds = bounded(mine == 0 ? against_other : -against_other);
  return ring;
}

}  // namespace

std::optional<RingPose> ring_pose(const EllipseFit& outer, const EllipseFit& inner, const Pinhole& camera,
                                  double radius_m, const std::array<CircleSolution, 2>& start) {
  if (!can_be_posed(inner, camera, radius_m)) return std::nullopt;
  PlaneMark mark{edge_image(outer, camera), edge_image(inner, camera), radius_m, {}};
  std::array<std::optional<CircleSolution>, 2> fits;
  std::array<double, 2> chi_squared{};
  for (std::size_t i = 0; i < 2; ++i) {
    mark.start_center_camera_m = start[i].center_camera_m;
    const auto fit = fit_plane({mark}, start[i].normal_camera);
    if (!fit || fit->chi_squared > most_chi_squared) continue;
    fits[i] = solution_of(*fit);
    chi_squared[i] = fit->chi_squared;
  }
  if (!fits[0] && !fits[1]) return std::nullopt;
  if (!fits[0] || !fits[1]) return one_circle(fits[0] ? *fits[0] : *fits[1], start);
  if (same(*fits[0], *fits[1])) return one_circle(*fits[0], start);
  RingPose ring{start, bounded((chi_squared[1] - chi_squared[0]) / 2)};
  if (!merged(start)) ring.solutions = {*fits[0], *fits[1]};
  return ring;
}

}  // namespace stevedore
