#include "tools/stills.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <numbers>
#include <string>

#include "sim_proc/world/dice.hpp"
#include "sim_proc/world/scenery.hpp"

namespace stevedore {
namespace {

using Eigen::AngleAxisd;
using Eigen::Quaterniond;
using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;
using world::Dice;
using world::Rigid;

constexpr std::array<double, 5> roll_pitch_rms_deg = {0, 0.7, 1.5, 3, 5};  // by sea state
constexpr std::array<double, 5> heave_rms_m = {0, 0.05, 0.10, 0.25, 0.4};

double radians(double degrees) {
  return degrees * pi / 180;
}

Quaterniond turned(double yaw, double pitch, double roll) {
  return AngleAxisd(yaw, Vector3d::UnitZ()) * AngleAxisd(pitch, Vector3d::UnitY()) *
         AngleAxisd(roll, Vector3d::UnitX());
}

/// Places one still's things one after the other.
class StillMaker {
 public:
  StillMaker(const StillCamera& camera, std::uint64_t seed, int number)
      : camera_(camera),
        dice_(seed, "still " + std::to_string(number)),
        scenery_(world::draw_scenery({dice_.next(), false, camera.circle_radius_m})) {}

  Still make() {
    still_.circle_radius_m = camera_.circle_radius_m;
    still_.sea_state = dice_.whole(0, 4);
    place_decks();
    still_.scene = scenery_.place(decks_);
    list_circles();
    aim();
    place_camera();
    place_buckets();
    return std::move(still_);
  }

 private:
  void place_decks() {
    const auto sea = static_cast<size_t>(still_.sea_state);
    const bool afloat = scenery_.surroundings.kind == world::Surroundings::Kind::water;
    const double apart_m = dice_.uniform(15, 30), bearing = dice_.uniform(-pi, pi);
    for (size_t i = 0; i < scenery_.decks.size(); ++i) {
      const double thickness_m = scenery_.decks[i].thickness_m;
      const bool is_pad = i == 2, moves = !is_pad && dice_.chance(0.7);
      Rigid deck;
      deck.position_ned_m =
          static_cast<double>(i) * apart_m * Vector3d(std::cos(bearing), std::sin(bearing), 0);
      deck.position_ned_m.z() = -thickness_m;  // it stands on the ground, or floats with what moves it
      const double rms = is_pad ? 0 : radians(roll_pitch_rms_deg[sea]), yaw = dice_.uniform(-pi, pi);
      const double roll = dice_.normal(rms), pitch = dice_.normal(rms);
      deck.ned_from_local = turned(yaw, pitch, roll);
      if (afloat && !is_pad) deck.position_ned_m.z() += dice_.normal(heave_rms_m[sea]) * 0.5 - 0.1;
      const double speed = moves ? dice_.uniform(0, 1.5) : 0;
      deck.velocity_ned_mps = speed * Vector3d(std::cos(yaw), std::sin(yaw), 0);
      decks_.push_back(deck);
    }
  }

  void list_circles() {
    for (size_t i = 0; i < decks_.size(); ++i)
      for (const world::Mark& mark : scenery_.decks[i].marks) {
        if (mark.slot < 0) continue;
        const Vector2d& at = mark.center_deck_m;
        still_.circles.push_back({static_cast<int>(i), mark.slot, false,
                                  decks_[i].to_ned({at.x(), at.y(), 0}),
                                  decks_[i].ned_from_local * -Vector3d::UnitZ()});
      }
  }

  /// Which platform, from how high, and what point of its plane the camera stands over.
  void aim() {
    platform_ = dice_.chance(0.1) ? 2 : static_cast<size_t>(dice_.whole(0, 1));
    constexpr double lowest_m = 1.5, highest_m = 12;
    still_.height_m = lowest_m * std::pow(highest_m / lowest_m, dice_.uniform(0, 1));
    const Vector2d half = scenery_.decks[platform_].half_size_m;
    const Pinhole& lens = camera_.real.given;
    const double view_m = still_.height_m * lens.height_px / 2 / lens.fy_px;  // half of the shorter side
    const double kind = dice_.uniform(0, 1), way = dice_.uniform(-pi, pi);
    const Vector2d outwards(std::cos(way), std::sin(way));
    const Vector2d slot = any_slot();
    if (kind < 0.06) {  // nothing to find
      over_m_ = outwards * (half.norm() + view_m * 2 + 1);
    } else if (kind < 0.36) {  // a circle on the image's border
      over_m_ = slot + outwards * (view_m + dice_.uniform(-0.3, 0.35));
    } else if (kind < 0.55) {  // descent over a circle
      over_m_ = slot + outwards * dice_.uniform(0, 0.3);
    } else {  // somewhere over the platform
      const double y = dice_.uniform(-1, 1), x = dice_.uniform(-1, 1);
      over_m_ = Vector2d(x * (half.x() + view_m / 3), y * (half.y() + view_m / 3));
    }
  }

  Vector2d any_slot() {
    std::vector<Vector2d> slots;
    for (const world::Mark& mark : scenery_.decks[platform_].marks)
      if (mark.slot >= 0) slots.push_back(mark.center_deck_m);
    return slots.at(static_cast<size_t>(dice_.whole(0, static_cast<int>(slots.size()) - 1)));
  }

  void place_camera() {
    world::Eye& eye = still_.scene.eye;
    eye.lens = camera_.real;
    const Rigid& deck = decks_[platform_];
    eye.rigid.position_ned_m = deck.to_ned({over_m_.x(), over_m_.y(), -still_.height_m});
    const bool swinging = dice_.chance(0.12);  // a gust that the gimbal has not caught up with
    const double off_level = radians(swinging ? dice_.uniform(1.5, 3.5) : 0.5);
    const double yaw = dice_.uniform(-pi, pi);
    const double roll = dice_.normal(off_level), pitch = dice_.normal(off_level);
    const Quaterniond level = turned(yaw, pitch, roll);
    Eigen::Matrix3d platform_from_camera;  // x right, y backward, z down
    platform_from_camera << 0, -1, 0, 1, 0, 0, 0, 0, 1;
    eye.rigid.ned_from_local = level * Quaterniond(platform_from_camera);
    const double brisk = dice_.chance(0.15) ? 2 : 0.7;  // on the way from platform to platform, or hovering
    const double down_mps = dice_.normal(0.3), east_mps = dice_.normal(brisk),
                 north_mps = dice_.normal(brisk);
    eye.rigid.velocity_ned_mps = deck.velocity_ned_mps + Vector3d(north_mps, east_mps, down_mps);
    eye.rigid.angular_velocity_ned_radps = {dice_.normal(0.15), dice_.normal(0.15), dice_.normal(0.2)};
    eye.gain = static_cast<float>(1.15 * std::exp(dice_.normal(0.2)));  // the exposure is never quite right
    eye.noise_seed = dice_.next();
    world::AircraftShadow& aircraft = still_.scene.aircraft;
    aircraft.body = eye.rigid;
    const double bank = dice_.normal(radians(4)), nose = dice_.normal(radians(4));
    aircraft.body.ned_from_local = turned(yaw, nose, bank);
    const Vector3d camera_body_m(0.8, 0, 0.25);
    aircraft.body.position_ned_m = eye.rigid.position_ned_m - aircraft.body.ned_from_local * camera_body_m;
  }

  void place_buckets() {
    auto& buckets = still_.scene.buckets;
    std::erase_if(buckets, [&](const world::Bucket&) { return dice_.chance(0.3); });
    const bool carries = !buckets.empty() && still_.height_m > 1.9 && dice_.chance(0.15);
    std::vector<StillCircle*> free_circles;
    for (StillCircle& circle : still_.circles)
      if (circle.platform == static_cast<int>(platform_)) free_circles.push_back(&circle);
    for (size_t i = 0; i < buckets.size(); ++i) {
      StillCargo cargo;
      cargo.index = buckets[i].index;
      if (carries && i == 0)
        hang(buckets[i]);
      else if (!free_circles.empty())
        stand(buckets[i], cargo, free_circles);
      else {
        buckets.resize(i);
        break;
      }
      still_.cargoes.push_back(cargo);
    }
  }

  void stand(world::Bucket& bucket, StillCargo& cargo, std::vector<StillCircle*>& free_circles) {
    const auto pick = static_cast<size_t>(dice_.whole(0, static_cast<int>(free_circles.size()) - 1));
    StillCircle& circle = *free_circles[pick];
    free_circles.erase(free_circles.begin() + static_cast<std::ptrdiff_t>(pick));
    const Rigid& deck = decks_[platform_];
    constexpr double most_off_m = 0.15;
    const double off_m = most_off_m * std::sqrt(dice_.uniform(0, 1)), way = dice_.uniform(-pi, pi);
    const Vector3d shift(off_m * std::cos(way), off_m * std::sin(way), 0);
    bucket.rigid = deck;
    bucket.rigid.position_ned_m = circle.center_ned_m + deck.ned_from_local * shift;
    bucket.rigid.ned_from_local = deck.ned_from_local * AngleAxisd(dice_.uniform(-pi, pi), Vector3d::UnitZ());
    bucket.rigid.velocity_ned_mps = deck.velocity_at(bucket.rigid.position_ned_m);
    circle.occupied = true;
    cargo.platform = circle.platform;
    cargo.slot = circle.slot;
  }

  void hang(world::Bucket& bucket) {
    const Rigid& body = still_.scene.aircraft.body;
    constexpr double rope_m = 0.8;
    const double swing_x = dice_.normal(0.08), swing_y = dice_.normal(0.08);
    const Quaterniond swung = turned(dice_.uniform(-pi, pi), swing_x, swing_y);
    const Vector3d hook = body.to_ned({0, 0, 0.35}), handle = hook + swung * Vector3d(0, 0, rope_m);
    bucket.handle_rad = 0;
    bucket.rigid = body;
    bucket.rigid.ned_from_local = swung;
    bucket.rigid.position_ned_m = handle + swung * Vector3d(0, 0, bucket.height_m + bucket.handle_rise_m);
    world::Strand rope;
    rope.radius_m = 0.004;
    rope.surface.colour = {0.5F, 0.48F, 0.42F};
    rope.points_ned_m = {hook, handle};
    still_.scene.strands.push_back(rope);
  }

  const StillCamera& camera_;
  Dice dice_;
  world::Scenery scenery_;
  Still still_;
  std::vector<Rigid> decks_;
  size_t platform_ = 0;
  Vector2d over_m_ = Vector2d::Zero();
};

}  // namespace

StillCamera draw_still_camera(const CameraModel& told, std::uint64_t seed, bool exact) {
  StillCamera camera{told, told, 0.5};
  if (exact) return camera;
  Dice dice(seed, "camera");
  const double focal = 1 + dice.normal(0.003), px = told.given.width_px / 640.0;
  const double shift_u_px = dice.normal(2 * px), shift_v_px = dice.normal(2 * px);
  for (Pinhole* pinhole : {&camera.real.given, &camera.real.rectified}) {
    pinhole->fx_px *= focal;
    pinhole->fy_px *= focal;
    pinhole->cx_px += shift_u_px;
    pinhole->cy_px += shift_v_px;
  }
  camera.circle_radius_m *= 1 + dice.normal(0.005);
  return camera;
}

Still draw_still(const StillCamera& camera, std::uint64_t seed, int number) {
  return StillMaker(camera, seed, number).make();
}

}  // namespace stevedore
