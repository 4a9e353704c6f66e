#include "pose_proc/platform_stage.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <iterator>
#include <numbers>
#include <stdexcept>

#include "lcmtypes/convert.hpp"
#include "runtime/config.hpp"

namespace stevedore {
namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
using RowMajor6 = Eigen::Matrix<double, 6, 6, Eigen::RowMajor>;

constexpr size_t history = 64;  // more than a second at 50 Hz

template <int rows>
Eigen::Matrix<double, rows, 1> vector_of(const double (&values)[rows]) {
  return Eigen::Map<const Eigen::Matrix<double, rows, 1>>(values);
}

/// POSES has no covariance of normals. A circle's axes appear with the relative error e of its range; from
/// cos(tilt) = b / a the tilt's error is sqrt(2) e / sin(tilt), and where the circle is faced, sqrt(2 sqrt(2)
/// e).
double normal_variance_rad2(const SeenCircle& circle) {
  const double range_m = circle.center_camera_m.norm();
  if (!(range_m > 0)) return 1;
  const Eigen::Vector3d ray = circle.center_camera_m / range_m;
  const double slope =
      std::numbers::sqrt2 * std::sqrt(std::max(0.0, ray.dot(circle.covariance_m2 * ray))) / range_m;
  const double cosine = std::clamp(-ray.dot(circle.normal_camera), 0.0, 1.0);
  const double sine = std::sqrt(1 - cosine * cosine);
  const double sigma_rad = std::min(slope / std::max(sine, 1e-9), std::sqrt(2 * slope));
  constexpr double least_sigma_rad = 1e-3;  // paint and deck are no flatter
  return sigma_rad * sigma_rad + least_sigma_rad * least_sigma_rad;
}

CircleSighting circle_from_message(const pose_t& pose) {
  CircleSighting sighting;
  sighting.radius_m = pose.radius_m;
  if (pose.occupied != ellipse_t::OCCUPIED_UNKNOWN)
    sighting.occupied = pose.occupied == ellipse_t::OCCUPIED_YES;
  for (const circle_solution_t& solution : pose.solutions) {
    SeenCircle circle{vector_of(solution.center_camera_m), vector_of(solution.normal_camera),
                      Eigen::Map<const RowMajor3>(solution.covariance_m2), 0, solution.probability};
    circle.normal_variance_rad2 = normal_variance_rad2(circle);
    sighting.solutions.push_back(circle);
  }
  return sighting;
}

CargoSighting cargo_from_message(const pose_t& pose) {
  const circle_solution_t& chosen = pose.solutions.front();
  return {vector_of(chosen.center_camera_m), Eigen::Map<const RowMajor3>(chosen.covariance_m2),
          pose.radius_m};
}

/// What was measured in this frame; predictions of the tracker would be measured twice.
FrameSighting from_message(const poses_t& poses) {
  FrameSighting sighting;
  sighting.utime = poses.header.utime;
  for (const pose_t& pose : poses.poses) {
    if (pose.ellipse_index < 0 || pose.solutions.empty()) continue;
    if (pose.label == ellipse_t::LABEL_CIRCLE) sighting.circles.push_back(circle_from_message(pose));
    if (pose.label == ellipse_t::LABEL_CARGO) sighting.cargoes.push_back(cargo_from_message(pose));
  }
  return sighting;
}

int8_t to_message(SlotState state) {
  switch (state) {
    case SlotState::unknown:
      return slot_t::STATE_UNKNOWN;
    case SlotState::empty:
      return slot_t::STATE_EMPTY;
    case SlotState::occupied:
      return slot_t::STATE_OCCUPIED;
    case SlotState::misplaced:
      return slot_t::STATE_MISPLACED;
  }
  return slot_t::STATE_UNKNOWN;
}

slot_t to_message(const SlotEstimate& slot, size_t index) {
  slot_t m{};
  m.index = static_cast<int16_t>(index);
  Eigen::Map<Eigen::Vector3d>(m.center_ned_m) = slot.center_ned_m;
  Eigen::Map<RowMajor3>(m.covariance_m2) = slot.covariance_m2;
  m.confidence = slot.confidence;
  m.seen_utime = slot.seen_utime;
  m.state = to_message(slot.state);
  return m;
}

deck_prediction_t to_message(const DeckPrediction& prediction) {
  deck_prediction_t m{};
  m.ahead_s = prediction.ahead_s;
  Eigen::Map<Eigen::Vector3d>(m.center_ned_m) = prediction.center_ned_m;
  Eigen::Map<Eigen::Vector3d>(m.velocity_ned_mps) = prediction.velocity_ned_mps;
  Eigen::Map<Eigen::Vector3d>(m.normal_ned) = prediction.normal_ned;
  Eigen::Map<RowMajor6>(m.covariance) = prediction.covariance;
  m.safe_to_lower = prediction.safe_to_lower;
  return m;
}

platform_estimate_t to_message(const PlatformEstimate& estimate, const header_t& cause) {
  platform_estimate_t m{};
  m.header.utime = cause.utime;
  m.header.frame_seq = cause.frame_seq;
  m.platform = static_cast<int16_t>(estimate.platform);
  for (const SlotEstimate& slot : estimate.slots) m.slots.push_back(to_message(slot, m.slots.size()));
  for (const DeckPrediction& prediction : estimate.predictions)
    m.predictions.push_back(to_message(prediction));
  m.slot_count = static_cast<int16_t>(m.slots.size());
  m.prediction_count = static_cast<int16_t>(m.predictions.size());
  Eigen::Map<Eigen::Vector3d>(m.center_ned_m) = estimate.center_ned_m;
  Eigen::Map<Eigen::Vector3d>(m.velocity_ned_mps) = estimate.velocity_ned_mps;
  Eigen::Map<RowMajor6>(m.covariance) = estimate.covariance;
  m.heading_rad = estimate.heading_rad;
  m.heading_variance_rad2 = estimate.heading_variance_rad2;
  m.turn_rate_radps = estimate.turn_rate_radps;
  m.heave_m = estimate.heave_m;
  m.roll_rad = estimate.roll_rad;
  m.pitch_rad = estimate.pitch_rad;
  m.identity_certain = estimate.identity_certain;
  m.measured_utime = estimate.measured_utime;
  m.seen_utime = estimate.seen_utime;
  return m;
}

/// A layout that can't be is a mistake in the configuration, which no restart mends.
PlatformEstimator estimator_of(const PlatformSettings& settings) {
  try {
    return PlatformEstimator(settings);
  } catch (const std::invalid_argument& error) {
    throw ConfigError(error.what());
  }
}

}  // namespace

PlatformStage::PlatformStage(const PlatformSettings& settings, const CameraMount& mount, Bus& bus)
    : bus_(bus), mount_(mount), estimator_(estimator_of(settings)) {
  bus_.subscribe<platform_state_t>(channels::platform_state, [this](const platform_state_t& m) {
    estimator_.add_report({m.header.utime, m.platform, vector_of(m.position_ned_m),
                           vector_of(m.velocity_ned_mps), m.heading_rad});
  });
}

void PlatformStage::hear(const vehicle_state_t& vehicle) {
  estimator_.add_vehicle(stevedore::from_message(vehicle));
}

void PlatformStage::hear(const gimbal_state_t& gimbal) {
  if (!gimbal_states_.empty() && gimbal.header.utime <= gimbal_states_.back().header.utime)
    gimbal_states_.clear();  // another stream, or the same again
  gimbal_states_.push_back(gimbal);
  if (gimbal_states_.size() > history) gimbal_states_.pop_front();
}

std::optional<GimbalAngles> PlatformStage::gimbal_at(int64_t utime) const {
  if (gimbal_states_.empty()) return GimbalAngles{};
  const auto after = std::lower_bound(gimbal_states_.begin(), gimbal_states_.end(), utime,
                                      [](const gimbal_state_t& m, int64_t t) { return m.header.utime < t; });
  const gimbal_state_t& next = after == gimbal_states_.end() ? gimbal_states_.back() : *after;
  const gimbal_state_t& last = after == gimbal_states_.begin() ? next : *std::prev(after);
  const auto too_old_us = static_cast<int64_t>(channels::gimbal_state.max_age_s * 1e6);
  const int64_t last_us = std::abs(utime - last.header.utime), next_us = std::abs(next.header.utime - utime);
  if (std::min(last_us, next_us) > too_old_us) return std::nullopt;
  const int64_t apart_us = next.header.utime - last.header.utime;
  const double share = apart_us > 0 && utime < next.header.utime
                           ? static_cast<double>(last_us) / static_cast<double>(apart_us)
                           : (last_us < next_us ? 0.0 : 1.0);
  return GimbalAngles{std::lerp(last.roll_rad, next.roll_rad, share),
                      std::lerp(last.pitch_rad, next.pitch_rad, share)};
}

void PlatformStage::see(const poses_t& poses) {
  const auto gimbal = gimbal_at(poses.header.utime);
  if (!gimbal) return;
  FrameSighting sighting = from_message(poses);
  sighting.body_from_camera = body_from_camera(*gimbal, mount_);
  for (const PlatformEstimate& estimate : estimator_.add_frame(sighting))
    bus_.publish(channels::platform_estimate, to_message(estimate, poses.header));
}

}  // namespace stevedore
