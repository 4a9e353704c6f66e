// The carrying of cargoes: from what is seen and felt to the next step, and to where the aircraft should be.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "geometry/detection.hpp"
#include "geometry/vehicle_history.hpp"
#include "mission_proc/cargo_places.hpp"
#include "mission_proc/carry_settings.hpp"
#include "mission_proc/choice.hpp"
#include "mission_proc/deck_path.hpp"
#include "mission_proc/emergency.hpp"
#include "mission_proc/hanging.hpp"
#include "mission_proc/phases.hpp"

namespace stevedore {

// ---- what is told ----

/// A mark of a frame, from the camera along the level frame's axes (right, back, down).
struct LevelMark {
  std::int64_t track_id = -1;
  Label label = Label::unknown;
  Eigen::Vector3d from_camera_level_m;
  Eigen::Vector2d image_px = Eigen::Vector2d::Zero();
  double across_variance_m2 = 0;  ///< of its centre, in each direction across the line of sight, in the mean
};

struct LevelFrame {
  std::int64_t utime = 0;
  std::vector<LevelMark> marks;  ///< measured in it
};

struct HookReport {
  double load_n = 0;
  bool closed = false;
};

struct AutopilotReport {
  bool guided = false;
  bool lands = false;  ///< by itself
  bool landed = false;
  double battery_share = 1;
};

// ---- what is kept over a restart ----

struct DeliveredCargo {
  SlotId slot;
  double off_m = -1;  ///< of the cargo's axis from the circle's centre, as seen; -1: not seen
};

struct CarryRecord {
  Phase phase = Phase::idle;
  std::optional<SlotId> target;
  bool loaded = false;
  bool homeward = false;
  int attempts = 0;
  int written_off = 0;
  std::vector<DeliveredCargo> delivered;
  std::map<SlotId, int> failures;
  std::vector<SlotId> taken;  ///< circles that a cargo was taken away from
  Eigen::Vector3d home_ned_m = Eigen::Vector3d::Zero();
  /// Of the hook from where it is told to hang, ahead, right, down: the mean of so many lessons, and of one
  /// of nought.
  Eigen::Vector3d hook_off_m = Eigen::Vector3d::Zero();
  int hook_lessons = 0;
};

// ---- what comes out ----

enum class Action { none, hover, go_to, descend, grab, release, climb, land };

/// For the aircraft's own point, in the autopilot's NED as of the newest VEHICLE_STATE.
struct Setpoint {
  Eigen::Vector3d position_ned_m;
  Eigen::Vector3d velocity_ned_mps;  ///< led by the aircraft's lag
  double heading_rad = 0;
};

struct CarryTarget {
  SlotId slot;
  Eigen::Vector3d from_camera_level_m;  ///< circle's centre, at the frame's time
  Eigen::Matrix3d covariance_level_m2;
  Eigen::Matrix3d covariance_ned_m2;
  Eigen::Vector3d ned_m;
  Eigen::Vector3d velocity_ned_mps;
  double age_s = 0;  ///< since its platform was seen
};

class Carry {
 public:
  explicit Carry(const CarrySettings& settings, const std::optional<CarryRecord>& restored = std::nullopt);

  void hear(const VehicleSample& vehicle);
  void hear(const HookReport& hook);
  void hear(const AutopilotReport& autopilot);
  void hear(const DeckNews& deck);
  /// After the platforms of the same frame.
  void see(const LevelFrame& frame);
  void hear_laser(std::int64_t utime, double range_m);

  void start();
  void hold();
  void resume();
  void abort();
  void wish(SlotId slot);

  [[nodiscard]] Phase phase() const { return record_.phase; }
  [[nodiscard]] std::int64_t phase_utime() const { return phase_utime_; }
  /// Of the newest VEHICLE_STATE: action and set-point are of this moment.
  [[nodiscard]] std::int64_t utime() const { return utime_; }
  [[nodiscard]] Action action() const { return action_; }
  [[nodiscard]] const std::string& reason() const { return reason_; }
  [[nodiscard]] const std::vector<SlotCandidate>& candidates() const { return candidates_; }
  [[nodiscard]] std::vector<RaisedEmergency> emergencies() const { return board_.list(); }
  [[nodiscard]] std::optional<Setpoint> setpoint() const;
  [[nodiscard]] std::optional<CarryTarget> target(std::int64_t utime) const;
  /// The circle that the tracker should hold on to: the one of the newest frame that lies where the target
  /// does.
  [[nodiscard]] std::optional<std::int64_t> target_track() const { return target_track_; }
  /// To be written down whenever it has changed.
  [[nodiscard]] const CarryRecord& record() const { return record_; }
  [[nodiscard]] std::int64_t record_number() const { return record_number_; }
  /// Marks should be in view now, or the target: else their absence is nothing to worry about.
  [[nodiscard]] bool expects_marks() const;

 private:
  struct Goal {
    Eigen::Vector3d aircraft_odometry_m;
    Eigen::Vector3d velocity_mps;
    double heading_rad;
  };

  // ---- one step of time ----
  void tick();
  void obey_autopilot();
  std::optional<Event> look();
  void fire(Event event);
  void take_effect(Event event);
  void fail_target();
  void note_loaded();
  void note_delivered();
  void settle();
  void forget_stream();
  void note_silence(double passed_s);
  void say(std::string reason) { reason_ = std::move(reason); }

  // ---- what each phase waits for ----
  std::optional<Event> look_in_take_off();
  std::optional<Event> look_in_search();
  std::optional<Event> look_in_approach();
  std::optional<Event> look_in_descend();
  std::optional<Event> look_in_load();
  std::optional<Event> look_in_verify_load();
  std::optional<Event> look_in_transit();
  std::optional<Event> look_in_drop();
  std::optional<Event> look_in_verify_drop();
  std::optional<Event> look_in_retry();
  std::optional<Event> look_in_go_home();
  std::optional<Event> look_in_land();
  std::optional<Event> none_left();
  std::optional<Event> hook_is_silent();
  [[nodiscard]] std::vector<bool> done_slots(const DeckPath& course) const;
  [[nodiscard]] ChoiceInputs choice_inputs(const DeckPath& course) const;

  // ---- where things are ----
  [[nodiscard]] const DeckPath* deck(int platform) const;
  [[nodiscard]] int goal_platform() const;
  /// Since the platform to load from or drop on was seen with its circles; without end: never.
  [[nodiscard]] double goal_age_s() const;
  /// The platform that comes next was in view a moment ago, and its circles are known.
  [[nodiscard]] bool sees_deck() const;
  /// Of the camera over a deck's middle.
  [[nodiscard]] double camera_height_m(const DeckPath& course) const;
  /// The target's platform is known, and its circles by number.
  [[nodiscard]] bool has_target_place() const;
  /// Where the hook is to be for the last step: at the handle, or where the cargo it carries stands on the
  /// deck.
  [[nodiscard]] PointPath hook_goal(std::int64_t utime) const;
  [[nodiscard]] double hook_height_at(double camera_height_m) const;
  [[nodiscard]] Eigen::Vector3d hook_odometry_m() const;
  /// From the aircraft's point to where the hook is learnt to hang in the mean.
  [[nodiscard]] Eigen::Vector3d hangs_ned_m() const;
  [[nodiscard]] Eigen::Vector3d hook_miss_ned_m() const;
  /// The rim of the target's cargo was made out, often enough to be no mistake.
  [[nodiscard]] bool knows_cargo_place() const;
  [[nodiscard]] double target_age_s() const;
  [[nodiscard]] double in_phase_s() const { return static_cast<double>(utime_ - phase_utime_) * 1e-6; }
  /// The hook against its goal: how far beside it in the mean and now that it swings, height over it,
  /// relative speed.
  struct Miss {
    double aim_m, horizontal_m, height_m, speed_mps;
  };
  [[nodiscard]] Miss miss() const;
  void feel_touch();
  void learn_hook(const Eigen::Vector3d& off_ned_m, double heading_rad);
  void learn_from_drop();
  void work_jaws(const Miss& off, double felt_about_m);
  /// A cargo that was taken hold of stays low for a while: what slips off then falls onto its base.
  [[nodiscard]] bool tries_hold() const;
  [[nodiscard]] bool may_let_go(const Miss& off) const;
  void follow_numbers(const DeckPath& after, std::int64_t utime);
  void renumber(const std::map<SlotId, SlotId>& renumbered);
  [[nodiscard]] bool is_on_deck(const Eigen::Vector3d& point_odometry_m, std::int64_t utime,
                                std::optional<int> but = std::nullopt) const;
  [[nodiscard]] std::optional<Eigen::Vector2d> turned_by(const DeckPath& course, const LevelFrame& frame,
                                                         const VehicleMoment& moment) const;
  void see_cargoes(const DeckPath& course, const LevelFrame& frame, const VehicleMoment& moment);
  void look_for_pad(const LevelFrame& frame);
  void look_for_circles(const LevelFrame& frame);
  [[nodiscard]] std::optional<std::size_t> closer_slot() const;
  [[nodiscard]] Eigen::Vector3d searched_place_m(std::int64_t utime) const;
  [[nodiscard]] Eigen::Vector3d camera_odometry_m(const VehicleMoment& moment) const;
  [[nodiscard]] Eigen::Vector3d odometry_of(const LevelMark& mark, const VehicleMoment& moment) const;

  // ---- where the aircraft should be ----
  void guide(double passed_s);
  [[nodiscard]] std::optional<Goal> goal(double passed_s);
  Goal over_target(double wanted_height_m, double rate_mps, double passed_s);
  Goal over_deck(double height_m);
  Goal over_home(double height_m);
  Goal stay(double climb_rate_mps, double passed_s);
  [[nodiscard]] Eigen::Vector2d feeling_about_m(double ahead_s) const;
  [[nodiscard]] double felt_height_m() const;
  double deck_level_m(double now_m);
  [[nodiscard]] double target_heading_rad() const;

  void watch_laser(std::int64_t utime, double range_m, const Eigen::Vector3d& laser_odometry_m,
                   const Eigen::Vector3d& beam);
  void watch_frames(const LevelFrame& frame);
  void watch_target();

  CarrySettings settings_;
  CarryRecord record_;
  std::int64_t record_number_ = 0;
  EmergencyBoard board_;
  std::string reason_;
  std::vector<SlotCandidate> candidates_;
  Action action_ = Action::none;

  std::int64_t utime_ = 0;  ///< of the newest VEHICLE_STATE
  std::int64_t phase_utime_ = 0;
  VehicleHistory vehicle_;
  std::optional<VehicleMoment> now_;
  Eigen::Vector3d velocity_mps_ =
      Eigen::Vector3d::Zero();  ///< of the aircraft, smoothed over a fifth of a second
  Hanging hanging_;
  std::map<int, DeckPath> decks_;
  std::map<int, DeckPath> numbered_;  ///< the newest of each whose circles were known
  CargoPlaces places_;
  std::optional<HookReport> hook_;  ///< nothing: it has not told of late
  double hook_silent_s_ = 0;        ///< for so long
  std::optional<AutopilotReport> autopilot_;
  double autopilot_silent_s_ = 0;
  bool may_have_let_go_ = false;  ///< restored from the very step, and the hook was not heard yet
  double empty_load_n_ = 0;
  int empty_readings_ = 0;
  std::optional<SlotId> wished_;
  std::optional<SlotId> kept_;  ///< chosen before, and neither done nor lost
  std::optional<std::int64_t> target_track_;

  std::optional<Eigen::Vector3d> home_odometry_m_;
  std::optional<Eigen::Vector3d> pad_odometry_m_;  ///< its circle, as seen on the way home
  std::int64_t pad_utime_ = 0;
  std::optional<std::int64_t> aligned_since_;
  std::optional<std::int64_t> light_since_;  ///< the hook bears too little
  std::optional<std::int64_t> heavy_since_;
  std::optional<std::int64_t> nothing_since_;  ///< nothing to choose
  std::optional<double> height_m_;             ///< of the hook over its goal, as commanded
  double rise_mps_ = 0;                        ///< its rate
  std::optional<Goal> goal_;
  std::optional<Eigen::Vector3d> stay_odometry_m_;
  double climbed_m_ = 0;                                           ///< from there, in this phase
  double heading_rad_ = 0;                                         ///< wanted
  bool closes_jaws_ = false, opens_jaws_ = false, lands_ = false;  ///< in this phase
  std::optional<std::int64_t> closing_since_;  ///< when the jaws were first told to, in this phase
  /// When the cargo touched the deck.
  struct Touch {
    Eigen::Vector3d off_ned_m;  ///< from where it was to stand
    double heading_rad;
  };
  std::optional<Touch> touch_;
  int touches_off_ = 0;                       ///< times that it was too far off, with this target
  std::optional<std::int64_t> search_utime_;  ///< since when a spiral is flown
  double ground_m_ = 0;                       ///< odometry, down: what the laser meets below, in the mean
  std::int64_t ground_utime_ = 0;
  /// Circles seen in a search that no platform has taken.
  struct Sighting {
    Eigen::Vector3d off_odometry_m;  ///< of their middle, from where the platform is thought to be
    std::int64_t first_utime;
  };
  std::optional<Sighting> sighting_;
  double level_m_ = 0;  ///< of the deck that is looked for, odometry z
  std::int64_t level_utime_ = 0;
  LevelFrame last_frame_;
  std::int64_t unchanged_since_ = 0;
};

}  // namespace stevedore
