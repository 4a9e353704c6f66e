#include "tools/evaluate_altitude.hpp"

#include <Eigen/Geometry>
#include <Eigen/QR>

#include <algorithm>
#include <cmath>
#include <limits>

namespace stevedore {
namespace {

struct Plane {
  Eigen::Vector3d point;   ///< from the camera; z along gravity
  Eigen::Vector3d normal;  ///< unit

  /// Down from the camera.
  [[nodiscard]] double below_m() const { return normal.dot(point) / normal.z(); }
};

/// Of an even count the mean of the two in the middle: through two circles goes neither one's height.
double median_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 == 1 ? values[half] : (values[half - 1] + values[half]) / 2;
}

/// Through three circles or more, with their tilt; through one or two, or circles that are not in a plane:
/// level.
Plane plane_of(const std::vector<Eigen::Vector3d>& centers_m) {
  std::vector<double> depths_m;
  Eigen::Vector3d mean_m = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& center_m : centers_m) {
    depths_m.push_back(center_m.z());
    mean_m += center_m / static_cast<double>(centers_m.size());
  }
  const double depth_m = median_of(depths_m);
  const Plane level{{mean_m.x(), mean_m.y(), depth_m}, Eigen::Vector3d::UnitZ()};
  if (centers_m.size() < 3) return level;
  Eigen::MatrixX3d places(static_cast<Eigen::Index>(centers_m.size()), 3);
  Eigen::VectorXd depths(places.rows());
  for (Eigen::Index i = 0; i < places.rows(); ++i) {
    const Eigen::Vector3d& center_m = centers_m[static_cast<std::size_t>(i)];
    places.row(i) << center_m.x() - mean_m.x(), center_m.y() - mean_m.y(), 1;
    depths[i] = center_m.z();
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixX3d> fit(places);
  const Eigen::Vector3d slope = fit.solve(depths);
  // a row of circles tells nothing of the slope across it; no deck leans by more than 20 degrees
  const double worst_m = (places * slope - depths).cwiseAbs().maxCoeff();
  const bool is_plane = fit.rank() == 3 && slope.head<2>().norm() < 0.36 && worst_m < 0.03 + 0.02 * depth_m;
  if (!is_plane) return level;
  return {{mean_m.x(), mean_m.y(), slope.z()}, Eigen::Vector3d(-slope.x(), -slope.y(), 1).normalized()};
}

/// Of the circles measured in a frame, in the level frame.
std::vector<Eigen::Vector3d> circles_of(const poses_t& poses) {
  std::vector<Eigen::Vector3d> centers_m;
  for (const pose_t& pose : poses.poses) {
    const bool is_measured = pose.status == track_t::STATUS_TRACKING && pose.ellipse_index >= 0;
    if (is_measured && pose.label == ellipse_t::LABEL_CIRCLE && pose.has_level && !pose.solutions.empty())
      centers_m.emplace_back(pose.center_level_m);
  }
  return centers_m;
}

/// Those that lie on the deck of the one nearest to a place: a row of four is 4.8 m long, and platforms keep
/// 15 m apart.
std::vector<Eigen::Vector3d> on_one_deck(const std::vector<Eigen::Vector3d>& centers_m,
                                         const Eigen::Vector3d& place_m) {
  constexpr double deck_m = 6;
  const auto distance_m = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
    return (a - b).head<2>().norm();
  };
  const auto first = std::min_element(centers_m.begin(), centers_m.end(), [&](const auto& a, const auto& b) {
    return distance_m(a, place_m) < distance_m(b, place_m);
  });
  std::vector<Eigen::Vector3d> on_deck_m;
  for (const Eigen::Vector3d& center_m : centers_m)
    if (distance_m(center_m, *first) < deck_m) on_deck_m.push_back(center_m);
  return on_deck_m;
}

/// Between two readings that agree: an edge between them is no height of anything.
std::optional<double> laser_at(const std::vector<altimeter_t>& readings, std::int64_t utime) {
  constexpr std::int64_t gap_us = 75'000;  // 20 Hz, and half a reading's time
  constexpr double edge_m = 0.15;          // half of a cargo's height; 3 m/s of climb between two readings
  const auto between = around(readings, utime, gap_us);
  if (!between || !between->before->valid || !between->after->valid) return std::nullopt;
  const double before_m = between->before->range_m, after_m = between->after->range_m;
  if (std::abs(after_m - before_m) > edge_m) return std::nullopt;
  return before_m + between->share * (after_m - before_m);
}

/// Where the beam ends, from the camera, in the level frame.
std::optional<Eigen::Vector3d> laser_hit(const FlightLog& flight, const poses_t& poses,
                                         const LaserMount& mount) {
  constexpr std::int64_t near_us = 20'000;  // one sample of the 50 Hz
  const auto range_m = laser_at(flight.altimeter, poses.header.utime);
  if (!range_m || !poses.has_gravity) return std::nullopt;
  const gimbal_state_t* gimbal = nearest(flight.gimbal, poses.header.utime, near_us);
  if (!gimbal && !flight.gimbal.empty()) return std::nullopt;
  const GimbalAngles angles = gimbal ? GimbalAngles{gimbal->roll_rad, gimbal->pitch_rad} : GimbalAngles{};
  const Eigen::Matrix3d level_from_body = level_from_camera(Eigen::Vector3d(poses.gravity_camera)) *
                                          body_from_camera(angles, mount.camera).transpose();
  return level_from_body * (mount.from_camera_body_m + *range_m * Eigen::Vector3d::UnitZ());
}

/// Over the platform whose circles are nearest below.
std::optional<double> true_height(const std::vector<truth_t>& truth, std::int64_t utime) {
  const truth_t* frame = nearest(truth, utime, 0);
  if (!frame || frame->circles.empty()) return std::nullopt;
  const Eigen::Vector3d camera_m(frame->camera_ned_m);
  const truth_circle_t* below = nullptr;
  double least_m = std::numeric_limits<double>::infinity();
  for (const truth_circle_t& circle : frame->circles) {
    const double off_m = (Eigen::Vector3d(circle.center_ned_m) - camera_m).head<2>().norm();
    if (!circle.in_view || off_m >= least_m) continue;
    least_m = off_m;
    below = &circle;
  }
  if (!below) return std::nullopt;
  return Plane{Eigen::Vector3d(below->center_ned_m) - camera_m, Eigen::Vector3d(below->normal_ned)}.below_m();
}

/// What vision and laser may differ by without a reason: three sigma of the laser's 3 cm, and 1 % of the
/// height for a camera and circles that are not known better.
double noise_m(double height_m) {
  return 0.09 + 0.01 * height_m;
}

/// Whether the laser reads short by the height of something that stands on a deck.
bool is_on_thing(double height_m, double laser_m) {
  constexpr double tallest_m = 2.2;  // a person in boots and helmet; a bucket with its handle is 0.42 m
  const double short_m = height_m - laser_m;
  return short_m > noise_m(height_m) && short_m < tallest_m + noise_m(height_m);
}

void sum_up(AltitudeComparison& result) {
  constexpr double low_m = 2;
  std::vector<double> laser, laser_low, truth, laser_truth;
  for (const AltitudeSample& sample : result.samples) {
    if (sample.truth_m) truth.push_back(sample.vision_m - *sample.truth_m);
    if (sample.on_thing) {
      ++result.on_thing;
      result.on_thing_low += *sample.laser_m < low_m;
    }
    if (!sample.laser_m || sample.on_thing) continue;
    laser.push_back(sample.vision_m - *sample.laser_m);
    if (*sample.laser_m < low_m) laser_low.push_back(laser.back());
    if (sample.truth_m) laser_truth.push_back(*sample.laser_m - *sample.truth_m);
  }
  result.vision_less_laser_m = spread_of(laser);
  result.vision_less_laser_low_m = spread_of(laser_low);
  result.vision_less_truth_m = spread_of(truth);
  result.laser_less_truth_m = spread_of(laser_truth);
}

}  // namespace

AltitudeComparison compare_altitudes(const FlightLog& flight, const LaserMount& mount) {
  constexpr double near_m = 0.6;  // on the circle, give or take where the spot is: decks end not far beyond
  AltitudeComparison result;
  for (const poses_t& poses : flight.poses) {
    const auto circles_m = circles_of(poses);
    if (circles_m.empty()) continue;
    const auto hit_m = laser_hit(flight, poses, mount);
    const auto on_deck_m = on_one_deck(circles_m, hit_m.value_or(Eigen::Vector3d::Zero()));
    const Plane deck = plane_of(on_deck_m);
    AltitudeSample sample;
    sample.utime = poses.header.utime;
    sample.vision_m = deck.below_m();
    sample.truth_m = true_height(flight.truth, sample.utime);
    const bool is_near = hit_m && std::any_of(on_deck_m.begin(), on_deck_m.end(), [&](const auto& center_m) {
                           return (center_m - *hit_m).template head<2>().norm() < near_m;
                         });
    if (is_near) {
      sample.laser_m = Plane{*hit_m, deck.normal}.below_m();
      // where truth is known, what vision reads too high is its own error
      sample.on_thing = is_on_thing(sample.truth_m.value_or(sample.vision_m), *sample.laser_m);
    }
    result.samples.push_back(sample);
  }
  sum_up(result);
  return result;
}

}  // namespace stevedore
