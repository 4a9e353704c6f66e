#include "tracker_proc/camera_turn.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace stevedore {
namespace {

// More than a second at 50 Hz: longer than any frame waits.
constexpr std::size_t kHistory = 64;

// Two samples missing at 50 Hz. A gust of 3 rad/s^2 unheard of turns the camera by 4 mrad in that time: 1.3
// px.
constexpr double kLongestReach_s = 0.05;

template <class Sample>
void keep(std::deque<Sample>& samples, const Sample& sample) {
  if (!samples.empty() && sample.time_s < samples.back().time_s) samples.clear();  // started anew
  samples.push_back(sample);
  if (samples.size() > kHistory) samples.pop_front();
}

template <class Sample>
const Sample* nearest(const std::deque<Sample>& samples, double time_s) {
  const Sample* best = nullptr;
  for (const Sample& s : samples)
    if (!best || std::abs(s.time_s - time_s) < std::abs(best->time_s - time_s)) best = &s;
  return best && std::abs(best->time_s - time_s) <= kLongestReach_s ? best : nullptr;
}

Eigen::Quaterniond attitude_at(const AttitudeSample& sample, double time_s) {
  const Eigen::Vector3d turn = sample.rate_body_radps * (time_s - sample.time_s);
  const double angle = turn.norm();
  if (!(angle > 0)) return sample.ned_from_body;
  return sample.ned_from_body * Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle));
}

/// Along the line through the two samples around time_s, or the two last ones before it.
GimbalAngles angles_at(const std::deque<GimbalSample>& samples, double time_s) {
  if (samples.size() < 2) return samples.front().angles;
  auto after = std::find_if(samples.begin(), samples.end(), [&](auto& s) { return s.time_s >= time_s; });
  after = std::clamp(after, samples.begin() + 1, samples.end() - 1);
  const GimbalSample &one = *(after - 1), &other = *after;
  const double between_s = other.time_s - one.time_s;
  const double share = between_s > 0 ? (time_s - one.time_s) / between_s : 1;
  const auto along = [share](double from, double to) { return from + share * (to - from); };
  return {along(one.angles.roll_rad, other.angles.roll_rad),
          along(one.angles.pitch_rad, other.angles.pitch_rad)};
}

}  // namespace

void CameraTurn::add(const AttitudeSample& sample) {
  keep(attitudes_, sample);
}

void CameraTurn::add(const GimbalSample& sample) {
  keep(gimbals_, sample);
}

std::optional<Eigen::Matrix3d> CameraTurn::ned_from_camera(double time_s) const {
  const AttitudeSample* attitude = nearest(attitudes_, time_s);
  if (!attitude || (!gimbals_.empty() && !nearest(gimbals_, time_s))) return std::nullopt;
  const GimbalAngles angles = gimbals_.empty() ? GimbalAngles{} : angles_at(gimbals_, time_s);
  return attitude_at(*attitude, time_s).normalized().toRotationMatrix() * body_from_camera(angles, mount_);
}

std::optional<Eigen::Matrix3d> CameraTurn::homography_to(double time_s) {
  const auto before = before_;
  before_ = ned_from_camera(time_s);
  if (!before || !before_) return std::nullopt;
  const Eigen::Matrix3d k = camera_.matrix();
  return k * before_->transpose() * *before * k.inverse();
}

}  // namespace stevedore
