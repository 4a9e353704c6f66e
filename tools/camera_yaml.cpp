#include "tools/camera_yaml.hpp"

#include <fmt/format.h>

#include <numbers>

namespace stevedore {
namespace {

Pinhole resized(const Pinhole& pinhole, int width_px, int height_px) {
  const double scale = static_cast<double>(width_px) / pinhole.width_px;
  // the principal point keeps its place against the middle of the image; (0, 0) is a pixel's centre
  const double middle_u_px = (pinhole.width_px - 1) / 2.0, middle_v_px = (pinhole.height_px - 1) / 2.0;
  return {width_px,
          height_px,
          pinhole.fx_px * scale,
          pinhole.fy_px * scale,
          (pinhole.cx_px - middle_u_px) * scale + (width_px - 1) / 2.0,
          (pinhole.cy_px - middle_v_px) * scale + (height_px - 1) / 2.0};
}

std::string distortion_name(Distortion distortion) {
  switch (distortion) {
    case Distortion::none:
      return "none";
    case Distortion::plumb_bob:
      return "plumb_bob";
    case Distortion::equidistant:
      return "equidistant";
  }
  return "none";
}

std::string response_name(const Response& response) {
  switch (response.curve) {
    case Response::Curve::linear:
      return "linear";
    case Response::Curve::srgb:
      return "srgb";
    case Response::Curve::gamma:
      return fmt::format("{}", response.gamma);
  }
  return "srgb";
}

}  // namespace

std::string camera_yaml(const CameraModel& camera, const std::string& name) {
  const Pinhole &g = camera.given, &r = camera.rectified;
  constexpr double degrees = 180 / std::numbers::pi;
  std::string text = fmt::format(
      "image_width: {}\nimage_height: {}\ncamera_name: {}\n"
      "camera_matrix:\n  rows: 3\n  cols: 3\n  data: [{}, 0, {}, 0, {}, {}, 0, 0, 1]\n"
      "distortion_model: {}\n",
      g.width_px, g.height_px, name, g.fx_px, g.cx_px, g.fy_px, g.cy_px, distortion_name(camera.distortion));
  if (!camera.coefficients.empty())
    text += fmt::format("distortion_coefficients:\n  rows: 1\n  cols: {}\n  data: [{}]\n",
                        camera.coefficients.size(), fmt::join(camera.coefficients, ", "));
  text += fmt::format(
      "projection_matrix:\n  rows: 3\n  cols: 4\n  data: [{}, 0, {}, 0, 0, {}, {}, 0, 0, 0, 1, 0]\n"
      "response: {}\nmount_deg: {{roll: {}, pitch: {}, yaw: {}}}\n",
      r.fx_px, r.cx_px, r.fy_px, r.cy_px, response_name(camera.response), camera.mount.roll_rad * degrees,
      camera.mount.pitch_rad * degrees, camera.mount.yaw_rad * degrees);
  return text;
}

CameraModel resized(const CameraModel& camera, int width_px, int height_px) {
  CameraModel out = camera;
  out.given = resized(camera.given, width_px, height_px);
  out.rectified = resized(camera.rectified, width_px, height_px);
  return out;
}

}  // namespace stevedore
