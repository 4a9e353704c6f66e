#include "pose_proc/pose_stage.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdlib>
#include <tuple>

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

/// What POSES repeats of a track.
pose_t mark_message(const track_t& track) {
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
  return pose;
}

void add_estimate(pose_t& pose, const CirclePose& estimate, const std::optional<Gravity>& gravity) {
  pose.radius_m = estimate.radius_m;
  pose.label = to_message(estimate.label);
  if (estimate.label != Label::circle) pose.occupied = ellipse_t::OCCUPIED_UNKNOWN;
  pose.chosen_by = to_message(estimate.chosen_by);
  pose.reason = reason_text(estimate.reason);
  for (const PoseSolution& solution : estimate.solutions) pose.solutions.push_back(to_message(solution));
  pose.solution_count = static_cast<int16_t>(pose.solutions.size());
  if (estimate.solutions.empty() || !gravity) return;
  pose.has_level = 1;
  Eigen::Map<Eigen::Vector3d>(pose.center_level_m) =
      level_from_camera(gravity->direction_camera) * estimate.solutions.front().circle.center_camera_m;
}

}  // namespace

Gravity PoseStage::Attitude::gravity() const {
  return {(ned_from_body * body_from_camera).transpose() * Eigen::Vector3d::UnitZ(), sigma_rad};
}

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
  bus_.subscribe<altimeter_t>(channels::altimeter, [this](const altimeter_t& m) { keep(altimeter_, m); });
}

std::optional<PoseStage::Attitude> PoseStage::attitude_at(int64_t utime) const {
  const gimbal_state_t* gimbal = nearest(gimbal_states_, utime, channels::gimbal_state);
  const vehicle_state_t* vehicle = nearest(vehicle_states_, utime, channels::vehicle_state);
  if (!camera_ || !vehicle) return std::nullopt;
  if (!gimbal && !gimbal_states_.empty())
    return std::nullopt;  // there is a gimbal, and nobody knows how it stands
  const double* q = vehicle->ned_from_body;
  const GimbalAngles angles = gimbal ? GimbalAngles{gimbal->roll_rad, gimbal->pitch_rad} : GimbalAngles{};
  const double variance = (vehicle->attitude_variance_rad2[0] + vehicle->attitude_variance_rad2[1]) / 2;
  return Attitude{Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized().toRotationMatrix(),
                  body_from_camera(angles, camera_->mount), std::sqrt(variance)};
}

std::optional<BeamRange> PoseStage::beam_at(int64_t utime, const Attitude& attitude) const {
  const altimeter_t* altimeter = nearest(altimeter_, utime, channels::altimeter);
  if (!altimeter || !altimeter->valid) return std::nullopt;
  const Eigen::Matrix3d camera_from_body = attitude.body_from_camera.transpose();
  const Eigen::Vector3d origin_body_m(settings_.altimeter_forward_m, settings_.altimeter_right_m,
                                      settings_.altimeter_down_m);
  return BeamRange{camera_from_body * origin_body_m, camera_from_body * Eigen::Vector3d::UnitZ(),
                   altimeter->range_m, std::sqrt(altimeter->variance_m2)};
}

std::optional<PreviousChoice> PoseStage::previous_of(int64_t track_id, int64_t utime,
                                                     const Eigen::Matrix3d& world_from_camera) const {
  const auto before = previous_.find(track_id);
  if (before == previous_.end()) return std::nullopt;
  const Believed& b = before->second;
  if (b.in_ned != previous_in_ned_now_) return std::nullopt;  // attitude came or went: no common frame
  return PreviousChoice{
      {world_from_camera.transpose() * b.normal_world[0], world_from_camera.transpose() * b.normal_world[1]},
      b.probability,
      static_cast<double>(utime - b.utime) * 1e-6};
}

const char* PoseStage::obstacle() const {
  if (!camera_) return "no camera file";
  return fits_camera_ ? nullptr : "the frame is not of the camera file's size";
}

std::vector<CirclePose> PoseStage::estimates_of(const tracks_t& tracks,
                                                const std::optional<Attitude>& attitude) {
  const int64_t utime = tracks.header.utime;
  const Eigen::Matrix3d world_from_camera =
      attitude ? Eigen::Matrix3d(attitude->ned_from_body * attitude->body_from_camera)
               : Eigen::Matrix3d::Identity();
  previous_in_ned_now_ = attitude.has_value();
  std::vector<MarkImage> marks;
  for (const track_t& track : tracks.tracks) {
    const Detection detection = from_message(track.ellipse);
    std::optional<EllipseFit> inner;
    const bool measured = track.ellipse_index >= 0;
    if (detection.inner && measured) inner = detection.inner;
    marks.push_back({detection.outer, inner, detection.label, previous_of(track.id, utime, world_from_camera),
                     detection.coverage, detection.occupied.value_or(false), measured});
  }
  PoseContext surroundings;
  if (attitude) {
    surroundings.gravity = attitude->gravity();
    surroundings.beam = beam_at(utime, *attitude);
  }
  const auto estimates = estimate_poses(marks, camera_->rectified, surroundings, settings_);
  std::map<int64_t, Believed> believed;  // of the tracks that are still there
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    if (estimates[i].solutions.size() < 2) continue;
    const auto& [first, second] = std::tie(estimates[i].solutions[0], estimates[i].solutions[1]);
    believed[tracks.tracks[i].id] = {
        {world_from_camera * first.circle.normal_camera, world_from_camera * second.circle.normal_camera},
        first.probability,
        utime,
        attitude.has_value()};
  }
  previous_ = std::move(believed);
  return estimates;
}

void PoseStage::on_tracks(const tracks_t& tracks) {
  const std::optional<Attitude> attitude = attitude_at(tracks.header.utime);
  const std::optional<Gravity> gravity = attitude ? std::optional(attitude->gravity()) : std::nullopt;
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

  const char* why_not = obstacle();
  const auto estimates = why_not ? std::vector<CirclePose>() : estimates_of(tracks, attitude);
  for (std::size_t i = 0; i < tracks.tracks.size(); ++i) {
    pose_t pose = mark_message(tracks.tracks[i]);
    pose.is_target = tracks.tracks[i].id == tracks.target_id;
    if (why_not)
      pose.reason = why_not;
    else
      add_estimate(pose, estimates[i], gravity);
    poses.poses.push_back(pose);
  }
  poses.count = static_cast<int16_t>(poses.poses.size());
  bus_.publish(channels::poses, poses);
  platforms_.see(poses);
}

}  // namespace stevedore
