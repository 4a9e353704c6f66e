#include "pose_proc/pose_stage.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>

#include "lcmtypes/convert.hpp"

namespace stevedore {
namespace {

using RowMajor3 = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr size_t history = 64;  // more than a second at 50 Hz

template <class M>
void keep(std::deque<M>& messages, const M& message) {
  messages.push_back(message);
  if (messages.size() > history) messages.pop_front();
}

/// The message captured nearest to utime, if within the channel's maximum age.
template <class M>
const M* nearest(const std::deque<M>& messages, int64_t utime, const Channel<M>& channel) {
  const M* best = nullptr;
  for (const M& m : messages) {
    if (!best || std::abs(m.header.utime - utime) < std::abs(best->header.utime - utime)) best = &m;
  }
  const auto too_old_us = static_cast<int64_t>(channel.max_age_s * 1e6);
  return best && std::abs(best->header.utime - utime) <= too_old_us ? best : nullptr;
}

int8_t to_message(ChosenBy chosen_by) {
  switch (chosen_by) {
    case ChosenBy::none:
      return pose_t::CHOSEN_BY_NONE;
    case ChosenBy::attitude:
      return pose_t::CHOSEN_BY_ATTITUDE;
    case ChosenBy::continuity:
      return pose_t::CHOSEN_BY_CONTINUITY;
    case ChosenBy::optical_axis:
      return pose_t::CHOSEN_BY_OPTICAL_AXIS;
  }
  return pose_t::CHOSEN_BY_NONE;
}

circle_solution_t to_message(const PoseSolution& solution) {
  circle_solution_t message{};
  Eigen::Map<Eigen::Vector3d>(message.center_camera_m) = solution.circle.center_camera_m;
  Eigen::Map<Eigen::Vector3d>(message.normal_camera) = solution.circle.normal_camera;
  Eigen::Map<RowMajor3>(message.covariance_m2) = solution.circle.covariance_m2;
  message.probability = solution.probability;
  return message;
}

}  // namespace

PoseStage::PoseStage(const PoseSettings& settings, const std::optional<CameraModel>& camera, Bus& bus,
                     const PlatformSettings& platforms)
    : bus_(bus),
      settings_(settings),
      camera_(camera),
      platforms_(platforms, camera ? camera->mount : CameraMount{}, bus) {
  bus_.subscribe<tracks_t>(channels::tracks, [this](const tracks_t& m) { on_tracks(m); });
  bus_.subscribe<vehicle_state_t>(channels::vehicle_state, [this](const vehicle_state_t& m) {
    keep(vehicle_states_, m);
    platforms_.hear(m);
  });
  bus_.subscribe<gimbal_state_t>(channels::gimbal_state, [this](const gimbal_state_t& m) {
    keep(gimbal_states_, m);
    platforms_.hear(m);
  });
}

std::optional<Gravity> PoseStage::gravity_at(int64_t utime) const {
  const gimbal_state_t* gimbal = nearest(gimbal_states_, utime, channels::gimbal_state);
  const vehicle_state_t* vehicle = nearest(vehicle_states_, utime, channels::vehicle_state);
  if (!camera_ || !vehicle) return std::nullopt;
  if (!gimbal && !gimbal_states_.empty())
    return std::nullopt;  // there is a gimbal, and nobody knows how it stands
  const double* q = vehicle->ned_from_body;
  const GimbalAngles angles = gimbal ? GimbalAngles{gimbal->roll_rad, gimbal->pitch_rad} : GimbalAngles{};
  const double variance = (vehicle->attitude_variance_rad2[0] + vehicle->attitude_variance_rad2[1]) / 2;
  return Gravity{
      gravity_in_camera(Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized(), angles, camera_->mount),
      std::sqrt(variance)};
}

pose_t PoseStage::pose_of(const track_t& track, const std::optional<Gravity>& gravity) {
  pose_t pose{};
  pose.track_id = track.id;
  pose.ellipse_index = track.ellipse_index;
  pose.age_frames = track.age_frames;
  pose.status = track.status;
  pose.u_px = track.ellipse.outer.u_px;
  pose.v_px = track.ellipse.outer.v_px;
  pose.a_px = track.ellipse.outer.a_px;
  pose.b_px = track.ellipse.outer.b_px;
  pose.coverage = track.ellipse.coverage;
  pose.kind = track.ellipse.kind;
  pose.label = track.ellipse.label;
  pose.occupied = track.ellipse.occupied;
  if (!camera_) {
    pose.reason = "no camera file";
    return pose;
  }
  if (!fits_camera_) {
    pose.reason = "the frame is not of the camera file's size";
    return pose;
  }
  const Detection detection = from_message(track.ellipse);
  const auto before = previous_.find(track.id);
  const CirclePose estimate =
      estimate_pose(detection.outer, detection.label, camera_->rectified, gravity,
                    before == previous_.end() ? std::nullopt : std::optional(before->second), settings_);
  pose.radius_m = estimate.radius_m;
  pose.chosen_by = to_message(estimate.chosen_by);
  pose.reason = reason_text(estimate.reason);
  for (const PoseSolution& solution : estimate.solutions) pose.solutions.push_back(to_message(solution));
  pose.solution_count = static_cast<int16_t>(pose.solutions.size());
  if (estimate.solutions.empty()) return pose;

  const PoseSolution& chosen = estimate.solutions.front();
  previous_[track.id] = {chosen.circle.normal_camera, chosen.probability};
  if (gravity) {
    pose.has_level = 1;
    Eigen::Map<Eigen::Vector3d>(pose.center_level_m) =
        level_from_camera(gravity->direction_camera) * chosen.circle.center_camera_m;
  }
  return pose;
}

void PoseStage::on_tracks(const tracks_t& tracks) {
  const std::optional<Gravity> gravity = gravity_at(tracks.header.utime);
  fits_camera_ = camera_ && tracks.width_px == camera_->rectified.width_px &&
                 tracks.height_px == camera_->rectified.height_px;
  poses_t poses{};
  poses.header.utime = tracks.header.utime;
  poses.header.frame_seq = tracks.header.frame_seq;
  poses.target_id = tracks.target_id;
  poses.target_status = tracks.target_status;
  poses.target_reason = tracks.target_reason;
  poses.method = settings_.method;
  poses.has_gravity = gravity.has_value();
  if (gravity) Eigen::Map<Eigen::Vector3d>(poses.gravity_camera) = gravity->direction_camera;

  std::map<int64_t, PreviousChoice> previous;
  for (const track_t& track : tracks.tracks) {
    pose_t pose = pose_of(track, gravity);
    pose.is_target = track.id == tracks.target_id;
    poses.poses.push_back(pose);
    if (const auto choice = previous_.find(track.id); choice != previous_.end()) previous.insert(*choice);
  }
  previous_ = std::move(previous);  // of the tracks that are still there
  poses.count = static_cast<int16_t>(poses.poses.size());
  bus_.publish(channels::poses, poses);
  platforms_.see(poses);
}

}  // namespace stevedore
