#include "camera_proc/camera_stage.hpp"

#include <fmt/format.h>

#include <vector>

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
    : bus_(bus), camera_(settings), output_(settings.frames, std::move(ring_name)) {
  if (camera) maps_ = make_rectify_maps(*camera);
}

Condition CameraStage::work() {
  if (const auto frame = camera_.next()) send(*frame);
  camera_.wait();
  const CameraStatus status = camera_.status();
  if (refusal_) return {health_t::STATE_FAILED, *refusal_};
  const CameraCounts counts = camera_.counts();
  std::vector<std::string> remarks;
  if (!status.message.empty()) remarks.push_back(status.message);
  if (counts.unreadable > 0) remarks.push_back(fmt::format("{} unreadable", counts.unreadable));
  if (counts.late_ticks > 0)
    remarks.push_back(fmt::format("{} frames left out: this process was late", counts.late_ticks));
  return {to_message(status.state), fmt::format("{}", fmt::join(remarks, "; "))};
}

void CameraStage::send(const CameraFrame& frame) {
  frame_t message{};
  message.header.utime = frame.capture_utime;
  message.header.frame_seq = frame_seq_++;
  refusal_ = output_.put(rectify(frame.pixels, maps_), message);
  if (!refusal_) bus_.publish(channels::frame, message);
}

}  // namespace stevedore
