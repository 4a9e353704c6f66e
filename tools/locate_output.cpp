#include "tools/locate_output.hpp"

#include <array>
#include <cmath>
#include <cstdio>

#include "tools/draw.hpp"

namespace stevedore {
namespace {

using Json = nlohmann::ordered_json;

const char* name(Label label) {
  switch (label) {
    case Label::circle:
      return "circle";
    case Label::cargo:
      return "cargo";
    case Label::unknown:
      return "unknown";
  }
  return "unknown";
}

const char* name(TrackStatus status) {
  switch (status) {
    case TrackStatus::searching:
      return "searching";
    case TrackStatus::tracking:
      return "tracking";
    case TrackStatus::predicted:
      return "predicted";
    case TrackStatus::lost:
      return "lost";
  }
  return "lost";
}

Json json_of(const Eigen::Vector3d& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

Json json_of(const CirclePose& pose) {
  if (pose.solutions.empty()) return nullptr;
  const auto& [circle, probability] = pose.solutions.front();
  Json covariance = Json::array();
  for (int row = 0; row < 3; ++row) {
    for (int col = 0; col < 3; ++col) covariance.push_back(circle.covariance_m2(row, col));
  }
  Json out = {{"center", json_of(circle.center_camera_m)},
              {"normal", json_of(circle.normal_camera)},
              {"covariance", covariance},
              {"probability", probability},
              {"alternative", nullptr}};
  if (pose.solutions.size() > 1) {
    const CircleSolution& other = pose.solutions[1].circle;
    out["alternative"] = {{"center", json_of(other.center_camera_m)},
                          {"normal", json_of(other.normal_camera)}};
  }
  return out;
}

void add_ellipse(Json& out, const Ellipse& e) {
  out["u"] = e.u_px;
  out["v"] = e.v_px;
  out["a"] = e.a_px;
  out["b"] = e.b_px;
  out["alpha"] = e.alpha_rad;
}

Json json_of(const LocatedMark& mark) {
  const Detection& d = mark.detection;
  Json out;
  add_ellipse(out, mark.given);
  out["error"] = d.error;
  out["kind"] = d.kind == Kind::whole ? "whole" : "partial";
  out["coverage"] = d.coverage;
  out["label"] = name(d.label);
  out["occupied"] = d.occupied ? Json(*d.occupied) : Json(nullptr);
  out["circle"] = json_of(mark.pose);
  return out;
}

Json json_of(const LocatedTarget& target) {
  Json out = {{"status", name(target.status)}, {"id", target.id ? Json(*target.id) : Json(nullptr)}};
  if (target.mark) {
    add_ellipse(out, target.mark->given);
    out["circle"] = json_of(target.mark->pose);
  } else {
    for (const char* key : {"u", "v", "a", "b", "alpha", "circle"}) out[key] = nullptr;
  }
  return out;
}

std::string caption_of(const LocatedFrame& frame) {
  std::array<int, 3> count{};
  for (const LocatedMark& mark : frame.marks) ++count[static_cast<std::size_t>(mark.detection.label)];
  std::array<char, 160> text{};
  std::snprintf(text.data(), text.size(), "%d circle, %d cargo, %d unknown (dashed: partial)   %.1f ms",
                count[static_cast<std::size_t>(Label::circle)], count[static_cast<std::size_t>(Label::cargo)],
                count[static_cast<std::size_t>(Label::unknown)], frame.detect_ms);
  return text.data();
}

std::string caption_of(const LocatedTarget& target) {
  std::string text = std::string("target ") + name(target.status);
  if (target.id) text += ", id " + std::to_string(*target.id);
  if (target.mark && !target.mark->pose.solutions.empty()) {
    const double range_m = target.mark->pose.solutions.front().circle.center_camera_m.norm();
    std::array<char, 32> range{};
    std::snprintf(range.data(), range.size(), ", %.2f m away", range_m);
    text += range.data();
  }
  return text;
}

}  // namespace

Json located_json(const std::string& image, cv::Size size, const LocatedFrame& frame) {
  Json ellipses = Json::array();
  for (const LocatedMark& mark : frame.marks) ellipses.push_back(json_of(mark));
  Json out = {{"image", image},
              {"width", size.width},
              {"height", size.height},
              {"detect_ms", std::round(frame.detect_ms * 1000) / 1000},
              {"ellipses", std::move(ellipses)}};
  if (frame.target) out["target"] = json_of(*frame.target);
  return out;
}

Json error_json(const std::string& image, const std::string& error) {
  return {{"image", image}, {"error", error}};
}

cv::Mat overlay_of(const cv::Mat& image, const LocatedFrame& frame) {
  Canvas canvas(image);
  for (const LocatedMark& mark : frame.marks) {
    if (mark.detection.kind == Kind::whole) {
      canvas.ellipse(mark.given, cyan);
    } else {
      canvas.dashed_ellipse(mark.given, cyan);
    }
  }
  std::vector<std::string> caption{caption_of(frame)};
  if (frame.target) {
    if (frame.target->window) canvas.ellipse(*frame.target->window, yellow);
    if (frame.target->mark) canvas.ellipse(frame.target->mark->given, green, 2);
    caption.push_back(caption_of(*frame.target));
  }
  canvas.caption(caption);
  return canvas.image();
}

}  // namespace stevedore
