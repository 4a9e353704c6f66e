#include "sim_proc/world/speed_profile.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

namespace stevedore::world {

using std::numbers::pi;

SpeedProfile::SpeedProfile(std::vector<Stretch> cycle) {
  double speed_mps = cycle.back().end_mps;
  for (const Stretch& stretch : cycle) {
    pieces_.push_back({cycle_s_, stretch.duration_s, cycle_m_, speed_mps, stretch.end_mps});
    cycle_s_ += stretch.duration_s;
    cycle_m_ += stretch.duration_s * (speed_mps + stretch.end_mps) / 2;
    speed_mps = stretch.end_mps;
  }
}

SpeedProfile::At SpeedProfile::Piece::at(double since_s) const {
  const double phase_rad = pi * since_s / duration_s, half_change_mps = (end_mps - from_mps) / 2;
  return {from_m + from_mps * since_s + half_change_mps * (since_s - duration_s / pi * std::sin(phase_rad)),
          from_mps + half_change_mps * (1 - std::cos(phase_rad))};
}

SpeedProfile::At SpeedProfile::at(double time_s) const {
  const double cycles = std::floor(time_s / cycle_s_);
  const double since_s = time_s - cycles * cycle_s_;
  const auto next = std::upper_bound(pieces_.begin(), pieces_.end(), since_s,
                                     [](double s, const Piece& piece) { return s < piece.from_s; });
  const Piece& piece = *std::prev(next);
  At at = piece.at(since_s - piece.from_s);
  at.distance_m += cycles * cycle_m_;
  return at;
}

double SpeedProfile::middle_m() const {
  double least_m = 0, most_m = 0;
  for (const Piece& piece : pieces_) {
    const double end_m = piece.at(piece.duration_s).distance_m;
    least_m = std::min(least_m, end_m);
    most_m = std::max(most_m, end_m);
  }
  return (least_m + most_m) / 2;
}

}  // namespace stevedore::world
