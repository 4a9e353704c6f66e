#include "tracker_proc/tracker_stage.hpp"

#include <algorithm>

#include "lcmtypes/convert.hpp"
#include "runtime/frame_loss.hpp"

namespace stevedore {
namespace {

/// Frames kept until their ellipses come: the detector's work and queue, half a second at 30 Hz.
constexpr size_t recent_frame_count = 16;

double seconds(int64_t utime) {
  return static_cast<double>(utime) * 1e-6;
}

int8_t to_message(TrackStatus status) {
  switch (status) {
    case TrackStatus::searching:
      return track_t::STATUS_SEARCHING;
    case TrackStatus::tracking:
      return track_t::STATUS_TRACKING;
    case TrackStatus::predicted:
      return track_t::STATUS_PREDICTED;
    case TrackStatus::lost:
      return track_t::STATUS_LOST;
  }
  return track_t::STATUS_LOST;
}

track_t to_message(const Track& track) {
  track_t message{};
  message.id = track.id;
  message.ellipse_index = track.detection_index;
  message.ellipse = to_message(track.detection);
  message.velocity_u_pxps = track.velocity_pxps.x();
  message.velocity_v_pxps = track.velocity_pxps.y();
  message.unseen_s = track.unseen_s;
  message.age_frames = track.age_frames;
  message.status = to_message(track.status);
  return message;
}

std::optional<Eigen::Vector2d> pixel_of(const track_command_t& command) {
  if (command.u_px < 0 || command.v_px < 0) return std::nullopt;
  return Eigen::Vector2d(command.u_px, command.v_px);
}

void set_window(tracks_t& message, const Ellipse& window) {
  message.has_window = 1;
  message.window_u_px = window.u_px;
  message.window_v_px = window.v_px;
  message.window_a_px = window.a_px;
  message.window_b_px = window.b_px;
  message.window_alpha_rad = window.alpha_rad;
}

}  // namespace

TrackerStage::TrackerStage(const TrackerSettings& settings, const std::optional<CameraModel>& camera,
                           Bus& bus, FrameReader& frames)
    : bus_(bus), frames_(frames), tracker_(settings) {
  if (camera) {
    camera_ = camera->rectified;
    turn_.emplace(camera->rectified, camera->mount);
  }
  bus_.subscribe<frame_t>(channels::frame, [this](const frame_t& m) { on_frame(m); });
  bus_.subscribe<ellipses_t>(channels::ellipses, [this](const ellipses_t& m) { on_ellipses(m); });
  bus_.subscribe<track_command_t>(channels::track_command,
                                  [this](const track_command_t& m) { on_command(m); });
  bus_.subscribe<vehicle_state_t>(channels::vehicle_state,
                                  [this](const vehicle_state_t& m) { on_vehicle(m); });
  bus_.subscribe<gimbal_state_t>(channels::gimbal_state, [this](const gimbal_state_t& m) { on_gimbal(m); });
}

void TrackerStage::on_vehicle(const vehicle_state_t& vehicle) {
  if (!turn_) return;
  const double* q = vehicle.ned_from_body;
  turn_->add(AttitudeSample{seconds(vehicle.header.utime),
                            Eigen::Quaterniond(q[0], q[1], q[2], q[3]).normalized(),
                            Eigen::Map<const Eigen::Vector3d>(vehicle.angular_rate_body_radps)});
}

void TrackerStage::on_gimbal(const gimbal_state_t& gimbal) {
  if (turn_) turn_->add(GimbalSample{seconds(gimbal.header.utime), {gimbal.roll_rad, gimbal.pitch_rad}});
}

FrameView TrackerStage::view_of(const ellipses_t& ellipses) {
  FrameView view;
  view.size = {ellipses.width_px, ellipses.height_px};
  if (!camera_ || view.size != cv::Size(camera_->width_px, camera_->height_px)) return view;
  view.focal_px = camera_->fx_px;
  view.turn = turn_->homography_to(seconds(ellipses.header.utime));
  return view;
}

void TrackerStage::on_frame(const frame_t& frame) {
  recent_frames_.push_back(frame);
  if (recent_frames_.size() > recent_frame_count) recent_frames_.pop_front();
}

cv::Mat TrackerStage::image_of(const ellipses_t& ellipses) {
  const auto frame = std::find_if(recent_frames_.rbegin(), recent_frames_.rend(),
                                  [&](const frame_t& f) { return f.header.utime == ellipses.header.utime; });
  if (frame == recent_frames_.rend()) return {};
  const FrameImage image = frames_.image(*frame);
  count_frame_loss(bus_, image.fault);
  return image.pixels;
}

void TrackerStage::on_command(const track_command_t& command) {
  const bool same_choice =
      command_ && command_->choice == command.choice && command_->action == command.action;
  command_ = command;
  // the same choice sent again is for a tracker that was restarted, or has not found it yet
  if (same_choice && target_status_ != TrackStatus::searching) return;
  if (!same_choice) tracker_.release();
  switch (command.action) {
    case track_command_t::ACTION_RELEASE:
      tracker_.release();
      break;
    case track_command_t::ACTION_BY_ID:
      follow_id(command.id, pixel_of(command));
      break;
    case track_command_t::ACTION_BY_PIXEL:
      tracker_.follow_pixel({command.u_px, command.v_px});
      break;
    case track_command_t::ACTION_FIRST_CIRCLE:
      tracker_.follow_first_circle();
      break;
  }
}

void TrackerStage::follow_id(int64_t id, const std::optional<Eigen::Vector2d>& pixel) {
  // the id may be one that another run of this process gave: where it was last seen has the last word
  const auto track =
      std::find_if(tracks_.begin(), tracks_.end(), [id](const Track& t) { return t.id == id; });
  const auto is_there = [&pixel](const Track& t) {
    const Ellipse& e = t.detection.outer.ellipse;
    return (Eigen::Vector2d(e.u_px, e.v_px) - *pixel).norm() <= 2 * e.a_px;
  };
  if (pixel && (track == tracks_.end() || !is_there(*track))) return tracker_.follow_pixel(*pixel);
  tracker_.follow_id(id, pixel);
}

void TrackerStage::on_ellipses(const ellipses_t& ellipses) {
  std::vector<Detection> detections;
  for (const auto& ellipse : ellipses.ellipses) detections.push_back(from_message(ellipse));
  TrackerResult result =
      tracker_.step(seconds(ellipses.header.utime), image_of(ellipses), detections, view_of(ellipses));
  target_status_ = result.target.status;

  tracks_t tracks{};
  tracks.header.utime = ellipses.header.utime;
  tracks.header.frame_seq = ellipses.header.frame_seq;
  tracks.width_px = ellipses.width_px;
  tracks.height_px = ellipses.height_px;
  for (const Track& track : result.tracks) tracks.tracks.push_back(to_message(track));
  tracks.count = static_cast<int16_t>(tracks.tracks.size());
  tracks.target_id = result.target.id.value_or(-1);
  tracks.target_status = to_message(result.target.status);
  tracks.target_reason = result.target.reason;
  tracks.command_seq = command_ ? command_->header.seq : -1;
  if (result.target.window) set_window(tracks, *result.target.window);
  tracks_ = std::move(result.tracks);
  bus_.publish(channels::tracks, tracks);
}

}  // namespace stevedore
