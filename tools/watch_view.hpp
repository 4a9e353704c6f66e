// What `watch` knows of a running set, and when it is over. Told of messages and of time; has no clock.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/report_core.hpp"

namespace stevedore {

/// All times: us, CLOCK_MONOTONIC.
class WatchView {
 public:
  /// cargoes: how many a mission is to carry; 0: no mission is watched.
  explicit WatchView(int64_t start_utime, int cargoes = 0);

  void on_health(const health_t& health, int64_t now);
  void on_frame(const header_t& frame);
  void on_ellipses(const ellipses_t& ellipses, int64_t now);
  void on_tracks(const tracks_t& tracks, int64_t now);
  void on_poses(const poses_t& poses, int64_t now);
  void on_mission(const mission_t& mission, int64_t now);

  /// The camera has finished, and what it published has gone through the line.
  [[nodiscard]] bool worked_off(int64_t now) const;
  /// The mission that is watched has flown and is over: complete, or back on the ground with nobody flying.
  [[nodiscard]] bool mission_over(int64_t now) const;
  /// The camera has come to its end and never sent a frame: nothing to wait for.
  [[nodiscard]] bool ended_without_frames() const;
  /// What the camera last said of itself.
  [[nodiscard]] const std::string& camera_message() const { return camera_message_; }
  /// Why no MISSION comes; names who is silent.
  [[nodiscard]] std::string silence(int64_t now) const;
  /// How long no frame has come out of the line.
  [[nodiscard]] double silent_s(int64_t now) const;

  /// One line; rate and latency are those of the time since the last call.
  std::string line(int64_t now);
  /// Changes of the processes' states since the last call.
  std::vector<std::string> take_news();

 private:
  [[nodiscard]] int64_t frames_in() const;
  [[nodiscard]] std::string progress() const;

  int64_t start_utime_;
  int cargoes_;
  HealthBook health_;
  std::map<std::string, int64_t> heard_utime_;    ///< by process: HEALTH arrived
  std::map<std::string, int64_t> output_utime_;   ///< by channel: arrived, for a frame
  std::map<std::string, std::string> condition_;  ///< by process, as last told
  std::vector<std::string> news_;

  int64_t camera_run_id_ = 0;
  int64_t newest_answered_seq_ = -1;  ///< of this run of the camera
  bool camera_finished_ = false;
  std::string camera_message_;
  int64_t published_ = 0;                    ///< by this run of the camera
  std::map<int64_t, int64_t> camera_drops_;  ///< by run of the camera

  int64_t frames_out_ = 0;
  int64_t tracked_ = 0;
  std::string target_ = "-";
  std::string phase_ = "-";
  int delivered_ = 0;
  std::string circle_ = "-";  ///< of the mission's target: platform and number
  bool has_flown_ = false;
  std::optional<int64_t> over_utime_;
  std::string emergencies_;
  int64_t line_utime_;
  std::vector<int64_t> latencies_us_;  ///< since the last line
};

}  // namespace stevedore
