#include "camera_proc/camera_stage.hpp"

#include <fmt/format.h>

#include <vector>

#include "runtime/time.hpp"

namespace stevedore {
namespace {

int8_t to_message(CameraStatus::State state) {
  switch (state) {
    case CameraStatus::State::ok:
      return health_t::STATE_OK;
    case CameraStatus::State::degraded:
      return health_t::STATE_DEGRADED;
    case CameraStatus::State::failed:
      return health_t::STATE_FAILED;
    case CameraStatus::State::finished:
      return health_t::STATE_FINISHED;
  }
  return health_t::STATE_FAILED;
}

}  // namespace

CameraStage::CameraStage(const CameraSettings& settings, const std::optional<CameraModel>& camera,
                         std::string ring_name, Bus& bus)
    : settings_(settings), bus_(bus), camera_(settings), output_(settings.frames, std::move(ring_name)) {
  if (camera) {
    model_ = camera;
    maps_ = make_rectify_maps(*camera);
  }
  if (!settings_.paced)
    bus_.subscribe<tracks_t>(channels::tracks,
                             [this](const tracks_t& m) { answered_seq_ = m.header.frame_seq; });
}

Condition CameraStage::work() {
  if (!line_is_busy()) {
    if (const auto frame = camera_.next()) send(*frame);
  }
  camera_.wait();
  const CameraStatus status = camera_.status();
  const CameraCounts counts = camera_.counts();
  const bool ended_well = to_message(status.state) == health_t::STATE_FINISHED && counts.frames > refused_;
  if (refusal_ && !ended_well) return {health_t::STATE_FAILED, *refusal_, source_health()};
  std::vector<std::string> remarks;
  if (refused_ > 0) remarks.push_back(fmt::format("{} not sent", refused_));
  if (!status.message.empty()) remarks.push_back(status.message);
  if (counts.unreadable > 0) remarks.push_back(fmt::format("{} unreadable", counts.unreadable));
  if (counts.late_ticks > 0)
    remarks.push_back(fmt::format("{} frames left out: this process was late", counts.late_ticks));
  if (counts.superseded > 0)
    remarks.push_back(
        fmt::format("{} frames left out: the device is faster than this process", counts.superseded));
  return {to_message(status.state), fmt::format("{}", fmt::join(remarks, "; ")), source_health()};
}

bool CameraStage::line_is_busy() const {
  constexpr int64_t patience_us = 1'000'000;
  const bool waits = !settings_.paced && frame_seq_ > 0 && answered_seq_ != frame_seq_ - 1;
  return waits && monotonic_utime() - sent_utime_ < patience_us;
}

input_health_t CameraStage::source_health() const {
  const CameraCounts counts = camera_.counts();
  input_health_t source{};
  source.channel = source_channel;
  source.handled = counts.frames - refused_;
  source.lost_malformed = counts.unreadable + refused_;
  source.skipped = counts.superseded + counts.late_ticks;
  source.received = source.handled + source.lost_malformed + source.skipped;
  return source;
}

void CameraStage::send(const CameraFrame& frame) {
  sent_utime_ = monotonic_utime();
  if (model_ &&
      (frame.pixels.cols != model_->given.width_px || frame.pixels.rows != model_->given.height_px)) {
    refusal_ = fmt::format(
        "the image has {}x{} pixels, the camera file says {}x{}: not sent; name this camera's own file in "
        "camera_file",
        frame.pixels.cols, frame.pixels.rows, model_->given.width_px, model_->given.height_px);
    ++refused_;
    return;
  }
  frame_t message{};
  message.header.utime = frame.capture_utime;
  message.header.frame_seq = frame_seq_++;
  refusal_ = output_.put(rectify(frame.pixels, maps_), message, bus_.receive_buffer_bytes());
  if (refusal_) {
    ++refused_;
    return;
  }
  bus_.publish(channels::frame, message);
}

}  // namespace stevedore
