#include "mission_proc/deck_path.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace stevedore {
namespace {

double seconds(std::int64_t us) {
  return static_cast<double>(us) * 1e-6;
}

/// Cubic through two points with their velocities (Hermite).
PointPath between(const DeckKnot& a, const DeckKnot& b, double ahead_s) {
  const double h = b.ahead_s - a.ahead_s, s = (ahead_s - a.ahead_s) / h, s2 = s * s, s3 = s2 * s;
  PointPath point;
  point.position_m = (2 * s3 - 3 * s2 + 1) * a.center_ned_m + (s3 - 2 * s2 + s) * h * a.velocity_ned_mps +
                     (3 * s2 - 2 * s3) * b.center_ned_m + (s3 - s2) * h * b.velocity_ned_mps;
  point.velocity_mps = (6 * s2 - 6 * s) / h * (a.center_ned_m - b.center_ned_m) +
                       (3 * s2 - 4 * s + 1) * a.velocity_ned_mps + (3 * s2 - 2 * s) * b.velocity_ned_mps;
  return point;
}

}  // namespace

Eigen::Vector2d ned_from_deck(const Eigen::Vector2d& deck, double heading_rad) {
  return Eigen::Rotation2Dd(heading_rad) * deck;
}

Eigen::Vector2d deck_from_ned(const Eigen::Vector2d& ned, double heading_rad) {
  return Eigen::Rotation2Dd(-heading_rad) * ned;
}

DeckPath::DeckPath(const DeckNews& report, const VehicleMoment& vehicle)
    : news_(report), ned_from_odometry_m_(vehicle.ned_from_odometry_m) {
  for (DeckKnot& knot : news_.knots) knot.center_ned_m -= ned_from_odometry_m_;
  for (SlotReport& slot : news_.slots) {
    slot.center_ned_m -= ned_from_odometry_m_;
    places_m_.push_back(
        deck_from_ned((slot.center_ned_m - news_.knots.front().center_ned_m).head<2>(), news_.heading_rad));
  }
}

PointPath DeckPath::center(std::int64_t utime) const {
  const double ahead_s = seconds(utime - news_.utime);
  const auto& knots = news_.knots;
  const auto next =
      std::find_if(knots.begin(), knots.end(), [&](const DeckKnot& knot) { return knot.ahead_s > ahead_s; });
  if (next != knots.begin() && next != knots.end()) return between(*std::prev(next), *next, ahead_s);
  const DeckKnot& nearest = next == knots.begin() ? knots.front() : knots.back();
  return {nearest.center_ned_m + (ahead_s - nearest.ahead_s) * nearest.velocity_ned_mps,
          nearest.velocity_ned_mps};
}

Eigen::Vector3d DeckPath::normal(std::int64_t utime) const {
  const double ahead_s = seconds(utime - news_.utime);
  const auto& knots = news_.knots;
  const auto next =
      std::find_if(knots.begin(), knots.end(), [&](const DeckKnot& knot) { return knot.ahead_s > ahead_s; });
  if (next == knots.begin()) return knots.front().normal_ned;
  if (next == knots.end()) return knots.back().normal_ned;
  const DeckKnot& a = *std::prev(next);
  const double share = (ahead_s - a.ahead_s) / (next->ahead_s - a.ahead_s);
  return ((1 - share) * a.normal_ned + share * next->normal_ned).normalized();
}

double DeckPath::heading_rad(std::int64_t utime) const {
  return news_.heading_rad + news_.turn_rate_radps * seconds(utime - news_.utime);
}

Eigen::Vector3d DeckPath::on_deck(const Eigen::Vector2d& place_m, double height_m, std::int64_t utime) const {
  const Eigen::Vector2d out_m = ned_from_deck(place_m, heading_rad(utime));
  const Eigen::Vector3d up = normal(utime);
  const double down_m = -(up.x() * out_m.x() + up.y() * out_m.y()) / up.z();
  return center(utime).position_m + Eigen::Vector3d(out_m.x(), out_m.y(), down_m) + height_m * up;
}

PointPath DeckPath::point(const Eigen::Vector2d& place_m, double height_m, std::int64_t utime) const {
  constexpr std::int64_t apart_us = 50'000;
  const Eigen::Vector3d now_m = on_deck(place_m, height_m, utime);
  return {now_m, (on_deck(place_m, height_m, utime + apart_us) - now_m) / seconds(apart_us)};
}

std::optional<Eigen::Vector2d> DeckPath::place_below(const Eigen::Vector3d& eye_odometry_m,
                                                     const Eigen::Vector3d& top_odometry_m, double height_m,
                                                     std::int64_t utime) const {
  constexpr double range_off = 0.1;  // half of what a bucket's foot is off that is taken for its rim
  const Eigen::Vector3d up = normal(utime), middle_m = center(utime).position_m;
  const Eigen::Vector3d ray_m = top_odometry_m - eye_odometry_m;
  const double range = (height_m - up.dot(eye_odometry_m - middle_m)) / up.dot(ray_m);
  if (!(std::abs(range - 1) < range_off)) return std::nullopt;
  const Eigen::Vector3d foot_m = eye_odometry_m + range * ray_m - height_m * up - middle_m;
  return deck_from_ned(foot_m.head<2>(), heading_rad(utime));
}

double DeckPath::age_s(std::int64_t utime) const {
  return news_.seen_utime < 0 ? 1e9 : seconds(utime - news_.seen_utime);
}

}  // namespace stevedore
