// How good a flight's vision was: all comparisons of a log, what follows from them, and their figures as JSON
// and as text.
#pragma once

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/evaluate_altitude.hpp"
#include "tools/evaluate_drops.hpp"
#include "tools/evaluate_log.hpp"
#include "tools/evaluate_platforms.hpp"
#include "tools/evaluate_poses.hpp"
#include "tools/flown_configuration.hpp"

namespace stevedore {

/// What is known of the aircraft that flew.
struct Aircraft {
  LaserMount laser;
  /// Errors that all poses of a flight share and their covariances do not hold yet.
  std::optional<CommonError> common;
};

/// Nothing told: all at its default. Throws ConfigError.
Aircraft aircraft_of(const FlownConfiguration& flown);

/// A requirement, and whether the flight met it.
struct Verdict {
  enum class Says { good, poor, nothing };
  Says says = Says::nothing;
  std::string subject;
  std::string text;   ///< the figure
  std::string limit;  ///< and what it is held against
};

struct Evaluation {
  std::string log;
  std::string reference_log;  ///< empty: none
  std::vector<DamagedPart> reference_damage;
  FlightLog flight;
  std::optional<PoseComparison> poses;      ///< against TRUTH
  std::optional<PoseComparison> reference;  ///< against the poses of the other log
  std::optional<PlatformComparison> platforms;
  std::vector<Drop> drops;  ///< by TRUTH
  AltitudeComparison altitudes;
  Spread to_poses_ms, to_mission_ms;

  [[nodiscard]] bool has_truth() const { return poses.has_value(); }
};

/// reference: path of a log of the same frames whose POSES are a second source; empty: none.
/// Throws std::runtime_error, ConfigError.
Evaluation evaluate(const std::string& log, const FlownConfiguration& flown, const std::string& reference);

std::vector<Verdict> verdicts_of(const Evaluation& evaluation);
nlohmann::ordered_json to_json(const Evaluation& evaluation);
/// For a terminal.
std::string to_text(const Evaluation& evaluation);

}  // namespace stevedore
