// Two platforms at sea and an aircraft over them, small and exact: what the platform estimator is tested
// against. Nothing in it is shared with the estimator's models: courses are analytic, waves are sums of
// sinusoids.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <random>
#include <vector>

#include "geometry/attitude.hpp"
#include "platform/platform_estimator.hpp"

namespace stevedore::test {

constexpr double world_pi = std::numbers::pi;
constexpr double world_deg = world_pi / 180;

using Random = std::mt19937_64;

inline double gauss(Random& random, double sigma) {
  return sigma > 0 ? std::normal_distribution<double>(0, sigma)(random) : 0;
}
inline double uniform(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}
inline Eigen::Vector3d gauss3(Random& random, double sigma) {
  return {gauss(random, sigma), gauss(random, sigma), gauss(random, sigma)};
}
inline Eigen::Matrix3d small_turn(const Eigen::Vector3d& rotation_rad) {
  return Eigen::AngleAxisd(rotation_rad.norm(), rotation_rad.stableNormalized()).toRotationMatrix();
}

/// A value that wanders: first-order Gauss-Markov.
class Wander {
 public:
  Wander(double sigma, double time_s, Random& random)
      : sigma_(sigma), time_s_(time_s), value_(gauss3(random, sigma)) {}
  const Eigen::Vector3d& next(double dt_s, Random& random) {
    const double keep = std::exp(-dt_s / time_s_);
    value_ = keep * value_ + gauss3(random, sigma_ * std::sqrt(1 - keep * keep));
    return value_;
  }

 private:
  double sigma_, time_s_;
  Eigen::Vector3d value_;
};

/// Three sinusoids of 5 to 7 s.
class Swell {
 public:
  Swell(double rms, Random& random) {
    for (Wave& wave : waves_)
      wave = {rms * std::sqrt(2.0 / 3), 2 * world_pi / uniform(random, 5, 7),
              uniform(random, 0, 2 * world_pi)};
  }
  [[nodiscard]] double value(double t_s) const {
    double sum = 0;
    for (const Wave& w : waves_) sum += w.amplitude * std::sin(w.rate * t_s + w.phase);
    return sum;
  }
  [[nodiscard]] double rate(double t_s) const {
    double sum = 0;
    for (const Wave& w : waves_) sum += w.amplitude * w.rate * std::cos(w.rate * t_s + w.phase);
    return sum;
  }

 private:
  struct Wave {
    double amplitude, rate, phase;
  };
  std::array<Wave, 3> waves_;
};

enum class Manner { straight, turning, stop_and_go };

struct DeckTruth {
  Eigen::Vector3d center_m;
  Eigen::Vector3d velocity_mps;
  Eigen::Matrix3d ned_from_deck;
  double heading_rad;
};

class TruePlatform {
 public:
  TruePlatform(Manner manner, const Eigen::Vector2d& start_m, double heave_rms_m, double tilt_rms_rad,
               Random& random)
      : manner_(manner),
        start_m_(start_m),
        heading_rad_(uniform(random, -world_pi, world_pi)),
        speed_mps_(uniform(random, 0.6, 1.4)),
        radius_m_(uniform(random, 12, 18)),
        phase_s_(uniform(random, 0, 40)),
        heave_m_(heave_rms_m, random),
        roll_(tilt_rms_rad, random),
        pitch_(tilt_rms_rad, random) {
    // its circle, or the whole way that it runs to and fro, lies on its own side
    start_m_ += start_m.normalized() * radius_m_;
  }

  [[nodiscard]] DeckTruth at(double t_s) const {
    DeckTruth deck;
    Eigen::Vector2d position_m, velocity_mps;
    deck.heading_rad = heading_rad_;
    if (manner_ == Manner::turning) {
      const double angle_rad = heading_rad_ + speed_mps_ / radius_m_ * t_s;
      position_m = start_m_ + radius_m_ * Eigen::Vector2d(std::sin(angle_rad), -std::cos(angle_rad));
      velocity_mps = speed_mps_ * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
      deck.heading_rad = angle_rad;
    } else {
      const auto [distance_m, speed_mps] = along(t_s + phase_s_);
      const Eigen::Vector2d ahead(std::cos(heading_rad_), std::sin(heading_rad_));
      position_m = start_m_ + distance_m * ahead;
      velocity_mps = speed_mps * ahead;
    }
    deck.center_m << position_m, -0.8 + heave_m_.value(t_s);
    deck.velocity_mps << velocity_mps, heave_m_.rate(t_s);
    deck.ned_from_deck = (Eigen::AngleAxisd(deck.heading_rad, Eigen::Vector3d::UnitZ()) *
                          Eigen::AngleAxisd(pitch_.value(t_s), Eigen::Vector3d::UnitY()) *
                          Eigen::AngleAxisd(roll_.value(t_s), Eigen::Vector3d::UnitX()))
                             .toRotationMatrix();
    return deck;
  }

 private:
  /// To and fro: 10 s ahead, 8 s to turn round. Stop and go: 5 s to start, 8 s ahead, 5 s to stop, 8 s still,
  /// and back. Speeds change as half a cosine: 0.55 m/s2 at most.
  [[nodiscard]] std::pair<double, double> along(double t_s) const {
    struct Stretch {
      double duration_s, from, to;
    };
    static const std::vector<Stretch> to_and_fro{{10, 1, 1}, {8, 1, -1}, {10, -1, -1}, {8, -1, 1}};
    static const std::vector<Stretch> stages{{5, 0, 1},  {8, 1, 1},   {5, 1, 0},  {8, 0, 0},
                                             {5, 0, -1}, {8, -1, -1}, {5, -1, 0}, {8, 0, 0}};
    const auto& stretches = manner_ == Manner::straight ? to_and_fro : stages;
    double cycle_s = 0, distance = 0;
    for (const Stretch& s : stretches) cycle_s += s.duration_s;
    double left_s = std::fmod(t_s, cycle_s);
    for (const Stretch& s : stretches) {
      const double in_s = std::min(left_s, s.duration_s), part = world_pi * in_s / s.duration_s;
      const double half = (s.to - s.from) / 2;
      distance += s.from * in_s + half * (in_s - s.duration_s / world_pi * std::sin(part));
      if (left_s < s.duration_s)
        return {speed_mps_ * distance, speed_mps_ * (s.from + half * (1 - std::cos(part)))};
      left_s -= s.duration_s;
    }
    return {speed_mps_ * distance, 0};
  }

  Manner manner_;
  Eigen::Vector2d start_m_;
  double heading_rad_, speed_mps_, radius_m_, phase_s_;
  Swell heave_m_, roll_, pitch_;
};

struct WorldOptions {
  std::uint64_t seed = 1;
  Manner manner = Manner::straight;
  bool row = false;
  double heave_rms_m = 0.25;  ///< sea state 3
  double tilt_rms_rad = 3 * world_deg;
  double frame_rate_hz = 15;
  double missed = 0.1;           ///< share of circles not found
  double false_circles = 0.2;    ///< a frame, anywhere in view
  double wrong_first = 0.03;     ///< of poses: the wrong one of the two solutions is put first
  double wrong_occupied = 0.05;  ///< of what the detector says
  bool silent = false;           ///< no reports at all
  bool exact = false;            ///< sensors without lasting errors: for NEES of what remains
};

/// Where the aircraft's camera is wanted at a time: over the first platform (0) or the second (1) or between,
/// how far off, how high over the decks.
struct Station {
  double over = 0;
  Eigen::Vector2d aside_m = Eigen::Vector2d::Zero();
  double height_m = 5;
};

class PlatformWorld {
 public:
  static constexpr double camera_f_px = 337;

  explicit PlatformWorld(const WorldOptions& options)
      : options_(options),
        random_(options.seed * 7919 + 17),
        position_bias_m_(options.exact ? 0 : 1.5, 60, random_),
        attitude_bias_rad_(options.exact ? 0 : 0.5 * world_deg, 60, random_),
        report_bias_m_{{Wander(2, 60, random_), Wander(2, 60, random_)}} {
    const double bearing = uniform(random_, 0, 2 * world_pi), apart_m = uniform(random_, 18, 26);
    for (int p = 0; p < 2; ++p) {
      const Eigen::Vector2d start_m =
          (p == 0 ? -0.5 : 0.5) * apart_m * Eigen::Vector2d(std::cos(bearing), std::sin(bearing));
      // each keeps to its own place to some metres, so that they stay apart
      platforms_.emplace_back(p == 0 ? options.manner : Manner::stop_and_go, start_m, options.heave_rms_m,
                              options.tilt_rms_rad, random_);
      const double error = options.exact ? 0 : 1;
      heading_bias_rad_[static_cast<std::size_t>(p)] = gauss(random_, 3 * world_deg);
      if (p == 1) continue;
      scale_ = 1 + error * gauss(random_, 0.005);
      mount_error_ = small_turn(gauss3(random_, error * 0.35 * world_deg));
      arm_error_m_ = gauss3(random_, error * 0.02);
      stamp_late_s_ = error * uniform(random_, -0.005, 0.005);
    }
    for (double& phase : sway_phase_) phase = uniform(random_, 0, 2 * world_pi);
    for (auto& deck : occupied) deck = {true, false, true, false};
  }

  [[nodiscard]] DeckTruth deck(int platform, double t_s) const {
    return platforms_[static_cast<std::size_t>(platform)].at(t_s);
  }
  [[nodiscard]] std::vector<Eigen::Vector2d> slots_m() const {
    if (options_.row) return {{2.4, 0}, {0.8, 0}, {-0.8, 0}, {-2.4, 0}};
    return {{0.8, -0.8}, {0.8, 0.8}, {-0.8, 0.8}, {-0.8, -0.8}};
  }
  [[nodiscard]] Eigen::Vector3d slot_ned_m(int platform, std::size_t slot, double t_s) const {
    const DeckTruth truth = deck(platform, t_s);
    return truth.center_m + truth.ned_from_deck.leftCols<2>() * slots_m()[slot];
  }

  struct Aircraft {
    Eigen::Vector3d position_m;
    Eigen::Matrix3d ned_from_body;
  };
  /// Flown so that the camera is on station, but for a sway of some decimetres and degrees.
  [[nodiscard]] Aircraft aircraft(double t_s, const Station& station) const {
    const Eigen::Vector3d over_m =
        (1 - station.over) * deck(0, t_s).center_m + station.over * deck(1, t_s).center_m;
    const auto sway = [&](std::size_t i, double period_s) {
      return std::sin(2 * world_pi * t_s / period_s + sway_phase_[i]);
    };
    Aircraft out;
    out.ned_from_body =
        (Eigen::AngleAxisd(0.3 * sway(0, 25), Eigen::Vector3d::UnitZ()) *
         Eigen::AngleAxisd(4 * world_deg * sway(1, 3.1) - 3 * world_deg, Eigen::Vector3d::UnitY()) *
         Eigen::AngleAxisd(4 * world_deg * sway(2, 2.7), Eigen::Vector3d::UnitX()))
            .toRotationMatrix();
    const Eigen::Vector3d wanted_m(over_m.x() + station.aside_m.x() + 0.25 * sway(3, 4.3),
                                   over_m.y() + station.aside_m.y() + 0.25 * sway(4, 5.9),
                                   -0.8 - station.height_m + 0.1 * sway(5, 3.7));
    out.position_m = wanted_m - out.ned_from_body * (arm_m() + arm_error_m_);
    return out;
  }

  /// Runs until the next frame and hands everything to the estimator. The frame comes 60 ms late, when the
  /// aircraft's state has gone on. Returns what the estimator answers to the frame.
  template <class StationAt>
  std::vector<PlatformEstimate> next_frame(PlatformEstimator& estimator, StationAt station_at) {
    const double frame_s = static_cast<double>(++frames_) / options_.frame_rate_hz;
    while (vehicle_s_ < frame_s + 0.06) {
      vehicle_s_ += 0.02;
      estimator.add_vehicle(vehicle_sample(vehicle_s_, station_at));
    }
    while (report_s_ + 0.5 < frame_s) {
      report_s_ += 0.5;
      for (int p = 0; p < 2 && !options_.silent; ++p)
        if (!mute_reports) estimator.add_report(report(p, report_s_));
    }
    time_s_ = frame_s;
    bias_at_frame_m_ =
        bias_of_[static_cast<std::size_t>(std::llround((frame_s + 1) / 0.02)) % bias_of_.size()];
    last_sighting = look(frame_s, station_at(frame_s));
    return estimator.add_frame(last_sighting);
  }
  [[nodiscard]] double time_s() const { return time_s_; }
  static std::int64_t utime_of(double t_s) {
    return 1'000'000 + static_cast<std::int64_t>(std::llround(t_s * 1e6));
  }
  /// By how much the aircraft's position was wrong when the frame was taken: what its NED is shifted by.
  [[nodiscard]] Eigen::Vector3d position_bias_m() const { return bias_at_frame_m_; }

  std::array<std::array<bool, 4>, 2> occupied;  ///< truth, may be changed on the way
  bool mute_reports = false;
  bool blind = false;  ///< frames without circles
  FrameSighting last_sighting;
  std::vector<int> last_slot_of_circle;  ///< truth of last_sighting: slot + 4 * platform; -1: false

 private:
  static Eigen::Vector3d arm_m() { return {0.8, 0, 0.25}; }

  template <class StationAt>
  VehicleSample vehicle_sample(double t_s, StationAt station_at) {
    const Aircraft now = aircraft(t_s, station_at(t_s));
    constexpr double h = 1e-3;
    const Eigen::Vector3d velocity_mps = (aircraft(t_s + h, station_at(t_s + h)).position_m -
                                          aircraft(t_s - h, station_at(t_s - h)).position_m) /
                                         (2 * h);
    VehicleSample sample;
    sample.utime = utime_of(t_s);
    const Eigen::Vector3d bias_m = position_bias_m_.next(0.02, random_);
    bias_of_[static_cast<std::size_t>(std::llround((t_s + 1) / 0.02)) % bias_of_.size()] = bias_m;
    sample.position_ned_m = now.position_m + bias_m;
    sample.velocity_ned_mps = velocity_mps + gauss3(random_, 0.1);
    sample.ned_from_body = Eigen::Quaterniond(
        small_turn(attitude_bias_rad_.next(0.02, random_) + gauss3(random_, 0.5 * world_deg)) *
        now.ned_from_body);
    const Eigen::AngleAxisd turn(aircraft(t_s - h, station_at(t_s - h)).ned_from_body.transpose() *
                                 aircraft(t_s + h, station_at(t_s + h)).ned_from_body);
    sample.angular_rate_body_radps = turn.axis() * turn.angle() / (2 * h) + gauss3(random_, 0.2 * world_deg);
    sample.velocity_variance_m2ps2 = 0.01;
    sample.attitude_variance_rad2 = 2 * std::pow(0.5 * world_deg, 2);
    return sample;
  }

  PlatformReport report(int p, double t_s) {
    const DeckTruth truth = deck(p, t_s);
    const auto i = static_cast<std::size_t>(p);
    return {utime_of(t_s), p, truth.center_m + report_bias_m_[i].next(0.5, random_) + gauss3(random_, 0.3),
            truth.velocity_mps + gauss3(random_, 0.1),
            truth.heading_rad + heading_bias_rad_[i] + gauss(random_, 1 * world_deg)};
  }

  FrameSighting look(double t_s, const Station& station) {
    const double exposed_s = t_s + stamp_late_s_;
    const Aircraft now = aircraft(exposed_s, station);
    FrameSighting sighting;
    sighting.utime = utime_of(t_s);
    // the pan-tilt holds the camera level to a third of a degree
    const Eigen::Vector3d ahead = now.ned_from_body.col(0);
    const double pitch = -std::asin(ahead.z()),
                 roll = std::atan2(now.ned_from_body(2, 1), now.ned_from_body(2, 2));
    const GimbalAngles gimbal{-roll + gauss(random_, 0.3 * world_deg),
                              -pitch + gauss(random_, 0.3 * world_deg)};
    sighting.body_from_camera = body_from_camera(gimbal, CameraMount{});
    const Eigen::Matrix3d ned_from_camera = now.ned_from_body * sighting.body_from_camera * mount_error_;
    const Eigen::Vector3d camera_m = now.position_m + now.ned_from_body * (arm_m() + arm_error_m_);
    last_slot_of_circle.clear();
    for (int p = 0; p < 2 && !blind; ++p)
      for (std::size_t s = 0; s < 4; ++s)
        if (auto circle = circle_seen(p, s, exposed_s, camera_m, ned_from_camera)) {
          sighting.circles.push_back(*circle);
          last_slot_of_circle.push_back(static_cast<int>(s) + 4 * p);
        }
    if (!blind && uniform(random_, 0, 1) < options_.false_circles) {
      sighting.circles.push_back(false_circle(station.height_m));
      last_slot_of_circle.push_back(-1);
    }
    return sighting;
  }

  static bool in_view(const Eigen::Vector3d& camera_m, double margin_px) {
    if (camera_m.z() < 0.3) return false;
    const double u = camera_f_px * camera_m.x() / camera_m.z(), v = camera_f_px * camera_m.y() / camera_m.z();
    return std::abs(u) < 320 - margin_px && std::abs(v) < 240 - margin_px;
  }

  /// Noise as of edges known to 0.05 px. The normal as conic_pose states it: see the formula at normal_sigma.
  std::optional<CircleSighting> circle_seen(int p, std::size_t slot, double t_s, const Eigen::Vector3d& eye_m,
                                            const Eigen::Matrix3d& ned_from_camera) {
    const Eigen::Vector3d center_m = ned_from_camera.transpose() * (slot_ned_m(p, slot, t_s) - eye_m);
    const double semi_axis_px = camera_f_px * 0.5 / center_m.z();
    // half of it may be cut by the border
    if (!in_view(center_m, 0) || uniform(random_, 0, 1) < options_.missed || semi_axis_px > 300)
      return std::nullopt;
    const bool whole = in_view(center_m, semi_axis_px);
    const double edge_px = whole ? 0.05 : 0.2;
    const double range_m = center_m.norm(), across_m = range_m / camera_f_px * edge_px;
    const double along_m = range_m * edge_px / semi_axis_px;
    const Eigen::Vector3d ray = center_m / range_m;
    SeenCircle seen;
    const Eigen::Matrix3d along = ray * ray.transpose();
    seen.covariance_m2 =
        along_m * along_m * along + across_m * across_m * (Eigen::Matrix3d::Identity() - along);
    seen.center_camera_m = scale_ * center_m + gauss(random_, along_m) * ray +
                           (Eigen::Matrix3d::Identity() - along) * gauss3(random_, across_m);
    const Eigen::Vector3d normal = -ned_from_camera.transpose() * deck(p, t_s).ned_from_deck.col(2);
    const double sigma_rad = normal_sigma(edge_px / semi_axis_px, std::acos(std::min(1.0, -normal.dot(ray))));
    seen.normal_variance_rad2 = sigma_rad * sigma_rad;
    seen.normal_camera = (normal + gauss3(random_, sigma_rad)).normalized();
    SeenCircle other = seen;
    other.normal_camera = (2 * normal.dot(ray) * ray - normal).normalized();
    if (other.normal_camera.dot(ray) > 0) other.normal_camera = -other.normal_camera;
    seen.probability = 1 - options_.wrong_first;
    other.probability = options_.wrong_first;
    CircleSighting sighting{{seen, other}, 0.5, occupied[static_cast<std::size_t>(p)][slot]};
    if (uniform(random_, 0, 1) < options_.wrong_first) {
      std::swap(sighting.solutions[0], sighting.solutions[1]);
      std::swap(sighting.solutions[0].probability, sighting.solutions[1].probability);
    }
    if (uniform(random_, 0, 1) < options_.wrong_occupied) sighting.occupied = !*sighting.occupied;
    return sighting;
  }

  /// cos(tilt) = b / a, so that sigma = sqrt(2) e / sin(tilt) for a relative error e of each semi-axis;
  /// facing the circle sqrt(2 sqrt(2) e).
  static double normal_sigma(double relative, double tilt_rad) {
    const double slope = std::numbers::sqrt2 * relative;
    return std::min(slope / std::max(1e-9, std::sin(tilt_rad)), std::sqrt(2 * slope));
  }

  CircleSighting false_circle(double height_m) {
    const double z_m = height_m * uniform(random_, 0.5, 1.5);
    SeenCircle seen;
    const double down = uniform(random_, -0.7, 0.7), right = uniform(random_, -0.9, 0.9);
    seen.center_camera_m = z_m * Eigen::Vector3d(right, down, 1);
    seen.covariance_m2 = Eigen::Matrix3d::Identity() * 1e-4;
    seen.normal_camera = (Eigen::Vector3d(0, 0, -1) + gauss3(random_, 0.1)).normalized();
    seen.normal_variance_rad2 = 1e-3;
    return {{seen}, 0.5, uniform(random_, 0, 1) < 0.5};
  }

  WorldOptions options_;
  Random random_;
  Wander position_bias_m_, attitude_bias_rad_;
  std::array<Wander, 2> report_bias_m_;
  std::vector<TruePlatform> platforms_;
  std::array<double, 2> heading_bias_rad_{};
  double scale_ = 1;
  Eigen::Matrix3d mount_error_;
  Eigen::Vector3d arm_error_m_;
  double stamp_late_s_ = 0;
  std::array<double, 6> sway_phase_{};
  std::array<Eigen::Vector3d, 16> bias_of_;  ///< of the last samples
  Eigen::Vector3d bias_at_frame_m_;
  std::int64_t frames_ = 0;
  double vehicle_s_ = -1, report_s_ = -0.77, time_s_ = 0;
};

}  // namespace stevedore::test
