// Motion and circles of all platforms, from what the camera sees, the aircraft's state, and what platforms
// say of themselves. In the time of its inputs.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "geometry/vehicle_history.hpp"
#include "platform/platform_estimate.hpp"
#include "platform/platform_sighting.hpp"
#include "platform/platform_track.hpp"

namespace stevedore {

class PlatformEstimator {
 public:
  /// Throws std::invalid_argument for a layout of more than eight slots, or with two in one place.
  explicit PlatformEstimator(const PlatformSettings& settings);

  void add_vehicle(const VehicleSample& sample);
  void add_report(const PlatformReport& report);
  /// The platforms known at the frame's time, by number. Nothing when the aircraft's state is not known then.
  std::vector<PlatformEstimate> add_frame(const FrameSighting& sighting);

  /// For tests: the track of that number, if there is one.
  [[nodiscard]] const PlatformTrack* track(int number) const;

 private:
  [[nodiscard]] FrameInNed turned_to_ned(const FrameSighting& sighting, const VehicleMoment& vehicle) const;
  void find_among_free_circles(FrameInNed& frame, const FrameSighting& sighting);
  [[nodiscard]] std::vector<LayoutMatch> matches_for(const std::optional<SlotLayout>& known,
                                                     const std::vector<Eigen::Vector3d>& circles_m) const;
  void settle_numbers(const PlatformReport& report, const VehicleMoment& vehicle);
  bool make_room(std::int64_t utime);
  PlatformTrack* track_near(const Eigen::Vector2d& position_odometry_m, std::int64_t utime);

  PlatformSettings settings_;
  std::vector<SlotLayout> layouts_;
  VehicleHistory vehicle_;
  std::vector<PlatformTrack> tracks_;
  struct Votes {
    int given = -1, in_a_row = 0;
  };
  std::map<int, Votes> votes_;  ///< by reported number: for the deck that has the number given
};

}  // namespace stevedore
