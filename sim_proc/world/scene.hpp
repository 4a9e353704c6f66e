// Everything there is to see at one instant: what the renderer draws and what rays hit. Plain values; a scene
// knows nothing of time's course. Colours are linear reflectances, red green blue, 0..1.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "geometry/camera_model.hpp"
#include "sim_proc/world/rigid.hpp"

namespace stevedore::world {

/// Paint or cloth or metal: its colour, and how used it looks.
struct Surface {
  Eigen::Vector3f colour{0.5F, 0.5F, 0.5F};
  float grain = 0.1F;         ///< relative contrast of its texture
  float wear = 0;             ///< share of paint that is gone, in patches of a few centimetres
  float gloss = 0;            ///< 0 matt .. 1 mirror-like highlight of the sun
  std::uint32_t texture = 0;  ///< seed of texture and wear
};

/// Something flat painted on a deck. Deck axes: x forward, y right, z down; the deck's upper side is z = 0.
struct Mark {
  enum class Shape {
    disc,  ///< radius_m
    ring,  ///< outer edge radius_m, width_m inwards
    arc,   ///< a ring from angle_rad over sweep_rad
    bar,   ///< length_m x width_m, turned by angle_rad
  };
  Shape shape = Shape::ring;
  Eigen::Vector2d center_deck_m = Eigen::Vector2d::Zero();
  double radius_m = 0;
  double width_m = 0;
  double length_m = 0;
  double angle_rad = 0;  ///< from deck x towards deck y
  double sweep_rad = 0;
  Surface paint;
  int slot = -1;  ///< number of the cargo circle that this is; -1: only something painted
};

/// A platform, or the take-off pad: a box with marks on its upper side. Later marks lie over earlier ones.
struct Deck {
  Rigid rigid;
  Eigen::Vector2d half_size_m{2, 2};
  double thickness_m = 0.5;
  Surface ground;
  std::vector<Mark> marks;
};

/// Open bucket: frustum, axis along local -z (up when local z is down), base at z = 0, rim at z = -height_m.
/// The wire handle is an arc hinged at rim points +-y, turned about the y-axis by handle_rad from upright.
struct Bucket {
  Rigid rigid;
  double base_radius_m = 0.13;
  double rim_radius_m = 0.16;
  double height_m = 0.30;
  double wall_m = 0.004;
  double handle_rise_m = 0.12;  ///< its apex over the rim when upright
  double handle_rad = 0;
  Surface outside;
  Surface inside;
  int index = -1;
};

/// A tyre lying flat: torus, axis along local z, resting on z = 0.
struct Tyre {
  Rigid rigid;
  double radius_m = 0.3;  ///< outer
  double tube_m = 0.09;   ///< radius of the tube
  Surface rubber;
};

/// A capsule: people are made of them, and poles.
struct Capsule {
  Eigen::Vector3d from_ned_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d to_ned_m = Eigen::Vector3d::Zero();
  double radius_m = 0.1;
  Surface surface;
};

/// A thin line: rope, wire. Drawn by coverage, however thin.
struct Strand {
  std::vector<Eigen::Vector3d> points_ned_m;
  double radius_m = 0.004;
  Surface surface;
};

struct Light {
  Eigen::Vector3d to_sun_ned{0, 0, -1};      ///< unit
  Eigen::Vector3f sun{1.0F, 0.96F, 0.9F};    ///< irradiance on a surface that faces it
  Eigen::Vector3f sky{0.25F, 0.28F, 0.32F};  ///< from everywhere else
  double sun_radius_rad = 0.00465;           ///< makes the penumbra; larger: hazy
};

/// What lies around at world z = 0.
struct Surroundings {
  enum class Kind { tarmac, grass, water };
  Kind kind = Kind::tarmac;
  Surface surface;
  double wave_phase_s = 0;  ///< of water: time that its texture has moved for
  float haze = 0;           ///< share of light replaced by grey over 10 m of air
  float spray = 0;          ///< share of the lens covered by droplets
  float glare = 0;          ///< veiling light of the sun in the lens, share of full scale
};

/// The aircraft as what throws a shadow. Body: forward, right, down.
struct AircraftShadow {
  Rigid body;
  double length_m = 1.9;
  double rotor_radius_m = 0.95;
  float rotor_cover = 0.25F;  ///< share of light that the turning rotor takes
};

/// The camera that takes the picture, as it really is. Local axes of the rigid: camera x right, y down, z
/// forward.
struct Eye {
  Rigid rigid;
  CameraModel lens;  ///< `given` and the distortion are the true ones
  double exposure_s =
      0.004;       ///< the shutter is open from half of it before the scene's instant to half after
  float gain = 1;  ///< light to level: 1 puts a white deck facing the sun at full scale
  float blur_sigma_px = 0.6F;    ///< of the lens
  float noise_levels = 2;        ///< standard deviation at mid grey, in grey levels of 255
  std::uint64_t noise_seed = 0;  ///< another for each frame
};

struct Scene {
  Eye eye;
  Light light;
  Surroundings surroundings;
  std::vector<Deck> decks;
  std::vector<Bucket> buckets;
  std::vector<Tyre> tyres;
  std::vector<Capsule> capsules;
  std::vector<Strand> strands;
  AircraftShadow aircraft;
};

}  // namespace stevedore::world
