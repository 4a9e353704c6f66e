#include "pose_proc/plane_fit.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace stevedore {
namespace {

/// The plane is l.x = 1 for points on it: three numbers without a constraint, l = normal / (normal.centre).
/// A mark on it is the ray (x, y, 1) of its centre, and the logarithm of inner over outer radius.
struct MarkState {
  Eigen::Vector2d ray;
  double log_ratio = 0;
};

struct State {
  Eigen::Vector3d plane;
  std::vector<MarkState> marks;
};

Eigen::Vector3d normal_of(const Eigen::Vector3d& plane) {
  return -plane.normalized();  // the plane is in front, so that l points away from the camera
}

Eigen::Vector3d center_of(const Eigen::Vector3d& plane, const MarkState& mark) {
  const Eigen::Vector3d ray = mark.ray.homogeneous();
  return ray / plane.dot(ray);
}

Eigen::Matrix3d normal_by_plane(const Eigen::Vector3d& plane) {
  const Eigen::Vector3d n = normal_of(plane);
  return (n * n.transpose() - Eigen::Matrix3d::Identity()) / plane.norm();
}

/// d centre / d (plane, ray).
Eigen::Matrix<double, 3, 5> center_by_state(const Eigen::Vector3d& plane, const MarkState& mark) {
  const Eigen::Vector3d ray = mark.ray.homogeneous();
  const double inverse_depth = plane.dot(ray);
  Eigen::Matrix<double, 3, 5> out;
  out.leftCols<3>() = -ray * ray.transpose() / (inverse_depth * inverse_depth);
  out.rightCols<2>() =
      (Eigen::Matrix3d::Identity() - ray * plane.transpose() / inverse_depth).leftCols<2>() / inverse_depth;
  return out;
}

/// An edge with its residuals made equal and independent by the inverse root of its covariance.
struct WhiteEdge {
  Vector5d value;
  Matrix5d whiten;
};

std::optional<WhiteEdge> white(const EdgeImage& edge) {
  const Eigen::LLT<Matrix5d> factor(edge.covariance);
  if (factor.info() != Eigen::Success) return std::nullopt;
  WhiteEdge out{edge.value, factor.matrixL().solve(Matrix5d::Identity())};
  return out.whiten.allFinite() ? std::optional(out) : std::nullopt;
}

struct WhiteMark {
  WhiteEdge outer;
  std::optional<WhiteEdge> inner;
  double radius_m;
};

/// One mark's normal equations, in (plane 3, ray 2, log ratio).
struct Equations {
  Eigen::Matrix<double, 6, 6> matrix = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
  double chi_squared = 0;
};

void add_edge(Equations& equations, const WhiteEdge& edge, double radius_m, const Eigen::Vector3d& plane,
              const MarkState& mark, bool inner) {
  const CircleImage image = circle_image(center_of(plane, mark), normal_of(plane), radius_m);
  Eigen::Matrix<double, 5, 6> jacobian;
  jacobian.leftCols<5>() = image.by_center * center_by_state(plane, mark);
  jacobian.leftCols<3>() += image.by_normal * normal_by_plane(plane);
  jacobian.col(5) = inner ? Vector5d(image.by_radius * radius_m) : Vector5d(Vector5d::Zero());
  const Eigen::Matrix<double, 5, 6> rows = edge.whiten.triangularView<Eigen::Lower>() * jacobian;
  const Vector5d left = edge.whiten.triangularView<Eigen::Lower>() * (edge.value - image.value);
  equations.matrix.noalias() += rows.transpose() * rows;
  equations.right.noalias() += rows.transpose() * left;
  equations.chi_squared += left.squaredNorm();
}

Equations equations_of(const WhiteMark& mark, const Eigen::Vector3d& plane, const MarkState& state) {
  Equations equations;
  add_edge(equations, mark.outer, mark.radius_m, plane, state, false);
  if (mark.inner)
    add_edge(equations, *mark.inner, mark.radius_m * std::exp(state.log_ratio), plane, state, true);
  else
    equations.matrix(5, 5) = 1;  // no such unknown
  return equations;
}

/// A mark's own unknowns as they follow from the plane's step: own = free - by_plane * step.
struct Eliminated {
  Eigen::Matrix3d by_plane, own_covariance;
  Eigen::Vector3d free;
};

struct Reduced {
  Eigen::Matrix3d matrix = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  std::vector<Eliminated> marks;
  double chi_squared = 0;
};

Reduced reduce(const std::vector<WhiteMark>& marks, const State& state) {
  Reduced out;
  out.marks.reserve(marks.size());
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const Equations e = equations_of(marks[i], state.plane, state.marks[i]);
    const Eigen::Matrix3d own = e.matrix.bottomRightCorner<3, 3>().inverse();
    const Eigen::Matrix3d shared = e.matrix.bottomLeftCorner<3, 3>();
    const Eliminated mark{own * shared, own, own * e.right.tail<3>()};
    out.matrix += e.matrix.topLeftCorner<3, 3>() - shared.transpose() * mark.by_plane;
    out.right += e.right.head<3>() - shared.transpose() * mark.free;
    out.chi_squared += e.chi_squared;
    out.marks.push_back(mark);
  }
  return out;
}

/// The step that Gauss and Newton take, and its length in standard deviations of the plane.
double advance(State& state, const Reduced& reduced, const Eigen::Matrix3d& plane_covariance) {
  const Eigen::Vector3d step = plane_covariance * reduced.right;
  const double length2 = step.dot(reduced.right);
  for (std::size_t i = 0; i < state.marks.size(); ++i) {
    const Eliminated& mark = reduced.marks[i];
    const Eigen::Vector3d own = mark.free - mark.by_plane * step;
    state.marks[i].ray += own.head<2>();
    state.marks[i].log_ratio += own.z();
  }
  state.plane += step;
  return std::sqrt(std::max(length2, 0.0));
}

PlaneFit result_of(const State& state, const Reduced& reduced, const Eigen::Matrix3d& plane_covariance) {
  PlaneFit fit;
  fit.normal_camera = normal_of(state.plane);
  const Eigen::Matrix3d by_plane = normal_by_plane(state.plane);
  fit.normal_covariance_rad2 = by_plane * plane_covariance * by_plane.transpose();
  fit.chi_squared = reduced.chi_squared;
  for (std::size_t i = 0; i < state.marks.size(); ++i) {
    const Eliminated& mark = reduced.marks[i];
    const Eigen::Matrix<double, 2, 3> follows = -mark.by_plane.topRows<2>();
    Eigen::Matrix<double, 5, 5> joint;
    joint.topLeftCorner<3, 3>() = plane_covariance;
    joint.bottomLeftCorner<2, 3>() = follows * plane_covariance;
    joint.topRightCorner<3, 2>() = joint.bottomLeftCorner<2, 3>().transpose();
    joint.bottomRightCorner<2, 2>() =
        mark.own_covariance.topLeftCorner<2, 2>() + follows * plane_covariance * follows.transpose();
    const Eigen::Matrix<double, 3, 5> jacobian = center_by_state(state.plane, state.marks[i]);
    fit.center_camera_m.push_back(center_of(state.plane, state.marks[i]));
    fit.covariance_m2.emplace_back(jacobian * joint * jacobian.transpose());
  }
  return fit;
}

bool in_front(const State& state) {
  for (const MarkState& mark : state.marks)
    if (!(state.plane.dot(mark.ray.homogeneous()) > 0)) return false;
  return true;
}

/// log(inner / outer) from the areas of the two images, near enough to begin with.
double log_ratio_of(const PlaneMark& mark) {
  if (!mark.inner) return 0;
  const auto area2 = [](const Vector5d& v) { return v[2] * v[4] - v[3] * v[3]; };
  return std::log(area2(mark.inner->value) / area2(mark.outer.value)) / 4;
}

}  // namespace

std::optional<PlaneFit> fit_plane(const std::vector<PlaneMark>& marks,
                                  const Eigen::Vector3d& start_normal_camera) {
  // from starts within a few sigma two steps do; ten say that it wanders
  constexpr int most_steps = 10;
  constexpr double settled_sigmas = 0.01;
  std::vector<WhiteMark> white_marks;
  State state;
  double inverse_distance = 0;  // of the plane, the marks' mean
  int freedom = -3;
  for (const PlaneMark& mark : marks) {
    const auto outer = white(mark.outer);
    const auto inner = mark.inner ? white(*mark.inner) : std::nullopt;
    if (!outer) return std::nullopt;
    white_marks.push_back({*outer, inner, mark.radius_m});
    state.marks.push_back({mark.start_center_camera_m.hnormalized(), log_ratio_of(mark)});
    inverse_distance +=
        1 / start_normal_camera.dot(mark.start_center_camera_m) / static_cast<double>(marks.size());
    freedom += inner ? 10 - 3 : 5 - 2;
  }
  state.plane = start_normal_camera * inverse_distance;
  for (int i = 0; i < most_steps && in_front(state); ++i) {
    const Reduced reduced = reduce(white_marks, state);
    const Eigen::Matrix3d plane_covariance = reduced.matrix.inverse();
    if (!plane_covariance.allFinite() || (plane_covariance.diagonal().array() <= 0).any())
      return std::nullopt;
    const State before = state;
    if (advance(state, reduced, plane_covariance) > settled_sigmas || i == 0) continue;
    PlaneFit fit = result_of(before, reduced, plane_covariance);
    fit.freedom = freedom;
    return fit;
  }
  return std::nullopt;
}

}  // namespace stevedore
