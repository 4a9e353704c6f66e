// How well the mission knew the camera's height over the target circle's plane where it matters: below 2 m.
//
// Counted is every frame with TRUTH from the beginning of a descent to the end of the climb after it (phases
// descend to verify load, descend to verify drop, and retry) in which the camera truly is less than 2 m over
// the plane of the target's circle, measured along the vertical. What was told is the MISSION of that frame:
// its target_level_m is a point of the plane, and the plane leans as the deck's prediction has it in the
// newest PLATFORM_ESTIMATE that was out when MISSION was. Measured: that very frame showed a circle of the
// platform. Predicted: it did not. None: no MISSION for the frame, or none with a place of the target.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include "lcmtypes/channels.hpp"

namespace stevedore {

struct LowAltitude {
  std::int64_t measured = 0, predicted = 0, none = 0;  ///< frames
  std::vector<double> errors_m;  ///< told less true, without sign, ascending: of measured and predicted

  [[nodiscard]] std::int64_t frames() const { return measured + predicted + none; }
  /// Of the frames; nothing where there is none.
  [[nodiscard]] std::optional<double> share(std::int64_t count) const;
  /// At that share of the errors, nearest rank; nothing for no values.
  [[nodiscard]] std::optional<double> error_m(double share) const;
};

/// Fed with messages in any order.
class LowAltitudeBook {
 public:
  void add(const mission_t& mission);
  void add(const platform_estimate_t& estimate);
  void add(const vehicle_state_t& vehicle);
  void add(const truth_t& truth);
  [[nodiscard]] LowAltitude sum_up() const;

 private:
  struct Told {
    bool for_frame = false;
    std::int64_t publish_utime = 0;
    std::int8_t phase = 0;
    std::int16_t platform = -1, slot = -1;
    bool has_level = false;
    double level_m[3] = {};
  };

  [[nodiscard]] std::optional<double> told_height_m(std::int64_t utime, const Told& told) const;

  std::multimap<std::int64_t, Told> told_;                                              ///< by utime
  std::map<std::int16_t, std::multimap<std::int64_t, platform_estimate_t>> estimates_;  ///< by publish_utime
  std::set<std::pair<std::int16_t, std::int64_t>> seen_;  ///< platform in which frame
  std::map<std::int64_t, double> heading_rad_;            ///< by utime
  std::map<std::int64_t, truth_t> truth_;                 ///< by utime
};

}  // namespace stevedore
