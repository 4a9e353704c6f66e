// One platform as the mission knows it: where its circles are, and where they will be.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/vehicle_history.hpp"

namespace stevedore {

enum class SlotCondition { unknown, empty, occupied, misplaced };

struct SlotReport {
  Eigen::Vector3d center_ned_m;
  Eigen::Matrix3d covariance_m2 = Eigen::Matrix3d::Zero();
  SlotCondition condition = SlotCondition::unknown;
  double confidence = 0;
  std::int64_t seen_utime = -1;
};

struct DeckKnot {
  double ahead_s = 0;
  Eigen::Vector3d center_ned_m;
  Eigen::Vector3d velocity_ned_mps;
  Eigen::Vector3d normal_ned;  ///< unit, up
  bool safe_to_lower = false;
};

/// PLATFORM_ESTIMATE: positions in the autopilot's NED of that moment.
struct DeckNews {
  int platform = 0;
  std::int64_t utime = 0;
  std::int64_t seen_utime = -1;  ///< newest frame that showed circles of it; -1: none has
  double heading_rad = 0;
  double turn_rate_radps = 0;
  bool identity_certain = false;
  std::vector<DeckKnot> knots;  ///< now, and what is predicted, in order of time
  std::vector<SlotReport> slots;
};

struct PointPath {
  Eigen::Vector3d position_m;  ///< odometry frame
  Eigen::Vector3d velocity_mps;
};

/// The same in the odometry frame (geometry/vehicle_history.hpp), where what is seen stays right for seconds
/// though the autopilot's own position wanders.
class DeckPath {
 public:
  DeckPath(const DeckNews& report, const VehicleMoment& vehicle);

  [[nodiscard]] const DeckNews& news() const { return news_; }
  /// The deck's middle; beyond the last prediction it keeps its velocity.
  [[nodiscard]] PointPath center(std::int64_t utime) const;
  /// A point that stands on the deck: above its place there (forward, right of the middle) by height_m along
  /// the normal.
  [[nodiscard]] PointPath point(const Eigen::Vector2d& place_m, double height_m, std::int64_t utime) const;
  [[nodiscard]] Eigen::Vector3d normal(std::int64_t utime) const;
  [[nodiscard]] double heading_rad(std::int64_t utime) const;
  /// Of a circle's centre on the deck.
  [[nodiscard]] Eigen::Vector2d place_of(std::size_t slot) const { return places_m_.at(slot); }
  /// Where on the deck a thing stands whose top lies above it by height_m and was seen at a point: only the
  /// point's direction from the eye counts, since its range is as uncertain as the thing's size. Nothing
  /// where even so the range tells that it is not on the deck.
  [[nodiscard]] std::optional<Eigen::Vector2d> place_below(const Eigen::Vector3d& eye_odometry_m,
                                                           const Eigen::Vector3d& top_odometry_m,
                                                           double height_m, std::int64_t utime) const;
  [[nodiscard]] double age_s(std::int64_t utime) const;
  [[nodiscard]] bool safe_to_lower() const { return news_.knots.size() > 1 && news_.knots[1].safe_to_lower; }

 private:
  [[nodiscard]] Eigen::Vector3d on_deck(const Eigen::Vector2d& place_m, double height_m,
                                        std::int64_t utime) const;

  DeckNews news_;
  Eigen::Vector3d ned_from_odometry_m_;
  std::vector<Eigen::Vector2d> places_m_;
};

/// Turns a horizontal vector of the deck (forward, right) along north and east, and back.
Eigen::Vector2d ned_from_deck(const Eigen::Vector2d& deck, double heading_rad);
Eigen::Vector2d deck_from_ned(const Eigen::Vector2d& ned, double heading_rad);

}  // namespace stevedore
