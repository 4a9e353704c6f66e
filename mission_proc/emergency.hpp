// What is wrong, since when.
#pragma once

#include <string>
#include <vector>

namespace stevedore {

enum class Emergency {
  all_out_of_view,
  target_lost,
  vision_stale,
  platform_not_found,
  camera_frozen,
  altitude_disagrees,
  cargo_lost,
  gimbal_not_level,
  identity_uncertain
};
constexpr int emergency_count = 9;

struct RaisedEmergency {
  Emergency kind;
  double since_s = 0;
  std::string cause;
};

/// How long something must be so before it is told, and how long it must be over before that is told.
struct AlarmDelay {
  double raise_s = 0;
  double clear_s = 0;
};

class EmergencyBoard {
 public:
  void set_delay(Emergency kind, AlarmDelay delay) { alarm(kind).delay = delay; }
  void set(Emergency kind, bool present, double time_s, const std::string& cause);
  /// All off, e.g. when time starts anew.
  void clear();
  [[nodiscard]] bool raised(Emergency kind) const { return alarms_[index(kind)].raised; }
  [[nodiscard]] std::vector<RaisedEmergency> list() const;

 private:
  struct Alarm {
    AlarmDelay delay;
    bool raised = false;
    bool changing = false;  ///< it is otherwise than told
    double changing_since_s = 0;
    double since_s = 0;
    std::string cause;
  };
  static std::size_t index(Emergency kind) { return static_cast<std::size_t>(kind); }
  Alarm& alarm(Emergency kind) { return alarms_[index(kind)]; }

  std::vector<Alarm> alarms_ = std::vector<Alarm>(emergency_count);
};

}  // namespace stevedore
