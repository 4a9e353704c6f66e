#include "tools/replay_compare.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <tuple>

#include "tools/replay_core.hpp"

namespace stevedore {
namespace {

constexpr double center_px = 0.5, semi_axis_px = 1;
constexpr double standard_deviations = 3;
constexpr double share_that_may_differ = 0.1;
constexpr int64_t always_may_differ = 2;

bool near(const ellipse_shape_t& a, const ellipse_shape_t& b) {
  return std::hypot(a.u_px - b.u_px, a.v_px - b.v_px) <= center_px &&
         std::abs(a.a_px - b.a_px) <= semi_axis_px && std::abs(a.b_px - b.b_px) <= semi_axis_px;
}

/// The distance against the standard deviation of its length.
bool near(const double (&a)[3], const double (&b)[3], const double (&covariance_m2)[9]) {
  const double variance_m2 = covariance_m2[0] + covariance_m2[4] + covariance_m2[8];
  return std::hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) <= standard_deviations * std::sqrt(variance_m2);
}

/// Whole ellipses of a that b has none near.
int64_t without_counterpart(const ellipses_t& a, const ellipses_t& b) {
  return std::count_if(a.ellipses.begin(), a.ellipses.end(), [&b](const ellipse_t& e) {
    return e.kind == ellipse_t::KIND_WHOLE &&
           std::none_of(b.ellipses.begin(), b.ellipses.end(),
                        [&e](const ellipse_t& other) { return near(e.outer, other.outer); });
  });
}

bool alike(const ellipses_t& a, const ellipses_t& b) {
  const auto larger = static_cast<double>(std::max(a.ellipses.size(), b.ellipses.size()));
  const auto allowed = std::max<int64_t>(always_may_differ, std::llround(share_that_may_differ * larger));
  return without_counterpart(a, b) <= allowed && without_counterpart(b, a) <= allowed;
}

const track_t* target_of(const tracks_t& tracks) {
  const auto found = std::find_if(tracks.tracks.begin(), tracks.tracks.end(),
                                  [&tracks](const track_t& t) { return t.id == tracks.target_id; });
  return found == tracks.tracks.end() ? nullptr : &*found;
}

bool alike(const tracks_t& a, const tracks_t& b) {
  const track_t *target_a = target_of(a), *target_b = target_of(b);
  if (a.target_status != b.target_status || !target_a != !target_b) return false;
  return !target_a || near(target_a->ellipse.outer, target_b->ellipse.outer);
}

const circle_solution_t* target_of(const poses_t& poses) {
  for (const pose_t& pose : poses.poses) {
    if (pose.is_target && !pose.solutions.empty()) return &pose.solutions.front();
  }
  return nullptr;
}

bool alike(const poses_t& a, const poses_t& b) {
  const circle_solution_t *target_a = target_of(a), *target_b = target_of(b);
  if (a.target_status != b.target_status || !target_a != !target_b) return false;
  return !target_a || near(target_a->center_camera_m, target_b->center_camera_m, target_a->covariance_m2);
}

bool alike(const platform_estimate_t& a, const platform_estimate_t& b) {
  if (a.platform != b.platform || a.identity_certain != b.identity_certain ||
      a.slots.size() != b.slots.size())
    return false;
  double position_m2[9] = {};
  for (int axis = 0; axis < 3; ++axis) position_m2[4 * axis] = a.covariance[7 * axis];
  return near(a.center_ned_m, b.center_ned_m, position_m2);
}

std::set<int16_t> kinds_of(const std::vector<emergency_t>& emergencies) {
  std::set<int16_t> kinds;
  for (const emergency_t& emergency : emergencies) kinds.insert(emergency.kind);
  return kinds;
}

bool alike(const mission_t& a, const mission_t& b) {
  const auto decision = [](const mission_t& m) {
    return std::tuple(m.phase, m.action, m.target_status, m.has_target_level, m.delivered, m.attempts,
                      kinds_of(m.emergencies));
  };
  if (decision(a) != decision(b)) return false;
  return !a.has_target_level || near(a.target_level_m, b.target_level_m, a.target_level_covariance_m2);
}

bool alike(const track_command_t& a, const track_command_t& b) {
  return a.action == b.action && a.choice == b.choice &&
         std::hypot(a.u_px - b.u_px, a.v_px - b.v_px) <= center_px;
}

template <class M>
bool alike(const LogEvent& logged, const LogEvent& replayed, const Channel<M>& channel) {
  const auto a = decode(logged, channel), b = decode(replayed, channel);
  return a && b && alike(*a, *b);
}

}  // namespace

const char* const lossy_tolerances =
    "whole ellipses and the target within 0.5 px (semi-axes 1 px), its pose and the platforms within three "
    "standard deviations, the mission's decisions equal";

Match match_of(const LogEvent& logged, const LogEvent& replayed, bool frames_are_lossy) {
  if (payload_of(logged.channel, logged.bytes) == payload_of(replayed.channel, replayed.bytes))
    return Match::equal;
  if (!frames_are_lossy) return Match::different;
  const bool within =
      alike(logged, replayed, channels::ellipses) || alike(logged, replayed, channels::tracks) ||
      alike(logged, replayed, channels::poses) || alike(logged, replayed, channels::platform_estimate) ||
      alike(logged, replayed, channels::mission) || alike(logged, replayed, channels::track_command);
  return within ? Match::within_tolerance : Match::different;
}

}  // namespace stevedore
