// One platform: its deck's filter, its slots, and how it is found.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "geometry/vehicle_history.hpp"
#include "platform/deck_filter.hpp"
#include "platform/layout_match.hpp"
#include "platform/platform_estimate.hpp"
#include "platform/platform_sighting.hpp"
#include "platform/slot_assignment.hpp"
#include "platform/slot_identity.hpp"

namespace stevedore {

/// A frame turned along NED's axes, with what is left of its circles.
struct FrameInNed {
  std::int64_t utime = 0;
  VehicleMoment vehicle;
  std::vector<CircleCandidates> circles;  ///< index as in the sighting
  std::vector<bool> taken;                ///< given to a slot
  struct Cargo {
    Eigen::Vector3d from_aircraft_ned_m;
    Eigen::Matrix3d covariance_m2;
    double radius_m;
  };
  std::vector<Cargo> cargoes;
};

class PlatformTrack {
 public:
  /// Not known yet but by a number.
  PlatformTrack(int number, const PlatformSettings& settings, std::int64_t utime);

  // ---- what is told ----
  void hear(const PlatformReport& report, const VehicleMoment& vehicle);

  // ---- what is seen ----
  /// Takes the circles that are its own, where it is known well enough for that, and learns from them.
  void see(FrameInNed& frame, const FrameSighting& sighting);
  /// How well the match agrees with what is known, log likelihood a square metre; nothing beyond the gate.
  [[nodiscard]] std::optional<double> log_likelihood(const LayoutMatch& match, std::int64_t utime) const;
  /// Seen there; the third time in a row the deck counts as found. True when it does.
  bool found(const LayoutMatch& match, std::int64_t utime);

  /// Every slot's place is known to a sixth of the spacing: three sigma are half of it.
  [[nodiscard]] bool located(std::int64_t utime) const;
  /// Of a deck seen before; nothing: still to be learnt.
  [[nodiscard]] const std::optional<SlotLayout>& layout() const { return layout_; }
  [[nodiscard]] Eigen::Vector2d position_odometry_m(std::int64_t utime) const;

  /// Something was told or seen of it.
  [[nodiscard]] bool known() const { return measured_utime_ > 0; }
  /// It has said something of itself.
  [[nodiscard]] bool has_spoken() const { return reports_heard_ > 0; }
  /// Circles were given to it in the frame of that time.
  [[nodiscard]] bool seen_at(std::int64_t utime) const { return seen_utime_ == utime; }

  [[nodiscard]] int number() const { return number_; }
  void renumber(int number) { number_ = number; }
  /// Whether reports or continuity say that the number is right.
  void set_number_certain(bool certain) { number_certain_ = certain; }

  [[nodiscard]] PlatformEstimate estimate(std::int64_t utime, const VehicleMoment& vehicle) const;
  [[nodiscard]] const DeckFilter& filter() const { return filter_; }

 private:
  struct Candidate {
    Eigen::Vector3d center_m;
    std::int64_t utime = 0;
    int times = 0;
  };

  void restart_at(const LayoutMatch& match, std::int64_t utime);
  void forget_impossible_velocity(DeckState& state) const;
  /// Adds the matched circles; when they don't fit together, once more without the worst. True if used.
  bool measure(const FrameInNed& frame, std::vector<SlotMatch>& matches);
  [[nodiscard]] double attitude_overlap(std::int64_t utime) const;
  void judge_slots(const FrameInNed& frame, const FrameSighting& sighting,
                   const std::vector<SlotMatch>& matches);
  std::optional<std::size_t> judge_cargo(const FrameInNed& frame, const FrameInNed::Cargo& cargo,
                                         double circle_radius_m);

  PlatformSettings settings_;
  DeckMotion motion_;
  DeckFilter filter_;
  std::optional<SlotLayout> layout_;
  SlotIdentity identity_;
  std::vector<SlotBelief> beliefs_;  ///< by slot as the filter counts
  Candidate candidate_;
  int number_;
  bool number_certain_ = false;
  int reports_heard_ = 0;
  int reports_refused_ = 0;  ///< in a row
  std::int64_t measured_utime_ = 0;
  std::int64_t seen_utime_ = -1;
};

}  // namespace stevedore
