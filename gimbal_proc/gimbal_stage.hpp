// VEHICLE_STATE and GIMBAL_STATE in; for every VEHICLE_STATE GIMBAL_COMMAND and GIMBAL_LEVEL out.
#pragma once

#include "gimbal_proc/gimbal.hpp"
#include "runtime/bus.hpp"
#include "runtime/condition.hpp"

namespace stevedore {

class GimbalStage {
 public:
  GimbalStage(const GimbalSettings& settings, const CameraMount& mount, Bus& bus);

  /// For HEALTH: degraded, and why, when the pan-tilt is stuck or silent.
  [[nodiscard]] const Condition& condition() const { return condition_; }

 private:
  void on_vehicle(const vehicle_state_t& vehicle);
  void publish(const header_t& cause, const GimbalStep& step);

  Bus& bus_;
  Gimbal gimbal_;
  Condition condition_{health_t::STATE_STARTING, "no VEHICLE_STATE yet"};
};

}  // namespace stevedore
