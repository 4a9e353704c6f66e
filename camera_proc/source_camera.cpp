#include "camera_proc/source_camera.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <exception>
#include <thread>
#include <utility>

#include "runtime/time.hpp"

namespace stevedore {
namespace {

// A fault shows in at least one HEALTH message, which are a second apart.
constexpr std::int64_t fault_shown_us = 2'000'000;
// Devices take seconds to open and start; OpenCV's V4L2 code itself gives up after 10 s.
constexpr std::int64_t first_frame_allowance_us = 10'000'000;
constexpr std::int64_t longest_wait_us = 100'000;
constexpr std::int64_t unpaced_wait_us =
    500;  // a look at the bus between two frames: below what the line takes for one
constexpr double image_rate_hz = 30;

std::int64_t to_us(double seconds) {
  return std::llround(seconds * 1e6);
}

std::string in_seconds(std::int64_t us) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f s", static_cast<double>(us) / 1e6);
  return text;
}

bool identical(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  const std::size_t row_bytes = static_cast<std::size_t>(a.cols) * a.elemSize();
  for (int v = 0; v < a.rows; ++v)
    if (std::memcmp(a.ptr(v), b.ptr(v), row_bytes) != 0) return false;
  return true;
}

}  // namespace

Pacer::Pacer(double rate_hz, std::int64_t start_utime)
    : period_us_(1e6 / rate_hz), start_utime_(start_utime) {}

std::int64_t Pacer::due_utime() const {
  return start_utime_ + std::llround(static_cast<double>(tick_) * period_us_);
}

void Pacer::advance(std::int64_t now_utime) {
  const auto late_us = static_cast<double>(now_utime - due_utime());
  const std::int64_t missed = std::max<std::int64_t>(0, static_cast<std::int64_t>(late_us / period_us_));
  late_ticks_ += missed;
  tick_ += missed + 1;
}

Camera::Camera(const CameraSettings& settings) : Camera(settings, make_opener(settings), monotonic_utime) {}

Camera::Camera(const CameraSettings& settings, Opener open, Clock clock)
    : settings_(settings), open_(std::move(open)), clock_(std::move(clock)) {}

std::optional<CameraFrame> Camera::next() {
  if (finished_) return std::nullopt;
  if (!source_ && (clock_() < retry_utime_ || !open())) return std::nullopt;
  return source_->is_live() ? next_of_device() : next_of_files();
}

bool Camera::open() {
  std::string fault;
  try {
    source_ = open_(fault);
  } catch (const std::exception& error) {
    fault = error.what();
  }
  if (!source_) {
    lose(fault);
    finished_ = settings_.once && is_file();  // they will not come by waiting
    return false;
  }
  pass_frames_ = 0;
  heard_utime_.reset();
  opened_utime_ = changed_utime_ = clock_();
  return true;
}

bool Camera::is_file() const {
  return settings_.kind == "images" || settings_.kind == "video";
}

// The waits double from loss to loss until a frame comes.
void Camera::lose(const std::string& why) {
  source_.reset();
  ahead_.release();
  if (pacer_) counts_.late_ticks += pacer_->late_ticks();
  pacer_.reset();  // files that come back start a new schedule
  lost_ = true;
  note_fault(why);
  const std::int64_t longer = retry_wait_us_ == 0 ? to_us(settings_.retry_first_s) : 2 * retry_wait_us_;
  retry_wait_us_ = std::min(longer, to_us(settings_.retry_limit_s));
  retry_utime_ = clock_() + retry_wait_us_;
}

void Camera::note_fault(const std::string& what) {
  fault_ = what;
  fault_utime_ = clock_();
}

CameraFrame Camera::deliver(cv::Mat frame, std::int64_t capture_utime) {
  if (lost_ && counts_.frames > 0) {
    ++counts_.reopened;
    note_fault("back after: " + fault_);
  }
  lost_ = false;
  retry_wait_us_ = 0;
  ++counts_.frames;
  return {std::move(frame), capture_utime};
}

std::optional<CameraFrame> Camera::next_of_files() {
  if (ahead_.empty() && !read_ahead()) return std::nullopt;
  const std::int64_t now = clock_();
  if (!pacer_) {
    const double own_hz = source_->own_rate_hz();
    pacer_.emplace(settings_.rate_hz > 0 ? settings_.rate_hz : own_hz > 0 ? own_hz : image_rate_hz, now);
  }
  const std::int64_t due = pacer_->due_utime();
  if (settings_.paced && now < due) return std::nullopt;
  const std::int64_t late_before = pacer_->late_ticks();
  pacer_->advance(settings_.paced ? now : due);
  if (pacer_->late_ticks() > late_before) note_fault("files are played slower than rate_hz asks for");
  ++pass_frames_;
  return deliver(std::exchange(ahead_, cv::Mat()), settings_.paced ? now : due);
}

// An unreadable file costs no tick: the next one takes its place.
bool Camera::read_ahead() {
  cv::Mat raw;
  std::int64_t ignored = 0;
  const Grab outcome = source_->grab(raw, ignored);
  if (outcome == Grab::end) end_of_files();
  if (outcome == Grab::end || outcome == Grab::none) return false;
  std::string fault;
  if (outcome == Grab::failed) {
    fault = source_->fault();
  } else if (auto frame = to_frame(raw, settings_.colour, fault)) {
    ahead_ = std::move(*frame);
    return true;
  }
  ++counts_.unreadable;
  note_fault(fault);
  return false;
}

void Camera::end_of_files() {
  if (settings_.once) {
    finished_ = true;
    source_.reset();
  } else if (pass_frames_ == 0) {
    lose("nothing readable in '" + settings_.source + "'");
  } else {
    source_.reset();  // the next call opens it again: the schedule goes on
  }
}

std::optional<CameraFrame> Camera::next_of_device() {
  cv::Mat raw;
  std::int64_t capture_utime = 0;
  const Grab outcome = source_->grab(raw, capture_utime);
  counts_.superseded += source_->take_superseded();
  const std::int64_t now = clock_();
  if (outcome == Grab::none) {
    check_silence(now);
    return std::nullopt;
  }
  std::string fault;
  std::optional<cv::Mat> frame;
  if (outcome == Grab::frame)
    frame = to_frame(raw, settings_.colour, fault);
  else
    fault = source_->fault();
  if (!frame) {
    if (outcome == Grab::frame) ++counts_.unreadable;
    lose(fault);
    return std::nullopt;
  }
  heard_utime_ = now;
  if (check_frozen(raw, now)) return std::nullopt;
  return deliver(std::move(*frame), capture_utime);
}

void Camera::check_silence(std::int64_t now) {
  const std::int64_t frozen_us = to_us(settings_.frozen_after_s);
  const std::int64_t allowed_us = heard_utime_ ? frozen_us : std::max(frozen_us, first_frame_allowance_us);
  const std::int64_t silent_us = now - heard_utime_.value_or(opened_utime_);
  if (silent_us >= allowed_us) lose("no frame for " + in_seconds(silent_us));
}

// No two images of a real sensor are bit-identical, for its noise. One repeated for long stands still in a
// driver or a cable, and is not shown as if it were the present.
bool Camera::check_frozen(const cv::Mat& raw, std::int64_t now) {
  if (!identical(raw, last_)) {
    last_ = raw;
    changed_utime_ = now;
    frozen_ = false;
    return false;
  }
  const std::int64_t same_us = now - changed_utime_;
  if (same_us >= to_us(settings_.frozen_after_s)) {
    frozen_ = true;
    lose("frozen: the same image for " + in_seconds(same_us));
  }
  return frozen_;
}

CameraStatus Camera::status() const {
  using State = CameraStatus::State;
  const std::int64_t now = clock_();
  if (finished_)
    return {State::finished,
            counts_.frames > 0 ? "all was played" : "ended without a readable frame: " + fault_};
  if (lost_ && !source_ && fault_utime_) return {State::failed, fault_ + "; it is opened again and again"};
  if (lost_) return {State::failed, fault_ + (source_ ? "; opened, no frame yet" : "")};
  if (fault_utime_ && now - *fault_utime_ < fault_shown_us) return {State::degraded, fault_};
  return {State::ok, ""};
}

CameraCounts Camera::counts() const {
  CameraCounts counts = counts_;
  if (pacer_) counts.late_ticks += pacer_->late_ticks();
  return counts;
}

void Camera::wait() const {
  std::this_thread::sleep_for(std::chrono::microseconds(wait_us()));
}

std::int64_t Camera::wait_us() const {
  const std::int64_t now = clock_();
  std::int64_t until = now;
  if (finished_)
    until = now + longest_wait_us;
  else if (!source_)
    until = retry_utime_;
  else if (pacer_ && !settings_.paced)
    until = now + unpaced_wait_us;
  else if (pacer_ && !ahead_.empty())
    until = pacer_->due_utime();
  return std::clamp<std::int64_t>(until - now, 0, longest_wait_us);
}

}  // namespace stevedore
