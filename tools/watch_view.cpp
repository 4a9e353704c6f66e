#include "tools/watch_view.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "lcmtypes/names.hpp"

namespace stevedore {
namespace {

/// After the camera's end: many times the line's latency.
constexpr double drain_s = 2;

double seconds(int64_t duration_us) {
  return static_cast<double>(duration_us) * 1e-6;
}

int64_t published_by(const health_t& health, const std::string& channel) {
  for (const auto& output : health.outputs) {
    if (output.channel == channel) return output.published;
  }
  return 0;
}

}  // namespace

WatchView::WatchView(int64_t start_utime, int cargoes)
    : start_utime_(start_utime), cargoes_(cargoes), line_utime_(start_utime) {}

void WatchView::on_health(const health_t& health, int64_t now) {
  health_.add(health);
  heard_utime_[health.process] = now;
  const bool needs_telling =
      health.state == health_t::STATE_DEGRADED || health.state == health_t::STATE_FAILED;
  const std::string condition =
      needs_telling ? fmt::format("{}: {}", state_name(health.state), health.message) : "";
  std::string& told = condition_[health.process];
  if (condition != told) {
    news_.push_back(fmt::format("{} {}", health.process, needs_telling ? condition : "is well again"));
    told = condition;
  }
  if (!is_camera(health.process)) return;
  if (camera_run_id_ != health.header.trace.run_id) newest_answered_seq_ = -1;
  camera_run_id_ = health.header.trace.run_id;
  camera_finished_ = health.state == health_t::STATE_FINISHED;
  camera_message_ = health.message;
  published_ = published_by(health, channels::frame.name);
}

void WatchView::on_frame(const header_t& frame) {
  int64_t& drops = camera_drops_[frame.trace.run_id];
  drops = std::max(drops, frame.frame_seq - frame.seq);
}

void WatchView::on_ellipses(const ellipses_t&, int64_t now) {
  output_utime_[channels::ellipses.name] = now;
}

void WatchView::on_tracks(const tracks_t& tracks, int64_t now) {
  output_utime_[channels::tracks.name] = now;
  if (tracks.target_status == track_t::STATUS_TRACKING) ++tracked_;
  target_ = status_name(tracks.target_status);
  if (tracks.target_id >= 0) target_ += fmt::format(" #{}", tracks.target_id);
}

void WatchView::on_poses(const poses_t&, int64_t now) {
  output_utime_[channels::poses.name] = now;
}

void WatchView::on_mission(const mission_t& mission, int64_t now) {
  phase_ = phase_name(mission.phase);
  delivered_ = mission.delivered;
  circle_ =
      mission.target_slot < 0 ? "-" : fmt::format("{}.{}", mission.target_platform, mission.target_slot);
  has_flown_ = has_flown_ || mission.has_setpoint;
  const bool over =
      mission.phase == mission_t::PHASE_COMPLETE || (has_flown_ && mission.phase == mission_t::PHASE_IDLE);
  if (!over) over_utime_.reset();
  if (over && !over_utime_) over_utime_ = now;
  emergencies_.clear();
  for (const auto& emergency : mission.emergencies) {
    emergencies_ += fmt::format("{}{}", emergencies_.empty() ? "" : ", ", emergency_name(emergency.kind));
  }
  if (mission.header.frame_seq < 0) return;
  output_utime_[channels::mission.name] = now;
  ++frames_out_;
  newest_answered_seq_ = std::max(newest_answered_seq_, mission.header.frame_seq);
  latencies_us_.push_back(now - mission.header.utime);
}

double WatchView::silent_s(int64_t now) const {
  const auto heard = output_utime_.find(channels::mission.name);
  return seconds(now - (heard == output_utime_.end() ? start_utime_ : heard->second));
}

bool WatchView::worked_off(int64_t now) const {
  if (!camera_finished_ || frames_out_ == 0) return false;
  const auto drops = camera_drops_.find(camera_run_id_);
  const int64_t owed = published_ + (drops == camera_drops_.end() ? 0 : drops->second);
  return newest_answered_seq_ + 1 >= owed || silent_s(now) >= drain_s;
}

bool WatchView::mission_over(int64_t now) const {
  return cargoes_ > 0 && over_utime_ && seconds(now - *over_utime_) >= drain_s;
}

bool WatchView::ended_without_frames() const {
  return camera_finished_ && frames_in() == 0;
}

std::string WatchView::silence(int64_t now) const {
  std::string processes;
  const auto lines = stage_lines_of(health_);
  for (const StageLine& line : lines) {
    const auto heard = heard_utime_.find(line.process);
    if (heard != heard_utime_.end() && seconds(now - heard->second) <= channels::health.max_age_s) continue;
    processes += fmt::format("{}{}", processes.empty() ? "" : ", ", line.process);
  }
  if (!processes.empty()) return fmt::format("No HEALTH from {}.", processes);
  if (frames_in() == 0)
    return fmt::format("Every process is there, but {} published no FRAME.", lines.front().process);
  for (const StageLine& line : lines) {
    const auto heard = output_utime_.find(line.output);
    const double last = seconds(now - (heard == output_utime_.end() ? start_utime_ : heard->second));
    if (is_camera(line.process) || last < silent_s(now)) continue;
    return fmt::format("Every process is there, but no {} comes from {}.", line.output, line.process);
  }
  return "Every process is there.";
}

int64_t WatchView::frames_in() const {
  int64_t published = 0;
  for (const auto& [run_id, health] : health_.runs_of(stage_lines_of(health_).front().process)) {
    published += published_by(health, channels::frame.name);
  }
  return std::max(published, frames_out_);  // HEALTH comes once a second
}

/// Of what is watched: a mission, or a film.
std::string WatchView::progress() const {
  if (cargoes_ > 0) {
    return fmt::format("{:<11}  delivered {}/{}  target {} {}", phase_, delivered_, cargoes_, circle_,
                       target_);
  }
  return fmt::format("frames {}/{}  tracked {}  {}  {}", frames_in(), frames_out_, tracked_, target_, phase_);
}

std::string WatchView::line(int64_t now) {
  int64_t lost = 0, skipped = 0;
  for (const auto& [process, runs] : health_.processes()) {
    for (const auto& [run_id, health] : runs) {
      for (const auto& input : health.inputs) {
        lost += lost_of(input);
        skipped += input.skipped;
      }
    }
  }
  int64_t drops = 0;
  for (const auto& [run_id, of_run] : camera_drops_) drops += of_run;
  const double elapsed_s = seconds(now - std::exchange(line_utime_, now));
  const double rate_hz = elapsed_s > 0 ? static_cast<double>(latencies_us_.size()) / elapsed_s : 0;
  const auto latency = percentiles_of(std::exchange(latencies_us_, {}));
  return fmt::format("{:4.0f} s  {}  {:.1f}/s  {} ms  lost {}  skipped {}{}{}", seconds(now - start_utime_),
                     progress(), rate_hz,
                     latency ? fmt::format("{:.0f}/{:.0f}", latency->p50_ms, latency->p99_ms) : "-", lost,
                     skipped, drops > 0 ? fmt::format("  camera drops {}", drops) : "",
                     emergencies_.empty() ? "" : "  ! " + emergencies_);
}

std::vector<std::string> WatchView::take_news() {
  return std::exchange(news_, {});
}

}  // namespace stevedore
