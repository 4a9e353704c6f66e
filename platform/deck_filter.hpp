// Kalman filter of one deck. Measurements may come late: they are put where they belong in time, and what
// came after them is worked in again.
#pragma once

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
/// frames a second a good frame is lost every five minutes. Wilson and Hilferty (1931); within 2 % from n = 2.
double gate_of(Eigen::Index n);

class DeckFilter {
 public:
  DeckFilter(const DeckMotion& motion, std::int64_t utime, const DeckState& start);

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

 private:
  using Measurement = std::variant<std::monostate, DeckSight, DeckReport>;
  struct Event {
    std::int64_t utime;
    Measurement measurement;
    DeckState after;
  };

  Verdict insert(std::int64_t utime, Measurement measurement);
  /// The state after the event, from the one before it. True if the measurement passed its gate.
  bool run(const Event& before, Event& event);

  DeckMotion motion_;
  std::deque<Event> history_;  ///< by time; the first is the start
  double odometry_rate_m2ps_ = 2e-4;
  Nis last_nis_;
};

}  // namespace stevedore
