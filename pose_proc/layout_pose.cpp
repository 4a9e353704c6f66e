#include "pose_proc/layout_pose.hpp"

#include <Eigen/Dense>
#include <cmath>

namespace stevedore {
namespace {

struct Frame {
  Eigen::Matrix3d camera_from_deck;
  Eigen::Vector3d origin_camera_m;
};

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  return (Eigen::Matrix3d() << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0).finished();
}

Eigen::Vector3d on_deck(const LayoutMark& mark) {
  return {mark.place_deck_m.x(), mark.place_deck_m.y(), 0};
}

/// The turn in the plane that fits the centres best (Kabsch 1976, in two dimensions), and the origin.
Frame start_of(const std::vector<LayoutMark>& marks, const Eigen::Vector3d& normal) {
  const Eigen::Vector3d x = normal.unitOrthogonal(), y = (-normal).cross(x);
  Eigen::Vector3d mean_camera_m = Eigen::Vector3d::Zero(), mean_deck_m = Eigen::Vector3d::Zero();
  for (const LayoutMark& mark : marks) {
    mean_camera_m += mark.start_center_camera_m / static_cast<double>(marks.size());
    mean_deck_m += on_deck(mark) / static_cast<double>(marks.size());
  }
  double along = 0, across = 0;
  for (const LayoutMark& mark : marks) {
    const Eigen::Vector3d seen = mark.start_center_camera_m - mean_camera_m,
                          plan = on_deck(mark) - mean_deck_m;
    const Eigen::Vector2d p(x.dot(seen), y.dot(seen));
    along += plan.x() * p.x() + plan.y() * p.y();
    across += plan.x() * p.y() - plan.y() * p.x();
  }
  Eigen::Matrix3d plane;
  plane << x, y, -normal;
  Frame frame{
      plane * Eigen::AngleAxisd(std::atan2(across, along), Eigen::Vector3d::UnitZ()).toRotationMatrix(), {}};
  frame.origin_camera_m = mean_camera_m - frame.camera_from_deck * mean_deck_m;
  return frame;
}

struct Equations {
  Eigen::Matrix<double, 6, 6> matrix = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
  double chi_squared = 0;
};

void add(Equations& equations, const LayoutMark& mark, const Frame& frame) {
  const Eigen::Vector3d arm = frame.camera_from_deck * on_deck(mark);
  const Eigen::Vector3d normal = -frame.camera_from_deck.col(2);
  const CircleImage image = circle_image(frame.origin_camera_m + arm, normal, mark.radius_m);
  Eigen::Matrix<double, 5, 6> jacobian;
  jacobian << -image.by_center * cross(arm) - image.by_normal * cross(normal), image.by_center;
  const Eigen::LLT<Matrix5d> noise(mark.outer.covariance);
  const Eigen::Matrix<double, 5, 6> rows = noise.matrixL().solve(jacobian);
  const Vector5d left = noise.matrixL().solve(mark.outer.value - image.value);
  equations.matrix += rows.transpose() * rows;
  equations.right += rows.transpose() * left;
  equations.chi_squared += left.squaredNorm();
}

}  // namespace

std::optional<LayoutPose> layout_pose(const std::vector<LayoutMark>& marks,
                                      const Eigen::Vector3d& start_normal_camera) {
  constexpr int most_steps = 15;  // three do; more say that marks and plan don't belong together
  constexpr double settled_sigmas2 = 1e-4;
  if (marks.size() < 2) return std::nullopt;
  Frame frame = start_of(marks, start_normal_camera);
  for (int i = 0; i < most_steps; ++i) {
    Equations equations;
    for (const LayoutMark& mark : marks) add(equations, mark, frame);
    const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> factor(equations.matrix);
    const Eigen::Matrix<double, 6, 1> step = factor.solve(equations.right);
    if (!step.allFinite() || !factor.isPositive()) return std::nullopt;
    if (step.dot(equations.right) < settled_sigmas2)
      return LayoutPose{frame.camera_from_deck, frame.origin_camera_m,
                        factor.solve(Eigen::Matrix<double, 6, 6>::Identity()), equations.chi_squared,
                        5 * static_cast<int>(marks.size()) - 6};
    const double turn = step.head<3>().norm();
    if (turn > 0)
      frame.camera_from_deck =
          Eigen::AngleAxisd(turn, step.head<3>() / turn).toRotationMatrix() * frame.camera_from_deck;
    frame.origin_camera_m += step.tail<3>();
  }
  return std::nullopt;
}

}  // namespace stevedore
