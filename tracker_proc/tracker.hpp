// Follows every ellipse from frame to frame, and one of them, the target, with the paper's Algorithm 2.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "geometry/detection.hpp"
#include "tracker_proc/appearance.hpp"
#include "tracker_proc/association.hpp"

namespace stevedore {

struct TrackerSettings {
  double histogram_weight = 0.95;  // the paper's w
  double memory_s = 1.0;           // a hand or the hook's rope passes in less
  double gate_radii = 1.0;         // half of the way to a touching neighbour of the same size
  double size_ratio_gate =
      1.2;  // 2 m above a circle at 10 Hz and 1 m/s: 1.05; the two edges of a ring: 1.25 and more
  double velocity_time_s = 0.15;  // some frames: 0.3 px of noise at 30 Hz become 6 px/s
};

template <class Visitor>
void describe(TrackerSettings& s, Visitor& visit) {
  visit("histogram_weight", s.histogram_weight, 0.0, 1.0, "share",
        "raise: the target's look is learned more slowly; 1: never after the first frame");
  visit("memory_s", s.memory_s, 0.0, 10.0, "s",
        "raise: an unseen ellipse keeps its id for longer, on a worse guess");
  visit("gate_radii", s.gate_radii, 0.1, 2.0, "radii",
        "raise: jumps of the camera lose fewer tracks, above 1 a close neighbour may be taken");
  visit("size_ratio_gate", s.size_ratio_gate, 1.01, 3.0, "ratio",
        "raise: faster climbs and worse fits keep their track, a cargo may be taken for its circle");
  visit("velocity_time_s", s.velocity_time_s, 0.0, 2.0, "s",
        "raise: smoother velocity, slower to follow a change of it");
}

enum class TrackStatus { searching, tracking, predicted, lost };

/// One ellipse followed over the frames.
struct Track {
  std::int64_t id = 0;
  int detection_index = -1;  ///< in this frame's detections; -1: none found
  Detection detection;       ///< as measured; while unseen the last one, moved on with its velocity
  Eigen::Vector2d velocity_pxps = Eigen::Vector2d::Zero();
  double unseen_s = 0;  ///< since it was last measured
  int age_frames = 0;   ///< frames since it was taken up
  TrackStatus status = TrackStatus::tracking;
};

struct Target {
  std::optional<std::int64_t> id;
  TrackStatus status = TrackStatus::searching;
  std::string reason;             ///< one short sentence for a person: why it has this status
  std::optional<Ellipse> window;  ///< what CAMShift returned in this frame, also when it was not used
};

struct TrackerResult {
  std::vector<Track> tracks;  ///< in the order of their ids; one that is lost appears once more, as lost
  Target target;
};

class Tracker {
 public:
  /// Ids count up from first_id and are never used again. A tracker that is started anew and must not repeat
  /// the ids of the one before it begins above them.
  explicit Tracker(const TrackerSettings& settings, std::int64_t first_id = 1);

  /// What to follow from the next step on. The same wish again changes nothing, whether or not it has been
  /// fulfilled meanwhile; after release() it counts as a new one.
  /// By id: with last_seen_px the ellipse within two semi-axes of it is taken if there is no such id.
  void follow_id(std::int64_t id, std::optional<Eigen::Vector2d> last_seen_px = std::nullopt);
  /// By pixel: the first ellipse to appear within two semi-axes of it.
  void follow_pixel(const Eigen::Vector2d& pixel);
  /// The first detection labelled a circle.
  void follow_first_circle();
  void release();

  /// One frame. The image, grey or BGR with 8 bits, may be empty: then the target is followed by its motion
  /// alone. Where time_s goes back (the camera started anew) velocities are forgotten and ids are kept.
  TrackerResult step(double time_s, const cv::Mat& image, const std::vector<Detection>& detections);

 private:
  enum class Wish { nothing, id, pixel, first_circle };
  struct Followed {
    Track track;
    bool has_velocity = false;
  };
  struct TargetSearch;

  void follow(Wish wish, std::int64_t id, std::optional<Eigen::Vector2d> pixel);
  double advance_clock(double time_s);
  void predict(double dt_s);
  std::vector<Track> forget_unseen();
  std::optional<TargetSearch> search_target(const cv::Mat& image,
                                            const std::vector<Detection>& detections) const;
  void measure(Followed& followed, const Detection& detection, int index, double dt_s) const;
  void continue_tracks(const std::optional<TargetSearch>& search, const std::vector<Detection>& detections,
                       double dt_s);
  void take_up_target();
  [[nodiscard]] const Track* find(std::optional<std::int64_t> id) const;
  [[nodiscard]] const Track* nearest_to(const Eigen::Vector2d& pixel) const;
  [[nodiscard]] const Track* first_circle() const;
  [[nodiscard]] std::string searching_reason() const;
  [[nodiscard]] Target target_state(const std::optional<TargetSearch>& search) const;
  [[nodiscard]] AssociationGates gates() const;

  TrackerSettings settings_;
  std::int64_t next_id_;
  std::optional<double> time_s_;
  std::vector<Followed> followed_;  ///< in the order of their ids

  Wish wish_ = Wish::nothing;
  std::int64_t wished_id_ = 0;
  std::optional<Eigen::Vector2d> wished_pixel_;
  std::optional<std::int64_t> target_id_;  ///< empty: not taken up yet
  Appearance appearance_;
};

}  // namespace stevedore
