#include "geometry/lens.hpp"

#include <Eigen/LU>
#include <algorithm>

namespace stevedore {
namespace {

/// As many points as go through together: whole vector registers, and little waste on a short edge.
constexpr int lanes = 8;

/// Bent rays and the entries of d bent / d ideal, point by point.
template <class Lanes>
struct Bent {
  Lanes x, y, x_by_x, x_by_y, y_by_x, y_by_y;
};

template <class Lanes>
Bent<Lanes> plumb_bob(const std::vector<double>& k, const Lanes& x, const Lanes& y) {
  const double k1 = k[0], k2 = k[1], p1 = k[2], p2 = k[3], k3 = k[4];
  const Lanes r2 = x * x + y * y;
  const Lanes radial = 1 + r2 * (k1 + r2 * (k2 + r2 * k3));
  const Lanes radial_slope = 2 * (k1 + r2 * (2 * k2 + r2 * 3 * k3));  // d radial / d x over x
  const Lanes across = x * y * radial_slope + 2 * p1 * x + 2 * p2 * y;
  return {x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
          y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
          radial + x * x * radial_slope + 2 * p1 * y + 6 * p2 * x,
          across,
          across,
          radial + y * y * radial_slope + 6 * p1 * y + 2 * p2 * x};
}

template <class Lanes>
Bent<Lanes> equidistant(const std::vector<double>& k, const Lanes& x, const Lanes& y) {
  constexpr double on_axis = 1e-9;  // the quotients below would be 0 / 0; here they are within 1e-18 of 1
  const Lanes r = (x * x + y * y).sqrt().max(on_axis);
  const Lanes angle = r.atan(), a2 = angle * angle;
  const Lanes bent = angle * (1 + a2 * (k[0] + a2 * (k[1] + a2 * (k[2] + a2 * k[3]))));
  const Lanes by_angle = 1 + a2 * (3 * k[0] + a2 * (5 * k[1] + a2 * (7 * k[2] + a2 * 9 * k[3])));
  const Lanes ratio = bent / r;
  const Lanes ratio_slope = (by_angle / (1 + r * r) - ratio) / (r * r);  // d ratio / d x over x
  const Lanes across = x * y * ratio_slope;
  return {x * ratio, y * ratio, ratio + x * x * ratio_slope, across, across, ratio + y * y * ratio_slope};
}

template <class Lanes>
Bent<Lanes> bend(const CameraModel& camera, const Lanes& x, const Lanes& y) {
  if (camera.distortion == Distortion::plumb_bob) return plumb_bob(camera.coefficients, x, y);
  if (camera.distortion == Distortion::equidistant) return equidistant(camera.coefficients, x, y);
  const Lanes one = Lanes::Ones(), zero = Lanes::Zero();
  return {x, y, one, zero, zero, one};
}

template <class Lanes>
struct Straightened {
  Lanes x, y;
  Bent<Lanes> bent;  ///< of the result: its derivative's inverse is the result's
  Eigen::Array<bool, Lanes::RowsAtCompileTime, 1> valid;
};

/// Newton from the bent ray. For barrel lenses that is on the axis' side of the answer, where the models are
/// monotone and each step stops short of it; ten steps are twice what 1e-9 px takes at the corner of a
/// 120-degree lens. Where the determinant is not positive the lens has folded back.
template <class Lanes>
Straightened<Lanes> straighten(const CameraModel& camera, const Lanes& bent_x, const Lanes& bent_y) {
  constexpr int steps = 10;
  const double done = 1e-9 / std::max(camera.given.fx_px, camera.given.fy_px);
  Straightened<Lanes> s{bent_x, bent_y, {}, {}};
  for (int i = 0;; ++i) {
    s.bent = bend(camera, s.x, s.y);
    const Bent<Lanes>& b = s.bent;
    const Lanes miss_x = b.x - bent_x, miss_y = b.y - bent_y;
    const Lanes determinant = b.x_by_x * b.y_by_y - b.x_by_y * b.y_by_x;
    s.valid = miss_x.abs().max(miss_y.abs()) < done && determinant > 0;
    if (i == steps || s.valid.all()) return s;
    s.x -= (b.y_by_y * miss_x - b.x_by_y * miss_y) / determinant;
    s.y -= (b.x_by_x * miss_y - b.y_by_x * miss_x) / determinant;
  }
}

using OneLane = Eigen::Array<double, 1, 1>;

Eigen::Matrix2d jacobian_of(const Bent<OneLane>& b) {
  return (Eigen::Matrix2d() << b.x_by_x[0], b.x_by_y[0], b.y_by_x[0], b.y_by_y[0]).finished();
}

Eigen::Vector2d focal_px(const Pinhole& pinhole) {
  return {pinhole.fx_px, pinhole.fy_px};
}

}  // namespace

MappedPoint distort_ray(const CameraModel& camera, const Eigen::Vector2d& ideal) {
  const auto bent = bend<OneLane>(camera, OneLane(ideal.x()), OneLane(ideal.y()));
  return {{bent.x[0], bent.y[0]}, jacobian_of(bent)};
}

std::optional<MappedPoint> undistort_ray(const CameraModel& camera, const Eigen::Vector2d& bent) {
  const auto straight = straighten<OneLane>(camera, OneLane(bent.x()), OneLane(bent.y()));
  if (!straight.valid[0]) return std::nullopt;
  return MappedPoint{{straight.x[0], straight.y[0]}, jacobian_of(straight.bent).inverse()};
}

std::optional<ProjectedPoint> project(const CameraModel& camera, const Eigen::Vector3d& point_camera_m) {
  const double z = point_camera_m.z();
  if (!(z > 0)) return std::nullopt;
  const Eigen::Vector2d ray = point_camera_m.head<2>() / z;
  const MappedPoint bent = distort_ray(camera, ray);
  Eigen::Matrix<double, 2, 3> ray_by_point;
  ray_by_point << 1 / z, 0, -ray.x() / z, 0, 1 / z, -ray.y() / z;
  return ProjectedPoint{camera.given.project(bent.point.homogeneous()),
                        focal_px(camera.given).asDiagonal() * bent.jacobian * ray_by_point};
}

std::optional<MappedPoint> unproject(const CameraModel& camera, const Eigen::Vector2d& given_px) {
  auto ray = undistort_ray(camera, camera.given.unproject(given_px).head<2>());
  if (ray) ray->jacobian = (ray->jacobian * focal_px(camera.given).cwiseInverse().asDiagonal()).eval();
  return ray;
}

IdealPoints undistort_points(const CameraModel& camera, const Eigen::Matrix2Xd& given_px) {
  using Lanes = Eigen::Array<double, lanes, 1>;
  const Pinhole &given = camera.given, &ideal = camera.rectified;
  const Eigen::Index count = given_px.cols();
  IdealPoints out{Eigen::Matrix2Xd(2, count), Eigen::Array<bool, 1, Eigen::Dynamic>(count)};
  for (Eigen::Index first = 0; first < count; first += lanes) {
    const Eigen::Index n = std::min<Eigen::Index>(lanes, count - first);
    Lanes x = Lanes::Zero(), y = Lanes::Zero();  // what fills the last block up is the axis
    x.head(n) = (given_px.row(0).segment(first, n).transpose().array() - given.cx_px) / given.fx_px;
    y.head(n) = (given_px.row(1).segment(first, n).transpose().array() - given.cy_px) / given.fy_px;
    const auto s = straighten<Lanes>(camera, x, y);
    const auto put = [&](auto&& row, const Lanes& values) {
      row.segment(first, n) = values.head(n).transpose().matrix();
    };
    put(out.point_px.row(0), s.x * ideal.fx_px + ideal.cx_px);
    put(out.point_px.row(1), s.y * ideal.fy_px + ideal.cy_px);
    out.valid.segment(first, n) = s.valid.head(n).transpose();
  }
  return out;
}

}  // namespace stevedore
