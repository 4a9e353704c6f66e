#include "sim_proc/world/told_and_true.hpp"

#include <algorithm>

#include "sim_proc/world/dice.hpp"

namespace stevedore::world {
namespace {

double draw(double sigma, Dice& dice) {
  return std::clamp(dice.normal(sigma), -2 * sigma, 2 * sigma);
}

Eigen::Vector3d draw3(double sigma, Dice& dice) {
  const double x = draw(sigma, dice), y = draw(sigma, dice), z = draw(sigma, dice);
  return {x, y, z};
}

/// Focal length and principal point belong to lens and sensor: the image as given and the ideal one share
/// them.
void misjudge(Pinhole& pinhole, double focal_scale, double du_px, double dv_px) {
  pinhole.fx_px *= focal_scale;
  pinhole.fy_px *= focal_scale;
  pinhole.cx_px += du_px;
  pinhole.cy_px += dv_px;
}

}  // namespace

TrueSelf draw_true_self(std::uint64_t seed, const TellingErrors& errors, const CameraModel& told_camera,
                        const LeverArms& told_arms) {
  Dice dice(seed, "told and true");
  TrueSelf self{told_camera, told_arms, 1, 0};
  const double focal_scale = 1 + draw(errors.focal_share, dice);
  const double du_px = draw(errors.principal_point_px, dice), dv_px = draw(errors.principal_point_px, dice);
  misjudge(self.camera.given, focal_scale, du_px, dv_px);
  misjudge(self.camera.rectified, focal_scale, du_px, dv_px);
  self.camera.mount.roll_rad += draw(errors.mount_rad, dice);
  self.camera.mount.pitch_rad += draw(errors.mount_rad, dice);
  self.camera.mount.yaw_rad += draw(errors.mount_rad, dice);
  self.arms.camera_body_m += draw3(errors.lever_arm_m, dice);
  self.arms.hook_body_m += draw3(errors.lever_arm_m, dice);
  self.arms.altimeter_body_m += draw3(errors.lever_arm_m, dice);
  self.arms.rope_m += draw(errors.lever_arm_m, dice);
  self.circle_scale = 1 + draw(errors.circle_share, dice);
  self.stamp_late_s = draw(errors.stamp_s, dice);
  return self;
}

}  // namespace stevedore::world
