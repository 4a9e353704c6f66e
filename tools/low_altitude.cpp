#include "tools/low_altitude.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

#include "mission_proc/carry_messages.hpp"
#include "mission_proc/deck_path.hpp"

namespace stevedore {
namespace {

constexpr double low_m = 2;

bool is_near_deck(std::int8_t phase) {
  return phase == mission_t::PHASE_DESCEND || phase == mission_t::PHASE_LOAD ||
         phase == mission_t::PHASE_VERIFY_LOAD || phase == mission_t::PHASE_DROP ||
         phase == mission_t::PHASE_VERIFY_DROP || phase == mission_t::PHASE_RETRY;
}

/// Of a plane under the camera: straight down to it. Both in axes whose z is down.
double below_m(const Eigen::Vector3d& point_from_camera_m, const Eigen::Vector3d& normal) {
  return normal.dot(point_from_camera_m) / normal.z();
}

std::optional<double> true_height_m(const truth_t& truth, std::int16_t platform, std::int16_t slot) {
  const auto circle = std::find_if(
      truth.circles.begin(), truth.circles.end(),
      [&](const truth_circle_t& each) { return each.platform == platform && each.slot == slot; });
  if (circle == truth.circles.end()) return std::nullopt;
  return below_m(Eigen::Vector3d(circle->center_ned_m) - Eigen::Vector3d(truth.camera_ned_m),
                 Eigen::Vector3d(circle->normal_ned));
}

}  // namespace

std::optional<double> LowAltitude::share(std::int64_t count) const {
  if (frames() == 0) return std::nullopt;
  return static_cast<double>(count) / static_cast<double>(frames());
}

std::optional<double> LowAltitude::error_m(double share) const {
  if (errors_m.empty()) return std::nullopt;
  const auto rank = std::lround(share * static_cast<double>(errors_m.size() - 1));
  return errors_m[static_cast<std::size_t>(rank)];
}

void LowAltitudeBook::add(const mission_t& mission) {
  Told told;
  told.for_frame = mission.header.frame_seq >= 0;
  told.publish_utime = mission.header.trace.publish_utime;
  told.phase = mission.phase;
  told.platform = mission.target_platform;
  told.slot = mission.target_slot;
  told.has_level = mission.has_target_level;
  std::copy_n(mission.target_level_m, 3, told.level_m);
  told_.emplace(mission.header.utime, told);
}

void LowAltitudeBook::add(const platform_estimate_t& estimate) {
  estimates_[estimate.platform].emplace(estimate.header.trace.publish_utime, estimate);
  seen_.emplace(estimate.platform, estimate.seen_utime);
}

void LowAltitudeBook::add(const vehicle_state_t& vehicle) {
  const double* q = vehicle.ned_from_body;
  const Eigen::Vector3d ahead = Eigen::Quaterniond(q[0], q[1], q[2], q[3]) * Eigen::Vector3d::UnitX();
  heading_rad_[vehicle.header.utime] = std::atan2(ahead.y(), ahead.x());
}

void LowAltitudeBook::add(const truth_t& truth) {
  truth_.emplace(truth.header.utime, truth);
}

std::optional<double> LowAltitudeBook::told_height_m(std::int64_t utime, const Told& told) const {
  const auto of_platform = estimates_.find(told.platform);
  const auto vehicle = heading_rad_.lower_bound(utime);
  if (!told.has_level || of_platform == estimates_.end() || heading_rad_.empty()) return std::nullopt;
  auto estimate = of_platform->second.upper_bound(told.publish_utime);
  if (estimate == of_platform->second.begin()) return std::nullopt;
  --estimate;
  const VehicleMoment no_odometry{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero(),
                                  Eigen::Quaterniond::Identity()};
  const Eigen::Vector3d normal = DeckPath(from_message(estimate->second), no_odometry).normal(utime);
  const double heading_rad = (vehicle == heading_rad_.end() ? std::prev(vehicle) : vehicle)->second;
  // the level frame: right, back, down
  const Eigen::Vector2d out_m = ned_from_deck({-told.level_m[1], told.level_m[0]}, heading_rad);
  return below_m({out_m.x(), out_m.y(), told.level_m[2]}, normal);
}

LowAltitude LowAltitudeBook::sum_up() const {
  LowAltitude sum;
  Told newest;                            // of all MISSIONs so far
  std::int16_t platform = -1, slot = -1;  // of the newest that had a target
  auto next = told_.begin();
  for (const auto& [utime, truth] : truth_) {
    const Told* of_frame = nullptr;
    for (; next != told_.end() && next->first <= utime; ++next) {
      newest = next->second;
      if (next->first == utime && newest.for_frame) of_frame = &next->second;
      if (newest.platform >= 0) platform = newest.platform, slot = newest.slot;
    }
    const auto true_m = true_height_m(truth, platform, slot);
    if (!is_near_deck(newest.phase) || !true_m || *true_m >= low_m) continue;
    const auto told_m = of_frame ? told_height_m(utime, *of_frame) : std::nullopt;
    if (!told_m) {
      ++sum.none;
      continue;
    }
    ++(seen_.contains({platform, utime}) ? sum.measured : sum.predicted);
    sum.errors_m.push_back(std::abs(*told_m - *true_m));
  }
  std::sort(sum.errors_m.begin(), sum.errors_m.end());
  return sum;
}

}  // namespace stevedore
