#include "mission_proc/emergency.hpp"

namespace stevedore {

void EmergencyBoard::set(Emergency kind, bool present, double time_s, const std::string& cause) {
  Alarm& alarm = this->alarm(kind);
  if (present == alarm.raised) {
    alarm.changing = false;
    return;
  }
  if (!alarm.changing) {
    alarm.changing = true;
    alarm.changing_since_s = time_s;
  }
  const double delay_s = present ? alarm.delay.raise_s : alarm.delay.clear_s;
  if (time_s - alarm.changing_since_s < delay_s) return;
  alarm.raised = present;
  alarm.changing = false;
  if (present) {
    alarm.since_s = time_s;
    alarm.cause = cause;
  }
}

void EmergencyBoard::clear() {
  for (Alarm& alarm : alarms_) alarm.raised = alarm.changing = false;
}

std::vector<RaisedEmergency> EmergencyBoard::list() const {
  std::vector<RaisedEmergency> list;
  for (std::size_t i = 0; i < alarms_.size(); ++i) {
    if (alarms_[i].raised) list.push_back({static_cast<Emergency>(i), alarms_[i].since_s, alarms_[i].cause});
  }
  return list;
}

}  // namespace stevedore
