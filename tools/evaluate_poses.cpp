#include "tools/evaluate_poses.hpp"

#include <fmt/format.h>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <set>

#include "pose_proc/common_error.hpp"

namespace stevedore {
namespace {

constexpr double deg = std::numbers::pi / 180;

double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

Eigen::Quaterniond quaternion(const double (&q)[4]) {
  return Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized();
}

Mark mark_at(const truth_t& truth, Mark::Kind kind, std::string name, const double (&center_ned_m)[3],
             const double (&normal_ned)[3], double radius_m) {
  const Eigen::Quaterniond camera_from_ned = quaternion(truth.ned_from_camera).conjugate();
  return {kind,
          std::move(name),
          camera_from_ned * (Eigen::Vector3d(center_ned_m) - Eigen::Vector3d(truth.camera_ned_m)),
          camera_from_ned * Eigen::Vector3d(normal_ned),
          radius_m,
          false};
}

bool is_measured(const pose_t& pose) {
  return pose.status == track_t::STATUS_TRACKING && pose.ellipse_index >= 0;
}

Eigen::Vector3d center_of(const circle_solution_t& solution) {
  return Eigen::Vector3d(solution.center_camera_m);
}

/// How far a pose is from a mark, in the mark's radii as it is seen; infinite where they can't be the same.
/// Judged by direction and apparent size alone, which hold whatever radius the pose assumes.
double misfit(const pose_t& pose, const Mark& mark) {
  constexpr double size_ratio = 1.5;  // circle and rim, 0.5 and 0.16 m, are a factor of 3.1 apart: half of it
  constexpr double direction_rad = 1 * deg;  // a principal point off by three times the world's 2 px
  const Eigen::Vector3d center_m = center_of(pose.solutions.front());
  const double seen_rad = pose.radius_m / center_m.norm();
  const double due_rad = mark.radius_m / mark.center_camera_m.norm();
  const double ratio = seen_rad / due_rad;
  if (!(ratio < size_ratio && ratio > 1 / size_ratio)) return std::numeric_limits<double>::infinity();
  const double off_rad = angle_between(center_m, mark.center_camera_m);
  // beyond half of its radius it is something beside it
  return off_rad > due_rad / 2 + direction_rad ? std::numeric_limits<double>::infinity() : off_rad / due_rad;
}

struct Fit {
  int mark = -1;  ///< -1: none
  double misfit = std::numeric_limits<double>::infinity();
  bool is_ambiguous = false;
};

Fit fit_of(const pose_t& pose, const std::vector<Mark>& marks) {
  Fit fit;
  double second = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < marks.size(); ++i) {
    const double here = misfit(pose, marks[i]);
    if (here < fit.misfit) {
      second = fit.misfit;
      fit.misfit = here;
      fit.mark = static_cast<int>(i);
    } else {
      second = std::min(second, here);
    }
  }
  // a tenth of a radius is what a direction can be off by errors common to both; twice as near is nearer
  fit.is_ambiguous = std::isfinite(second) && second < 2 * fit.misfit + 0.1;
  return fit;
}

/// Of the solution whose normal is nearest to the mark's.
std::size_t right_solution(const pose_t& pose, const Mark& mark) {
  std::size_t right = 0;
  double least_rad = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < pose.solutions.size(); ++i) {
    const double off_rad =
        angle_between(Eigen::Vector3d(pose.solutions[i].normal_camera), mark.normal_camera);
    if (off_rad >= least_rad) continue;
    least_rad = off_rad;
    right = i;
  }
  return right;
}

std::optional<double> nees3(const Eigen::Vector3d& error_m, const Eigen::Matrix3d& covariance_m2) {
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(covariance_m2);
  if (!lu.isInvertible()) return std::nullopt;
  return error_m.dot(lu.solve(error_m)) / 3;
}

PoseSample sample_of(std::int64_t utime, const pose_t& pose, const Mark& mark,
                     const std::optional<CommonError>& common) {
  const Eigen::Vector3d chosen_m = center_of(pose.solutions.front());
  const std::size_t right = right_solution(pose, mark);
  PoseSample sample;
  sample.utime = utime;
  sample.kind = mark.kind;
  sample.mark = mark.name;
  sample.range_m = mark.center_camera_m.norm();
  sample.theta_rad = mark.theta_rad();
  sample.range_error_m = chosen_m.norm() - sample.range_m;
  sample.center_error_m = (chosen_m - mark.center_camera_m).norm();
  sample.has_two = pose.solutions.size() > 1;
  sample.is_wrong = right != 0;
  sample.probability = pose.solutions.front().probability;
  const circle_solution_t& solution = pose.solutions[right];
  const Eigen::Vector3d error_m = center_of(solution) - mark.center_camera_m;
  const Eigen::Matrix3d covariance_m2 = Eigen::Map<const Eigen::Matrix3d>(solution.covariance_m2);
  sample.nees3 = nees3(error_m, covariance_m2);
  if (common) {
    const Eigen::Matrix3d shared_m2 = common_error(mark.center_camera_m, common->camera, common->sigmas);
    sample.nees3_with = nees3(error_m, covariance_m2 + shared_m2);
  }
  return sample;
}

/// Which track id each mark has had. Of several tracks that are the mark's the one that was it before still
/// is (Bernardin and Stiefelhagen 2008), however near another may come.
class IdBook {
 public:
  [[nodiscard]] bool had(const std::string& mark, std::int64_t track_id) const {
    const auto before = last_.find(mark);
    return before != last_.end() && before->second.track_id == track_id;
  }
  void add(std::int64_t utime, const std::string& mark, std::int64_t track_id, PoseComparison& counts) {
    constexpr std::int64_t exit_us = 2'000'000;  // who is away for less must come back with the same id
    const auto before = last_.find(mark);
    if (before != last_.end() && before->second.track_id != track_id)
      ++(utime - before->second.utime <= exit_us ? counts.switches : counts.after_exit);
    const auto owner = owner_.find(track_id);
    if (owner != owner_.end() && owner->second != mark) ++counts.taken_over;
    last_[mark] = {utime, track_id};
    owner_[track_id] = mark;
    counts.marks = static_cast<std::int64_t>(last_.size());
  }

 private:
  struct Last {
    std::int64_t utime, track_id;
  };
  std::map<std::string, Last> last_;           // by mark
  std::map<std::int64_t, std::string> owner_;  // by track id: its mark
};

void add_probabilities(const pose_t& pose, const Mark& mark, std::vector<ProbabilityBin>& bins) {
  if (pose.solutions.size() < 2) return;
  const std::size_t right = right_solution(pose, mark);
  for (std::size_t i = 0; i < pose.solutions.size(); ++i) {
    const double p = pose.solutions[i].probability;
    const auto bin = std::min<std::size_t>(static_cast<std::size_t>(p * 10), bins.size() - 1);
    ++bins[bin].count;
    bins[bin].right += i == right;
    bins[bin].sum += p;
  }
}

std::int64_t whole_of(const std::vector<Mark>& marks) {
  return std::count_if(marks.begin(), marks.end(), [](const Mark& mark) { return mark.is_whole; });
}

/// Between the first and the last POSES: before and after, nobody was there to answer.
void count_unanswered(const std::vector<poses_t>& poses, const MarksByTime& marks, PoseComparison& result) {
  std::set<std::int64_t> answered;
  for (const poses_t& frame : poses) answered.insert(frame.header.utime);
  if (answered.empty()) return;
  const auto last = marks.upper_bound(*answered.rbegin());
  for (auto frame = marks.lower_bound(*answered.begin()); frame != last; ++frame) {
    if (answered.contains(frame->first)) continue;
    ++result.frames_unanswered;
    result.whole_circles += whole_of(frame->second);
  }
}

void compare_frame(const poses_t& frame, const std::vector<Mark>& marks,
                   const std::optional<CommonError>& common, IdBook& ids, PoseComparison& result) {
  struct Claim {
    const pose_t* pose;  // the nearest one
    double misfit;
    std::int64_t track_id;
  };
  std::map<int, Claim> claims;  // by mark
  for (const pose_t& pose : frame.poses) {
    if (!is_measured(pose)) {
      ++result.predicted;
      continue;
    }
    if (pose.solutions.empty()) {
      ++result.without_solution;
      continue;
    }
    ++result.poses;
    const Fit fit = fit_of(pose, marks);
    if (fit.mark < 0) {
      ++result.of_nothing;
    } else if (fit.is_ambiguous) {
      ++result.ambiguous;
    } else {
      const std::string& mark = marks[static_cast<std::size_t>(fit.mark)].name;
      const auto [place, is_first] = claims.try_emplace(fit.mark, Claim{&pose, fit.misfit, pose.track_id});
      Claim& claim = place->second;
      const bool is_nearer = fit.misfit < claim.misfit, had_it = ids.had(mark, claim.track_id);
      if (!is_first) ++result.doubled;
      if ((is_nearer && !had_it) || ids.had(mark, pose.track_id)) claim.track_id = pose.track_id;
      if (is_nearer) claim.pose = &pose, claim.misfit = fit.misfit;
    }
  }
  for (const auto& [index, claim] : claims) {
    const Mark& mark = marks[static_cast<std::size_t>(index)];
    ids.add(frame.header.utime, mark.name, claim.track_id, result);
    if (mark.is_whole) ++result.whole_found;
    // a radius told wrong by a tenth is a wrong setting; a third is another kind of mark
    const double assumed = claim.pose->radius_m / mark.radius_m;
    if (assumed < 0.8 || assumed > 1.25) {
      ++result.other_size;
      continue;
    }
    result.samples.push_back(sample_of(frame.header.utime, *claim.pose, mark, common));
    add_probabilities(*claim.pose, mark, result.probabilities);
  }
  result.whole_circles += whole_of(marks);
}

/// Name and condition of each bin [edges[i], edges[i + 1]) of a value.
template <class Value>
std::vector<PoseRow> rows_by(const std::vector<PoseSample>& samples, const std::vector<double>& edges,
                             const char* unit, const Value& value) {
  std::vector<PoseRow> rows;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    const bool is_last = i + 2 == edges.size();
    const std::string name = is_last ? fmt::format("from {} {}", edges[i], unit)
                                     : fmt::format("{} to {} {}", edges[i], edges[i + 1], unit);
    PoseRow row = row_of(name, samples, [&](const PoseSample& sample) {
      return value(sample) >= edges[i] && value(sample) < edges[i + 1];
    });
    if (row.range_m.count > 0) rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace

double Mark::theta_rad() const {
  return angle_between(normal_camera, -center_camera_m);
}

std::string name_of_circle(int platform, int slot) {
  return fmt::format("platform {}, slot {}", platform, slot);
}

MarksByTime marks_of(const std::vector<truth_t>& truth) {
  constexpr double whole_share = 0.99;  // of 180 points along its edge: one may fall on the image's border
  MarksByTime marks;
  for (const truth_t& frame : truth) {
    std::vector<Mark>& here = marks[frame.header.utime];
    for (const truth_circle_t& circle : frame.circles) {
      if (!circle.in_view) continue;
      here.push_back(mark_at(frame, Mark::Kind::circle, name_of_circle(circle.platform, circle.slot),
                             circle.center_ned_m, circle.normal_ned, circle.radius_m));
      here.back().is_whole = circle.visible_share >= whole_share;
    }
    for (const truth_cargo_t& cargo : frame.cargoes) {
      Mark mark = mark_at(frame, Mark::Kind::cargo, fmt::format("cargo {}", cargo.index), cargo.center_ned_m,
                          cargo.axis_ned, cargo.radius_m);
      if (mark.center_camera_m.z() > 0 && mark.theta_rad() < 90 * deg) here.push_back(mark);
    }
  }
  return marks;
}

MarksByTime marks_of(const std::vector<poses_t>& poses) {
  MarksByTime marks;
  for (const poses_t& frame : poses) {
    std::vector<Mark>& here = marks[frame.header.utime];
    for (const pose_t& pose : frame.poses) {
      if (!is_measured(pose) || pose.solutions.empty()) continue;
      const auto kind = pose.label == ellipse_t::LABEL_CARGO ? Mark::Kind::cargo : Mark::Kind::circle;
      here.push_back({kind, fmt::format("track {}", pose.track_id), center_of(pose.solutions.front()),
                      Eigen::Vector3d(pose.solutions.front().normal_camera), pose.radius_m,
                      kind == Mark::Kind::circle && pose.kind == ellipse_t::KIND_WHOLE});
    }
  }
  return marks;
}

PoseComparison compare_poses(const std::vector<poses_t>& poses, const MarksByTime& marks,
                             const std::optional<CommonError>& common) {
  PoseComparison result;
  IdBook ids;
  for (const poses_t& frame : poses) {
    const auto here = marks.find(frame.header.utime);
    if (here == marks.end()) {
      ++result.frames_alone;
      continue;
    }
    ++result.frames;
    compare_frame(frame, here->second, common, ids, result);
  }
  count_unanswered(poses, marks, result);
  return result;
}

double calibration_error(const PoseComparison& comparison) {
  double sum = 0, count = 0;
  for (const ProbabilityBin& bin : comparison.probabilities) {
    sum += std::abs(bin.sum - static_cast<double>(bin.right));
    count += static_cast<double>(bin.count);
  }
  return count > 0 ? sum / count : 0;
}

PoseRow row_of(std::string name, const std::vector<PoseSample>& samples) {
  PoseRow row;
  row.name = std::move(name);
  std::vector<double> range_m, center_m, nees, nees_with;
  for (const PoseSample& sample : samples) {
    range_m.push_back(sample.range_error_m);
    center_m.push_back(sample.center_error_m);
    if (sample.nees3) nees.push_back(*sample.nees3);
    if (sample.nees3_with) nees_with.push_back(*sample.nees3_with);
    if (sample.theta_rad < 4 * deg || !sample.has_two) continue;
    ++row.judged;
    row.wrong += sample.is_wrong;
    row.wrong_above_99 += sample.is_wrong && sample.probability > 0.99;
  }
  const auto mean = [](const std::vector<double>& values) {
    return values.empty() ? std::numeric_limits<double>::quiet_NaN() : spread_of(values).mean;
  };
  row.range_m = spread_of(range_m);
  row.center_m = spread_of(center_m);
  row.nees3 = mean(nees);
  row.nees3_with = mean(nees_with);
  return row;
}

std::vector<PoseRow> rows_by_range(const PoseComparison& comparison, Mark::Kind kind) {
  std::vector<PoseSample> samples;
  for (const PoseSample& sample : comparison.samples)
    if (sample.kind == kind) samples.push_back(sample);
  return rows_by(samples, {0, 1.5, 3, 4.5, 6, 8, 12, 1e9}, "m",
                 [](const PoseSample& sample) { return sample.range_m; });
}

std::vector<PoseRow> rows_by_theta(const PoseComparison& comparison) {
  std::vector<PoseSample> circles;
  for (const PoseSample& sample : comparison.samples)
    if (sample.kind == Mark::Kind::circle) circles.push_back(sample);
  return rows_by(circles, {0, 4, 10, 15, 20, 25, 30, 40, 91}, "deg",
                 [](const PoseSample& sample) { return sample.theta_rad / deg; });
}

std::vector<PoseRow> rows_by_mark(const PoseComparison& comparison) {
  std::map<std::string, std::vector<PoseSample>> by_mark;
  for (const PoseSample& sample : comparison.samples) by_mark[sample.mark].push_back(sample);
  std::vector<PoseRow> rows;
  for (const auto& [mark, samples] : by_mark) rows.push_back(row_of(mark, samples));
  return rows;
}

std::vector<TableOneRow> table_one(const PoseComparison& comparison) {
  std::vector<TableOneRow> rows{
      {'a', 1.650, 0.017, {}}, {'b', 2.363, 0.020, {}}, {'c', 4.218, 0.017, {}}, {'d', 5.253, 0.051, {}}};
  for (TableOneRow& row : rows) {
    row.ours = row_of(std::string(1, row.image), comparison.samples, [&row](const PoseSample& sample) {
      return sample.kind == Mark::Kind::circle && std::abs(sample.range_m / row.range_m - 1) < 0.1;
    });
  }
  return rows;
}

}  // namespace stevedore
