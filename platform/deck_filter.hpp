// Kalman filter of one deck, for a course that is either kept or changed: interacting multiple models (Blom
// and Bar-Shalom 1988). Measurements may come late: they are put where they belong in time, and what came
// after them is worked in again.
#pragma once

#include <array>
#include <cstdint>
#include <deque>
#include <variant>

#include "platform/deck_motion.hpp"
#include "platform/deck_sight.hpp"

namespace stevedore {

enum class Verdict { used, gated, duplicate, too_late };

/// Chi-square test of an innovation against what the filter expects.
struct Nis {
  double value = 0;  ///< normalised innovation squared
  Eigen::Index numbers = 0;
  bool passed = false;
};

/// The value that a chi-square variable of n degrees of freedom exceeds once in ten thousand times: at 30
/// frames a second a good frame is lost every five minutes. Wilson and Hilferty (1931); within 2 % from n
/// = 2.
double gate_of(Eigen::Index n);

/// One state for each model, and how likely each is: first the course is kept, second it is changed.
struct DeckModels {
  std::array<DeckState, 2> states;
  std::array<double, 2> probability{0.5, 0.5};

  /// Mean and covariance of the mixture.
  [[nodiscard]] DeckState together() const;
};

class DeckFilter {
 public:
  DeckFilter(const DeckMotion& motion, double acceleration_sigma_mps2, std::int64_t utime,
             const DeckState& start);

  Verdict add(const DeckSight& sight);
  Verdict add(const DeckReport& report);

  /// At any time from the oldest measurement kept (a second before the newest): what was known then, or will
  /// be if nothing comes. NEES tests hold for this covariance.
  [[nodiscard]] DeckState at_time(std::int64_t utime) const;
  [[nodiscard]] std::int64_t newest_utime() const { return history_.back().utime; }
  [[nodiscard]] const Nis& last_nis() const { return last_nis_; }

  /// From now on the state is this one: a deck found anew. What came before is forgotten.
  void restart(std::int64_t utime, const DeckState& state);
  void set_odometry_rate(double rate_m2ps) { odometry_rate_m2ps_ = rate_m2ps; }
  /// That a prediction from then should reckon with: between the models, as likely as they are.
  [[nodiscard]] Disturbance disturbance(std::int64_t utime) const;

 private:
  using Measurement = std::variant<std::monostate, DeckSight, DeckReport>;
  struct Event {
    std::int64_t utime;
    Measurement measurement;
    DeckModels after;
    DeckState together;
  };

  Verdict insert(std::int64_t utime, Measurement measurement);
  /// The state after the event, from the one before it. True if the measurement passed its gate.
  bool run(const Event& before, Event& event);

  [[nodiscard]] Disturbance of_model(std::size_t model) const;
  [[nodiscard]] const Event& event_before(std::int64_t utime) const;

  DeckMotion motion_;
  double acceleration_sigma_mps2_;
  std::deque<Event> history_;  ///< by time; the first is the start
  double odometry_rate_m2ps_ = 2e-4;
  Nis last_nis_;
};

}  // namespace stevedore
