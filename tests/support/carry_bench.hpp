// The carrying of cargoes on an aircraft that does what it is told.
#pragma once

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <functional>
#include <optional>
#include <vector>

#include "mission_proc/carry.hpp"

namespace stevedore {

inline constexpr double step_s = 0.02, gravity_mps2 = 9.81;

inline VehicleSample sample(double time_s, const Eigen::Vector3d& position_m,
                            const Eigen::Vector3d& velocity_mps,
                            const Eigen::Quaterniond& ned_from_body = Eigen::Quaterniond::Identity()) {
  return {static_cast<std::int64_t>(std::llround(time_s * 1e6)),
          position_m,
          velocity_mps,
          ned_from_body,
          Eigen::Vector3d::Zero(),
          1e-2,
          1e-6};
}

/// Two platforms that lie still 10 m apart, an aircraft, and a hook that hangs straight down.
class Bench {
 public:
  explicit Bench(bool loaded) : Bench(record(loaded)) {}
  explicit Bench(const CarryRecord& begins_with)
      : carry_(settings(), begins_with), closed_(begins_with.loaded) {}
  static CarryRecord record(bool loaded) {
    CarryRecord r;
    r.phase = Phase::search;
    r.loaded = loaded;
    return r;
  }

  static Eigen::Vector3d circle_m(int platform, int slot) {
    return {10.0 * platform + (slot < 2 ? 1.0 : -1.0), slot % 2 == 0 ? 1.0 : -1.0, 0};
  }

  void step() {
    if (const auto setpoint = carry_.setpoint()) {
      const Eigen::Vector3d wanted_m = setpoint->position_ned_m - gps_off_m + push_m;
      velocity_mps_ = 1.5 * (wanted_m - position_m_);
      if (velocity_mps_.norm() > 1.5) velocity_mps_ *= 1.5 / velocity_mps_.norm();
      heading_rad_ = setpoint->heading_rad;
    }
    position_m_ += step_s * velocity_mps_;
    time_s_ += step_s;
    const Eigen::Quaterniond turned(Eigen::AngleAxisd(heading_rad_, Eigen::Vector3d::UnitZ()));
    carry_.hear(sample(time_s_, position_m_ + gps_off_m, velocity_mps_, turned));
    if (autopilot_tells) carry_.hear(AutopilotReport{guided, false, false, battery_share});
    if (++steps_ % 5 == 0) look();
    if (carry_.action() == Action::release) closed_ = false;
    if (hook_tells) carry_.hear(HookReport{closed_ && !stands ? 15.0 : 0.0, closed_});
    if (laser_tells)
      carry_.hear_laser(now(), -position_m_.z() - 0.25 + laser_off_m);  // a laser at the default place
  }

  /// False: not within the time.
  bool run_until(const std::function<bool()>& done, double longest_s = 120) {
    for (double s = 0; s < longest_s; s += step_s) {
      if (done()) return true;
      step();
    }
    return done();
  }
  bool run_to(Phase phase) {
    return run_until([&] { return carry_.phase() == phase; });
  }
  void close() { closed_ = true; }
  /// The wind holds the aircraft over the middle of the target's platform.
  void push_to_middle() {
    const SlotId target = carry_.record().target.value();
    push_m.head<2>() =
        Eigen::Vector2d(10.0 * target.platform, 0) - circle_m(target.platform, target.slot).head<2>();
  }
  [[nodiscard]] bool raised(Emergency kind) const {
    const auto all = carry_.emergencies();
    return std::any_of(all.begin(), all.end(), [&](const RaisedEmergency& e) { return e.kind == kind; });
  }
  /// Until it is, or is no longer, raised; nothing if that takes too long.
  std::optional<double> seconds_until(Emergency kind, bool is_raised, double longest_s) {
    const double start_s = time_s_;
    if (!run_until([&] { return raised(kind) == is_raised; }, longest_s)) return std::nullopt;
    return time_s_ - start_s;
  }
  [[nodiscard]] const Carry& carry() const { return carry_; }
  Carry& told() { return carry_; }  ///< for the operator
  void run(double longest_s) {
    run_until([] { return false; }, longest_s);
  }
  /// The aircraft's clock is set back.
  void set_back(double by_s) { time_s_ -= by_s; }
  [[nodiscard]] double height_m() const { return -position_m_.z(); }
  [[nodiscard]] double heading_rad() const { return heading_rad_; }
  void turn_to(double heading_rad) { heading_rad_ = heading_rad; }
  [[nodiscard]] Eigen::Vector2d camera_m() const {
    return position_m_.head<2>() + 0.8 * Eigen::Vector2d(std::cos(heading_rad_), std::sin(heading_rad_));
  }
  [[nodiscard]] Eigen::Vector2d place_m() const { return position_m_.head<2>(); }
  [[nodiscard]] double camera_height_m() const { return -position_m_.z() - 0.25; }
  /// Of the aircraft against where it would be with its hook over the target's circle.
  [[nodiscard]] double hook_over_goal_m() const { return -position_m_.z() - 0.35 - 0.8 - 0.42; }
  [[nodiscard]] Eigen::Vector2d beside_target_m() const {
    const SlotId target = carry_.record().target.value();
    return (position_m_ - circle_m(target.platform, target.slot)).head<2>();
  }

  Eigen::Vector3d push_m = Eigen::Vector3d::Zero();  ///< by the wind
  bool stands = false;                               ///< the deck bears the cargo
  bool in_view = true, numbers_certain = true, frozen = false, circles_known = true;
  bool hook_tells = true, laser_tells = true, autopilot_tells = true, guided = true;
  double battery_share = 1;
  int renumbered = 0;                                     ///< circles are told under numbers so much lower
  Eigen::Vector3d decks_off_m = Eigen::Vector3d::Zero();  ///< where they are told to be from where they are
  Eigen::Vector3d gps_off_m = Eigen::Vector3d::Zero();    ///< of the place that the aircraft tells
  double laser_off_m = 0;
  bool all_empty = false, none_free = false;
  std::optional<double> second_told_low_m;  ///< the second platform is never seen, and told to be that low
  std::optional<double> told_within_m;      ///< cargoes are told from right above only, and not from higher
  Eigen::Vector2d put_m = Eigen::Vector2d::Zero();  ///< of cargoes from their circles' middles
  double leans_rad = 0;                             ///< the camera, by what nobody knows
  std::vector<Eigen::Vector3d> lone_circles_m;      ///< seen, and of no platform that is known

 private:
  static CarrySettings settings() {
    CarrySettings s;
    s.start_at_once = true;
    return s;
  }

  [[nodiscard]] std::int64_t now() const { return static_cast<std::int64_t>(std::llround(time_s_ * 1e6)); }

  void look() {
    const std::int64_t utime = now();
    if (!frozen) noise_px_ = 0.01 * (steps_ % 1000);
    LevelFrame frame;
    frame.utime = utime;
    for (int platform = 0; platform < 2 && in_view; ++platform) {
      DeckNews news;
      news.platform = platform;
      news.utime = news.seen_utime = utime;
      const Eigen::Vector3d middle_m = Eigen::Vector3d(10.0 * platform, 0, 0) + decks_off_m;
      const Eigen::Vector3d still = Eigen::Vector3d::Zero(), up(0, 0, -1);
      news.identity_certain = numbers_certain;
      news.knots = {{0, middle_m, still, up, true}, {1, middle_m, still, up, true}};
      if (platform == 1 && second_told_low_m) {
        const Eigen::Vector3d told_m = middle_m + Eigen::Vector3d(0, 0, *second_told_low_m);
        news.knots = {{0, told_m, still, up, true}, {1, told_m, still, up, true}};
        news.seen_utime = -1;
        carry_.hear(news);
        continue;
      }
      for (int slot = 0; slot < 4 && circles_known; ++slot) {
        SlotReport report;
        report.center_ned_m = circle_m(platform, (slot + renumbered) % 4) + decks_off_m;
        const bool is_told = !told_within_m || (camera_m() - report.center_ned_m.head<2>()).norm() < 0.3;
        const bool is_near = -position_m_.z() < told_within_m.value_or(1e9);
        const bool stands_here = platform == 0 && (is_told && is_near) && !all_empty;
        const bool looks_full = platform == 1 && none_free;
        const bool occupied = stands_here || looks_full || (!closed_ && carry_.phase() == Phase::verify_drop);
        report.condition = occupied ? SlotCondition::occupied : SlotCondition::empty;
        report.confidence = 1;
        report.seen_utime = utime;
        news.slots.push_back(report);
        if (occupied) frame.marks.push_back(rim_over(report.center_ned_m));
      }
      carry_.hear(news);
    }
    for (const Eigen::Vector3d& circle_m : lone_circles_m)
      frame.marks.push_back(mark_at(circle_m, Label::circle));
    carry_.see(frame);
  }

  [[nodiscard]] LevelMark rim_over(const Eigen::Vector3d& circle_m) const {
    return mark_at(circle_m + Eigen::Vector3d(put_m.x(), put_m.y(), -0.3), Label::cargo);
  }
  [[nodiscard]] LevelMark mark_at(const Eigen::Vector3d& place_m, Label label) const {
    const double c = std::cos(heading_rad_), s = std::sin(heading_rad_);
    const Eigen::Vector3d out_m = place_m - position_m_ - Eigen::Vector3d(0.8 * c, 0.8 * s, 0.25);
    LevelMark mark;
    mark.label = label;
    mark.image_px = {noise_px_, 0};
    mark.from_camera_level_m = {-s * out_m.x() + c * out_m.y(), -c * out_m.x() - s * out_m.y(), out_m.z()};
    mark.from_camera_level_m.x() += leans_rad * out_m.z();
    return mark;
  }

  Carry carry_;
  bool closed_;
  double time_s_ = 1000, heading_rad_ = 0;
  double noise_px_ = 0;  ///< by which a live camera's frames differ
  int steps_ = 0;
  Eigen::Vector3d position_m_ = Eigen::Vector3d(4, 0, -5), velocity_mps_ = Eigen::Vector3d::Zero();
};

}  // namespace stevedore
