#include "pose_proc/tilt_posterior.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace stevedore {
namespace {

/// Nodes of an integral over a standard normal variable.
struct Rule {
  std::array<double, 12> at, weight;
  std::size_t count;
};

/// Gauss and Hermite's three: exact for polynomials up to the fifth degree.
constexpr Rule few{{-1.7320508075688772, 0, 1.7320508075688772}, {1.0 / 6, 2.0 / 3, 1.0 / 6}, 3};

/// From six sigma on, the root is as good as a polynomial over the noise, and the few nodes do.
constexpr double apart_sigmas = 6;

/// Else they are evenly spaced over all but a thousandth of the noise, one of them where the integrand has
/// its pole, that many sigma from the mean.
constexpr double spacing = 0.6, reach = 3.3;
constexpr double least_weight = 0.0043;  // that of a node at the reach: the corners beyond it are left out

Rule grid(double pole) {
  Rule rule{{}, {}, 0};
  double z = pole + spacing * std::ceil((-reach - pole) / spacing);
  for (; z <= reach && rule.count < rule.at.size(); z += spacing) {
    rule.at[rule.count] = z;
    rule.weight[rule.count++] = std::exp(-z * z / 2);
  }
  return rule;
}

struct Split {
  Eigen::Vector2d mean;
  Eigen::Matrix2d root;  ///< of its covariance
  Rule x, y;             ///< along the root's columns
  double cell;           ///< side of what a node stands for; 0 where the nodes carry a smooth function whole
};

Split split_of(const NoisyCone& cone) {
  constexpr double roundest = 1e-3;  // no noise of an edge is more lopsided; keeps the inverse finite
  const Eigen::Matrix2d covariance = cone.covariance.bottomRightCorner<2, 2>();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(covariance);
  Eigen::Vector2d deviations = eigen.eigenvalues().cwiseMax(0).cwiseSqrt();
  deviations[0] = std::max(deviations[0], roundest * deviations[1]);
  const Eigen::Vector2d mean(cone.split, 0);
  const Eigen::Matrix2d root = eigen.eigenvectors() * deviations.asDiagonal();
  if (cone.split >= apart_sigmas * deviations[1]) return {mean, root, few, few, 0};
  const Eigen::Vector2d pole = -(eigen.eigenvectors().transpose() * mean).cwiseQuotient(deviations);
  return {mean, root, grid(pole.x()), grid(pole.y()), spacing * std::sqrt(deviations[0] * deviations[1])};
}

/// A step of the split's noise. Far from zero its second component is a turn about the axis: for a flat
/// ellipse even a small one, taken along the tangent, would change the length.
Eigen::Vector2d moved(const Split& split, const Eigen::Vector2d& step) {
  if (split.cell > 0 || split.mean.x() == 0) return split.mean + step;
  return Eigen::Rotation2Dd(step.y() / split.mean.x()) * Eigen::Vector2d(split.mean.x() + step.x(), 0);
}

/// A circle of unit radius in the cone's frame, as it follows from split and mean. With t = (t, 0) in its own
/// direction: S_xx = n_z^2 / c_z^2 and c_x c_z = -t n_z, which the dual conic c c^T - (I - n n^T) gives.
struct UnitCircle {
  Eigen::Vector3d center, normal;
};

UnitCircle unit_circle(const Eigen::Vector2d& split, double mean) {
  const double length = split.norm(),
               narrow = std::max(mean, length / 2) + length / 2;  // P's larger eigenvalue
  const double t2 = length / (1 + narrow);
  const double half_cosine = length > 0 ? std::max(split.x() / length, -1.0) : 1;
  const double c = std::sqrt((1 + half_cosine) / 2),
               s = std::copysign(std::sqrt((1 - half_cosine) / 2), split.y());
  const Eigen::Vector2d t = std::sqrt(t2) * Eigen::Vector2d(c, s);
  const double facing = std::sqrt(1 - t2), depth = facing * std::sqrt(narrow);
  const Eigen::Vector2d across = t * (facing / depth);
  return {{across.x(), across.y(), depth}, {t.x(), t.y(), -facing}};
}

/// The same with t and everything across turned round.
UnitCircle opposite(const UnitCircle& circle) {
  return {{-circle.center.x(), -circle.center.y(), circle.center.z()},
          {-circle.normal.x(), -circle.normal.y(), circle.normal.z()}};
}

/// d vector / d (turn of the frame towards x, towards y).
Eigen::Matrix<double, 3, 2> by_turn(const Eigen::Vector3d& v) {
  Eigen::Matrix<double, 3, 2> out;
  out << v.z(), 0, 0, v.z(), -v.x(), -v.y();
  return out;
}

/// Turn and mean as they go with the split, and what is left of their covariance.
struct Rest {
  Eigen::Matrix<double, 3, 2> by_split;
  Eigen::Matrix3d covariance;
};

Rest rest_of(const NoisyCone& cone) {
  const Eigen::Matrix<double, 3, 2> shared = cone.covariance.topRightCorner<3, 2>();
  const Eigen::Matrix2d inverse =
      cone.covariance.bottomRightCorner<2, 2>().completeOrthogonalDecomposition().pseudoInverse();
  const Eigen::Matrix<double, 3, 2> by_split = shared * inverse;
  return {by_split, cone.covariance.topLeftCorner<3, 3>() - by_split * shared.transpose()};
}

/// Sums over the nodes.
struct Sums {
  double weight = 0, likelihood = 0;
  Eigen::Vector3d center = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
  Eigen::Matrix3d center2 = Eigen::Matrix3d::Zero(), normal2 = Eigen::Matrix3d::Zero();

  void add(double w, const Eigen::Vector3d& c, const Eigen::Vector3d& n, const UnitCircle& origin) {
    const Eigen::Vector3d dc = c - origin.center, dn = n - origin.normal;  // small beside the origin
    weight += w;
    center += w * dc;
    normal += w * dn;
    center2.noalias() += w * dc * dc.transpose();
    normal2.noalias() += w * dn * dn.transpose();
  }
};

/// d circle / d mean, the split staying as it is along x.
UnitCircle by_mean(const UnitCircle& circle, double narrow) {
  const double t = circle.normal.x(), facing = -circle.normal.z(), root = std::sqrt(narrow);
  const double t_step = -t / (2 * (1 + narrow)), facing_step = -t / facing * t_step;
  return {{(t_step - t / (2 * narrow)) / root, 0, facing_step * root + facing / (2 * root)},
          {t_step, 0, -facing_step}};
}

/// What the nodes don't spread over: the rest's own noise, at the mean of the split.
void add_rest(ConeCircle& circle, const Rest& rest, const UnitCircle& unit, double narrow, double radius_m) {
  const UnitCircle step = by_mean(unit, narrow);
  Eigen::Matrix3d center_by_rest, normal_by_rest;
  center_by_rest << by_turn(unit.center), step.center;
  normal_by_rest << by_turn(unit.normal), step.normal;
  circle.center_covariance_m2 +=
      radius_m * radius_m * center_by_rest * rest.covariance * center_by_rest.transpose();
  circle.normal_covariance_rad2 += normal_by_rest * rest.covariance * normal_by_rest.transpose();
}

ConeCircle circle_of(const Sums& sums, const UnitCircle& origin, double radius_m) {
  ConeCircle circle;
  const Eigen::Vector3d dc = sums.center / sums.weight, dn = sums.normal / sums.weight;
  circle.center_m = radius_m * (origin.center + dc);
  circle.normal = (origin.normal + dn).normalized();
  circle.center_covariance_m2 = radius_m * radius_m * (sums.center2 / sums.weight - dc * dc.transpose());
  circle.normal_covariance_rad2 = sums.normal2 / sums.weight - dn * dn.transpose();
  circle.likelihood = sums.likelihood / sums.weight;
  return circle;
}

}  // namespace

std::array<ConeCircle, 2> circles_on(const NoisyCone& cone, double radius_m,
                                     const std::optional<ExpectedNormal>& expected) {
  const Split split = split_of(cone);
  const Rest rest = rest_of(cone);
  const UnitCircle first = unit_circle(split.mean, cone.mean), second = opposite(first);
  const bool apart = split.cell == 0;
  // Uniform in the angle of tilt is |split|^(-3/2) on the plane of the split. At zero a node gets what its
  // cell has on average; 0.05 would be that of a round cell, this is that of what the coarse grid makes of
  // it: with it errors at zero tilt are as large as their covariance says.
  const double pole = 0.14 * split.cell * split.cell;
  const double cell_variance = std::pow(split.cell / (1 + cone.mean), 2) / 12;
  std::array<Sums, 2> sums;
  for (std::size_t i = 0; i < split.x.count; ++i)
    for (std::size_t j = 0; j < split.y.count; ++j) {
      const double gaussian = split.x.weight[i] * split.y.weight[j];
      if (gaussian < least_weight) continue;
      const Eigen::Vector2d step = split.root * Eigen::Vector2d(split.x.at[i], split.y.at[j]);
      const Eigen::Vector2d at = moved(split, step);
      const Eigen::Vector3d along = rest.by_split * step;
      const double length2 = at.squaredNorm() + pole;
      const double prior = length2 > 0 ? 1 / std::sqrt(length2 * std::sqrt(length2)) : 1;
      const double weight = gaussian * prior;
      const UnitCircle circle = unit_circle(at, std::max(cone.mean + along.z(), 1e-3 * cone.mean));
      const double t2 = circle.normal.head<2>().squaredNorm();
      const double spread = cell_variance > 0 ? cell_variance / (4 * t2 + std::sqrt(cell_variance)) : 0;
      for (std::size_t side = 0; side < 2; ++side) {
        const UnitCircle one = side == 0 ? circle : opposite(circle);
        const Eigen::Vector3d center = one.center + by_turn(one.center) * along.head<2>();
        const Eigen::Vector3d normal = one.normal + by_turn(one.normal) * along.head<2>();
        sums[side].add(weight, center, normal, side == 0 ? first : second);
        if (expected && !apart) sums[side].likelihood += weight * density(*expected, normal, spread);
      }
    }
  std::array<ConeCircle, 2> circles{circle_of(sums[0], first, radius_m),
                                    circle_of(sums[1], second, radius_m)};
  const double narrow = cone.mean + cone.split / 2;
  add_rest(circles[0], rest, first, narrow, radius_m);
  add_rest(circles[1], rest, second, narrow, radius_m);
  for (ConeCircle& circle : circles) {
    if (!expected)
      circle.likelihood = 1;
    else if (apart)
      circle.likelihood = density(*expected, circle.normal, circle.normal_covariance_rad2);
  }
  return circles;
}

}  // namespace stevedore
