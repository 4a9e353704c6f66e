#include "geometry/vehicle_history.hpp"

#include <algorithm>
#include <iterator>

namespace stevedore {
namespace {

constexpr std::int64_t kept_us = 3'000'000;  // frames are less than a second old when they arrive

/// Ten samples at 50 Hz: the velocity's chord is 3 cm off at most (3 m/s2), and the attitude still follows.
constexpr std::int64_t longest_gap_us = 200'000;

double seconds(std::int64_t us) {
  return static_cast<double>(us) * 1e-6;
}

Eigen::Quaterniond carried(const VehicleSample& sample, std::int64_t utime) {
  const Eigen::Vector3d turn_rad = sample.angular_rate_body_radps * seconds(utime - sample.utime);
  return sample.ned_from_body *
         Eigen::Quaterniond(Eigen::AngleAxisd(turn_rad.norm(), turn_rad.stableNormalized()));
}

Eigen::Vector3d way_between(const VehicleSample& from, const VehicleSample& to) {
  const std::int64_t gap_us = to.utime - from.utime;
  if (gap_us > longest_gap_us) return to.position_ned_m - from.position_ned_m;
  return (from.velocity_ned_mps + to.velocity_ned_mps) / 2 * seconds(gap_us);
}

}  // namespace

void VehicleHistory::add(const VehicleSample& sample) {
  if (entries_.empty()) {
    entries_.push_back({sample, Eigen::Vector3d::Zero()});
    return;
  }
  const Entry& newest = entries_.back();
  if (sample.utime <= newest.sample.utime) return;
  entries_.push_back({sample, newest.position_odometry_m + way_between(newest.sample, sample)});
  while (entries_.front().sample.utime < sample.utime - kept_us) entries_.pop_front();
}

std::optional<VehicleMoment> VehicleHistory::at(std::int64_t utime) const {
  if (entries_.empty() || utime < entries_.front().sample.utime) return std::nullopt;
  const auto after = std::upper_bound(entries_.begin(), entries_.end(), utime,
                                      [](std::int64_t t, const Entry& e) { return t < e.sample.utime; });
  const Entry& before = *std::prev(after);
  const VehicleSample& from = before.sample;
  const std::int64_t since_us = utime - from.utime;
  VehicleMoment moment{before.position_odometry_m, from.position_ned_m - before.position_odometry_m,
                       carried(from, utime), from.velocity_variance_m2ps2, from.attitude_variance_rad2};
  if (after == entries_.end()) {
    if (since_us > longest_gap_us) return std::nullopt;
    moment.position_odometry_m += from.velocity_ned_mps * seconds(since_us);
  } else {
    const std::int64_t gap_us = after->sample.utime - from.utime;
    if (gap_us > longest_gap_us && since_us > 0) return std::nullopt;
    const double share = static_cast<double>(since_us) / static_cast<double>(gap_us);
    moment.position_odometry_m += share * (after->position_odometry_m - before.position_odometry_m);
    moment.ned_from_odometry_m +=
        share * (after->sample.position_ned_m - after->position_odometry_m - moment.ned_from_odometry_m);
  }
  average_attitude(utime, moment);
  return moment;
}

void VehicleHistory::average_attitude(std::int64_t utime, VehicleMoment& moment) const {
  Eigen::Vector4d sum = Eigen::Vector4d::Zero();
  int samples = 0;
  for (auto entry = entries_.rbegin(); entry != entries_.rend(); ++entry) {
    const VehicleSample& sample = entry->sample;
    if (sample.utime < utime - attitude_window_us) break;
    if (sample.utime > utime + attitude_window_us) continue;
    const Eigen::Vector4d q = carried(sample, utime).coeffs();
    sum += q.dot(moment.ned_from_body.coeffs()) < 0 ? -q : q;  // q and -q are one attitude
    ++samples;
  }
  if (samples == 0) return;
  moment.ned_from_body = Eigen::Quaterniond(sum.normalized());
  constexpr double share_of_noise = 0.5;
  moment.attitude_variance_rad2 *= share_of_noise / samples;
}

std::int64_t VehicleHistory::newest_utime() const {
  return entries_.empty() ? -1 : entries_.back().sample.utime;
}

}  // namespace stevedore
