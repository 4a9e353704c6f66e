#include "tools/still_truth.hpp"

#include "sim_proc/world/outline.hpp"

namespace stevedore {
namespace {

using Json = nlohmann::ordered_json;
using Eigen::Vector3d;

constexpr double whole_share = 0.98;  // one sample in sixty may be behind a rope

Json json_of(const Vector3d& v) {
  return Json::array({v.x(), v.y(), v.z()});
}

Json json_of(const world::Outline& outline) {
  const Ellipse& e = outline.given;
  return {{"u", e.u_px}, {"v", e.v_px}, {"a", e.a_px}, {"b", e.b_px}, {"alpha", e.alpha_rad}};
}

Vector3d camera_direction(const Still& still, const Vector3d& ned) {
  return still.scene.eye.rigid.ned_from_local.conjugate() * ned;
}

Json circle_json(const Still& still, const StillCircle& circle, const world::Outline& outline) {
  Json json = json_of(outline);
  json["whole"] = outline.visible_share >= whole_share;
  json["visible_share"] = outline.visible_share;
  json["occupied"] = circle.occupied;
  json["platform"] = circle.platform;
  json["slot"] = circle.slot;
  json["center"] = json_of(still.scene.eye.rigid.to_local(circle.center_ned_m));
  json["normal"] = json_of(camera_direction(still, circle.normal_ned));
  json["radius"] = still.circle_radius_m;
  return json;
}

Json cargoes_json(const Still& still) {
  Json cargoes = Json::array();
  for (size_t i = 0; i < still.cargoes.size(); ++i) {
    const world::Bucket& bucket = still.scene.buckets[i];
    const Vector3d rim = bucket.rigid.to_ned({0, 0, -bucket.height_m});
    const Vector3d axis = bucket.rigid.ned_from_local * -Vector3d::UnitZ();
    const auto outline = world::outline_of(still.scene, {rim, axis, bucket.rim_radius_m});
    if (!outline || outline->visible_share <= 0) continue;
    Json json = json_of(*outline);
    json["visible_share"] = outline->visible_share;
    json["index"] = still.cargoes[i].index;
    json["platform"] = still.cargoes[i].platform;
    json["slot"] = still.cargoes[i].slot;
    json["center"] = json_of(still.scene.eye.rigid.to_local(rim));
    json["axis"] = json_of(camera_direction(still, axis));
    json["radius"] = bucket.rim_radius_m;
    cargoes.push_back(json);
  }
  return cargoes;
}

}  // namespace

Json truth_of(const Still& still, const std::string& image, const std::string& camera_file) {
  constexpr TruthFloor floor;
  Json ellipses = Json::array(), hidden = Json::array();
  for (const StillCircle& circle : still.circles) {
    const auto outline =
        world::outline_of(still.scene, {circle.center_ned_m, circle.normal_ned, still.circle_radius_m});
    if (!outline || outline->visible_share <= 0) continue;
    const bool counts =
        outline->visible_share >= floor.visible_share && outline->given.b_px >= floor.semi_minor_px;
    (counts ? ellipses : hidden).push_back(circle_json(still, circle, *outline));
  }
  Json line;
  line["image"] = image;
  line["labelled"] = true;
  line["ellipses"] = ellipses;
  line["hidden"] = hidden;
  line["cargoes"] = cargoes_json(still);
  line["gravity"] = json_of(camera_direction(still, Vector3d::UnitZ()));
  line["height"] = still.height_m;
  line["sea_state"] = still.sea_state;
  line["camera"] = camera_file;
  return line;
}

}  // namespace stevedore
