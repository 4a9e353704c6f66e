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
#include "tracker_proc/common_motion.hpp"
#include "tracker_proc/mark_motion.hpp"
#include "tracker_proc/picture_motion.hpp"
#include "tracker_proc/surroundings.hpp"

namespace stevedore {

struct TrackerSettings {
  double histogram_weight = 0.95;  // the paper's w
  double memory_s = 2.0;           // a hand, the hook's rope, a short exit from the image
  double mark_unrest_radiips =
      1.0;  // besides what all do: 0.5 m/s for a circle of 0.5 m, a vehicle that turns
  double camera_unrest_radps = 1.0;  // a gust; 337 px/s for the paper's lens
  double size_unrest_ps = 0.5;       // 1 m/s of climb 2 m above a circle
};

template <class Visitor>
void describe(TrackerSettings& s, Visitor& visit) {
  visit("histogram_weight", s.histogram_weight, 0.0, 1.0, "share",
        "raise: the target's look is learned more slowly; 1: never after the first frame");
  visit("memory_s", s.memory_s, 0.0, 10.0, "s",
        "raise: an unseen ellipse keeps its id for longer, on a worse guess");
  visit(
      "mark_unrest_radiips", s.mark_unrest_radiips, 0.1, 20.0, "radii/s",
      "how much a mark's own velocity may have changed after a second; raise: marks that manoeuvre are kept, "
      "returns are expected in a wider place");
  visit("camera_unrest_radps", s.camera_unrest_radps, 0.01, 10.0, "rad/s",
        "the same of the camera, which moves all marks together; raise: a shakier mount is followed");
  visit("size_unrest_ps", s.size_unrest_ps, 0.05, 5.0, "1/s",
        "the same of the rate at which marks grow or shrink; raise: faster climbs keep their tracks");
}

enum class TrackStatus { searching, tracking, predicted, lost };

/// One ellipse followed over the frames.
struct Track {
  std::int64_t id = 0;
  int detection_index = -1;  ///< in this frame's detections; -1: none found
  Detection detection;       ///< as measured; while unseen as expected, with the covariance of that
  Eigen::Vector2d velocity_pxps = Eigen::Vector2d::Zero();
  double unseen_s = 0;  ///< since it was last measured
  int age_frames = 0;   ///< frames since it was taken up
  TrackStatus status = TrackStatus::tracking;
};

/// What is known of a frame besides its picture and its ellipses.
struct FrameView {
  cv::Size size;        ///< px; empty: that of the image, or else of the frame before
  double focal_px = 0;  ///< 0: not known
  /// Homography from the image of the step before to this one, as far as the camera has turned: exact at any
  /// depth. Nothing: not told.
  std::optional<Eigen::Matrix3d> turn;
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
  /// Ids count up from one, and none is given twice by the same tracker.
  explicit Tracker(const TrackerSettings& settings);

  /// What to follow from the next step on. The same wish again changes nothing, whether or not it has been
  /// fulfilled meanwhile; after release() it counts as a new one.
  /// By id: with last_seen_px the ellipse within two semi-axes of it is taken if there is no such id.
  void follow_id(std::int64_t id, std::optional<Eigen::Vector2d> last_seen_px = std::nullopt);
  /// By pixel: the first ellipse to appear within two semi-axes of it.
  void follow_pixel(const Eigen::Vector2d& pixel);
  /// The first detection labelled a circle.
  void follow_first_circle();
  void release();

  /// One frame. The image, grey or BGR with 8 bits, may be empty: then the target is followed by motion
  /// alone. Where time_s goes back (the camera started anew) velocities are forgotten and ids are kept.
  TrackerResult step(double time_s, const cv::Mat& image, const std::vector<Detection>& detections,
                     const FrameView& view = {});

 private:
  enum class Wish { nothing, id, pixel, first_circle };
  struct Followed {
    Track track;
    MarkMotion motion;
    int times_seen = 1;
    int unseen_frames = 0;
    bool hidden = false;                                  ///< not found though it should be in view
    double since_s = 0;                                   ///< taken up then
    double seen_s = 0;                                    ///< last measured then
    Eigen::Vector2d turn_pxps = Eigen::Vector2d::Zero();  ///< the told part of its velocity
    bool given_up = false;                                ///< it was another track all along
  };
  struct Frame;
  struct TargetSearch;

  void follow(Wish wish, std::int64_t id, std::optional<Eigen::Vector2d> pixel);
  double advance_clock(double time_s);
  void look_at(const FrameView& view, const cv::Mat& image);
  void predict(double dt_s, const FrameView& view);
  std::vector<Track> forget_unseen();
  [[nodiscard]] double memory_s(const Followed& followed) const;
  [[nodiscard]] Expected expected_of(const Followed& followed) const;
  [[nodiscard]] std::vector<Expected> all_expected() const;
  void shift_together(Frame& frame, const FrameView& view);
  [[nodiscard]] std::optional<TargetSearch> search_target(const Frame& frame) const;
  [[nodiscard]] std::vector<std::optional<std::size_t>> match(
      const Frame& frame, const std::optional<TargetSearch>& search) const;
  std::optional<std::size_t> moved_target(const Frame& frame, std::vector<std::optional<std::size_t>>& match);
  void continue_tracks(const Frame& frame, const std::vector<std::optional<std::size_t>>& match);
  void continue_track(Followed& followed, const Frame& frame, std::size_t found);
  void join_edges_of_cargoes();
  void take_up(const Frame& frame, std::size_t found, const Eigen::Vector2d& velocity_pxps);
  void set_measured(Track& track, const Frame& frame, std::size_t found) const;
  [[nodiscard]] Eigen::Vector2d mean_velocity_pxps() const;
  void note_hidden();
  void use_window(const TargetSearch& search);
  void describe_tracks();
  void take_up_target();
  [[nodiscard]] std::optional<std::size_t> target_place() const;
  [[nodiscard]] const Track* find(std::optional<std::int64_t> id) const;
  [[nodiscard]] const Track* nearest_to(const Eigen::Vector2d& pixel) const;
  [[nodiscard]] const Track* first_circle() const;
  [[nodiscard]] std::string searching_reason() const;
  [[nodiscard]] Target target_state(const std::optional<TargetSearch>& search) const;

  TrackerSettings settings_;
  std::int64_t next_id_ = 1;
  std::optional<double> time_s_;
  cv::Size frame_size_;
  double focal_px_;
  std::vector<Followed> followed_;  ///< in the order of their ids
  CommonMotion common_;
  double sure_s_ = 0;  ///< then it was known last which mark is which
  PictureMotion picture_;
  std::optional<Eigen::Vector2d> picture_pxps_;  ///< the picture's share of the velocities of the marks

  Wish wish_ = Wish::nothing;
  std::int64_t wished_id_ = 0;
  std::optional<Eigen::Vector2d> wished_pixel_;
  std::optional<std::int64_t> target_id_;  ///< empty: not taken up yet
  Appearance appearance_;
  Surroundings surroundings_;
  bool window_is_upon_target_ = false;  ///< when it had an ellipse last
};

}  // namespace stevedore
