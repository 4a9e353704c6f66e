// What is in view, which of it is wanted, and what is wrong. The full mission (phases, load and drop) is
// built on this.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "geometry/detection.hpp"
#include "mission_proc/carry_settings.hpp"
#include "mission_proc/emergency.hpp"
#include "mission_proc/phases.hpp"

namespace stevedore {

struct MissionSettings {
  std::string job = "watch";
  std::string journal;
  CarrySettings carry;
  double min_coverage = 0.6;
  int min_age_frames = 3;
  double give_up_s = 1.0;
  double out_of_view_s = 1.0;
  double stale_s = 0.5;
  double vehicle_silent_s = 0.5;
  // Attitude is known to 0.7 deg, so that 3 deg are nothing yet; 9 deg off level, a circle of 0.5 m straight
  // below is cut at a height of 1 m: it fills 26.6 deg of the paper's 35.5 deg to the edge of the image.
  double off_level_deg = 6;
  double off_level_s = 0.5;    // a gust's swing is over by then
  double level_again_s = 1.0;  // two swings without a fault
  double gimbal_silent_s = 0.5;
};

template <class Visitor>
void describe(MissionSettings& s, Visitor& visit) {
  visit.choice(
      "job", s.job, {"watch", "carry"},
      "watch: choose a circle and say where it is; carry: bring the cargoes of one platform to another");
  visit("journal", s.journal,
        "file for what carrying goes on from after a restart; a new flight needs a new one; empty: it begins "
        "anew");
  describe(s.carry, visit);
  visit(
      "min_coverage", s.min_coverage, 0.0, 1.0, "1",
      "edge that a circle must show to be chosen as a target; raise: hidden and cut circles are not chosen");
  visit("min_age_frames", s.min_age_frames, 1, 1000, "frames",
        "frames that a mark must have been followed to be chosen; raise: later, but no flicker is chosen");
  visit("give_up_s", s.give_up_s, 0.0, 60.0, "s",
        "time without a target before another is chosen; raise: more patient");
  visit("out_of_view_s", s.out_of_view_s, 0.0, 60.0, "s", "time without any mark before it is an emergency");
  visit("stale_s", s.stale_s, 0.05, 60.0, "s", "age of the newest POSES at which vision counts as stale");
  visit("vehicle_silent_s", s.vehicle_silent_s, 0.05, 60.0, "s",
        "silence of VEHICLE_STATE that is told by TIMEOUT");
  visit(
      "off_level_deg", s.off_level_deg, 0.1, 90.0, "deg",
      "angle between optical axis and gravity from which the camera is not level; raise: more is tolerated");
  visit("off_level_s", s.off_level_s, 0.0, 60.0, "s",
        "how long the camera must be off level before it is an emergency");
  visit("level_again_s", s.level_again_s, 0.0, 60.0, "s",
        "how long it must be level, and its gimbal well, before the emergency is over");
  visit("gimbal_silent_s", s.gimbal_silent_s, 0.05, 60.0, "s",
        "silence of GIMBAL_LEVEL, once it was heard, that is an emergency");
}

/// A mark as the mission sees it, one of a frame's POSES.
struct Mark {
  int64_t track_id = -1;
  Label label = Label::unknown;
  bool measured = false;  ///< in this frame; else predicted
  Eigen::Vector2d center_px = Eigen::Vector2d::Zero();
  double semi_major_px = 0;
  double coverage = 0;
  int age_frames = 0;
  std::optional<double> range_m;  ///< from the camera
};

enum class TargetStatus { searching, tracking, predicted, lost };

/// One frame's view.
struct View {
  double time_s = 0;
  std::vector<Mark> marks;
  std::optional<int64_t> target_id;  ///< that the tracker follows
  TargetStatus target_status = TargetStatus::searching;
};

enum class GimbalCondition { ok, at_limit, stuck, late };

/// How the camera is held.
struct CameraHold {
  double time_s = 0;
  std::optional<double> off_level_rad;  ///< optical axis against gravity; nothing: not known
  GimbalCondition gimbal = GimbalCondition::ok;
};

struct Candidate {
  Mark mark;
  bool eligible = false;
  bool chosen = false;
  double cost =
      0;  ///< the lowest wins; range in metres if known for all, else the inverse of the size in pixels
  std::string reason;
};

/// What the tracker is to follow. The same choice keeps its number.
struct Wanted {
  int64_t choice = 0;
  int64_t track_id = -1;
  Eigen::Vector2d last_seen_px = Eigen::Vector2d::Zero();
};

struct Decision {
  Phase phase = Phase::search;
  double phase_since_s = 0;
  std::optional<Wanted> wanted;
  std::vector<Candidate> candidates;
  std::vector<RaisedEmergency> emergencies;
  std::string reason;
};

class Mission {
 public:
  explicit Mission(const MissionSettings& settings) : settings_(settings) {}

  /// A new frame's marks.
  void see(const View& view);
  /// How level the camera is.
  void hear(const CameraHold& level);
  /// Time goes on, whether vision does or not: the newest message's time.
  void tick(double time_s);

  void hold();
  void resume();
  void abort();
  /// The operator wants this one.
  void choose(int64_t track_id);

  [[nodiscard]] const Decision& decision() const { return decision_; }

 private:
  void weigh_candidates(const View& view);
  void follow(const Mark& mark, const std::string& reason);
  void start_clock(double time_s);
  void set_phase(Phase phase);
  void set_emergency(Emergency kind, bool present, const std::string& cause);

  const MissionSettings settings_;
  Decision decision_;
  double time_s_ = 0;
  std::optional<double> vision_time_s_;    ///< of the newest view, or of the first message
  double mark_time_s_ = 0;                 ///< a circle or cargo was measured, or the first message
  double target_time_s_ = 0;               ///< the target was measured, or wanted
  std::optional<double> level_time_s_;     ///< of the newest CameraHold
  std::optional<double> unlevel_since_s_;  ///< the camera is off level, or its gimbal is not well
  std::optional<double> level_since_s_;    ///< neither
  int64_t last_choice_ = 0;
  std::optional<int64_t> operators_choice_;  ///< not yet in view
};

}  // namespace stevedore
