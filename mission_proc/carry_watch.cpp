// What the mission finds wrong by itself.
#include <fmt/format.h>

#include <Eigen/Dense>
#include <cmath>

#include "mission_proc/carry.hpp"

namespace stevedore {
namespace {

double seconds(std::int64_t us) {
  return static_cast<double>(us) * 1e-6;
}

bool same(const LevelFrame& a, const LevelFrame& b) {
  if (a.marks.size() != b.marks.size()) return false;
  for (std::size_t i = 0; i < a.marks.size(); ++i) {
    if (a.marks[i].track_id != b.marks[i].track_id || a.marks[i].image_px != b.marks[i].image_px)
      return false;
  }
  return true;
}

}  // namespace

/// A laser that looks down on a deck in view must read what vision says: but for a cargo that stands in its
/// way. One that looks beside contradicts nothing.
void Carry::watch_laser(std::int64_t utime, double range_m, const Eigen::Vector3d& laser_odometry_m,
                        const Eigen::Vector3d& beam) {
  constexpr double on_deck_m =
      1.2;  // from the middle: inside of the circles' square, well inside of the deck
  constexpr double tolerance_m = 0.5;  // a cargo and its handle, 0.42 m, and three sigma of both
  std::string contradiction;
  for (const auto& [platform, course] : decks_) {
    if (course.age_s(utime) > 0.3) continue;
    const Eigen::Vector3d up = course.normal(utime), middle_m = course.center(utime).position_m;
    const double expected_m = up.dot(middle_m - laser_odometry_m) / up.dot(beam);
    const bool on_deck = (laser_odometry_m + expected_m * beam - middle_m).norm() < on_deck_m;
    if (on_deck && std::abs(range_m - expected_m) > tolerance_m)
      contradiction =
          fmt::format("laser {:.2f} m, vision {:.2f} m over platform {}", range_m, expected_m, platform);
  }
  board_.set(Emergency::altitude_disagrees, !contradiction.empty(), seconds(utime_), contradiction);
}

/// Noise makes any two frames of a real camera differ, and so the ellipses found in them: to the last bit.
void Carry::watch_frames(const LevelFrame& frame) {
  constexpr double frozen_s = 0.5;
  const bool frozen_now = !frame.marks.empty() && same(frame, last_frame_);
  if (!frozen_now) unchanged_since_ = frame.utime;
  board_.set(Emergency::camera_frozen, seconds(frame.utime - unchanged_since_) > frozen_s, seconds(utime_),
             fmt::format("frames show the same to the last bit for more than {:.1f} s", frozen_s));
  last_frame_ = frame;
}

void Carry::watch_target() {
  const bool at_it = record_.phase == Phase::approach || record_.phase == Phase::descend ||
                     record_.phase == Phase::load || record_.phase == Phase::drop;
  board_.set(Emergency::target_lost, at_it && target_age_s() > settings_.oldest_s, seconds(utime_),
             fmt::format("platform of the target not seen for more than {:.1f} s", settings_.oldest_s));
  const DeckPath* course = record_.target ? deck(record_.target->platform) : nullptr;
  board_.set(Emergency::identity_uncertain, at_it && course && !course->news().identity_certain,
             seconds(utime_), "the numbers of the target's platform and circles may be others");
  board_.set(Emergency::platform_not_found,
             record_.phase == Phase::search && goal_age_s() >= settings_.oldest_s, seconds(utime_),
             fmt::format("platform {} is not in view", goal_platform()));
  // nothing contradicts any more, nothing is frozen, where nothing comes
  constexpr double silent_s = 0.3;
  if (seconds(utime_ - ground_utime_) > silent_s)
    board_.set(Emergency::altitude_disagrees, false, seconds(utime_), "");
  if (seconds(utime_ - last_frame_.utime) > 1)
    board_.set(Emergency::camera_frozen, false, seconds(utime_), "");
  // what happened is over at once, and stays to be read for the time that the board keeps it
  board_.set(Emergency::cargo_lost, false, seconds(utime_), "");
}

}  // namespace stevedore
