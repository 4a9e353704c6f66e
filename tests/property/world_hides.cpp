// What rays meet first is what the picture shows: each kind of thing in a colour of its own.
#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <opencv2/core.hpp>

#include "sim_proc/world/dice.hpp"
#include "sim_proc/world/ray.hpp"
#include "sim_proc/world/renderer.hpp"
#include "tools/stills.hpp"

using namespace stevedore;
using namespace stevedore::world;

namespace {

Surface flat(float red, float green, float blue) {
  Surface surface;
  surface.colour = {red, green, blue};
  surface.grain = 0;
  return surface;
}

/// Even light, sharp, still; the ground black, decks blue, buckets red, tyres green, people yellow.
Scene coloured(Scene scene) {
  scene.light.sun = {0, 0, 0};
  scene.light.sky = {1, 1, 1};
  scene.eye.blur_sigma_px = 0;
  scene.eye.noise_levels = 0;
  scene.eye.exposure_s = 0;
  scene.eye.gain = 1;
  scene.surroundings = {};
  scene.surroundings.kind = Surroundings::Kind::grass;
  scene.surroundings.surface = flat(0, 0, 0);
  for (Deck& deck : scene.decks) {
    deck.marks.clear();
    deck.ground = flat(0, 0, 1);
  }
  for (Bucket& bucket : scene.buckets) bucket.outside = bucket.inside = flat(1, 0, 0);
  for (Tyre& tyre : scene.tyres) tyre.rubber = flat(0, 1, 0);
  for (Capsule& capsule : scene.capsules) capsule.surface = flat(1, 1, 0);
  scene.strands.clear();
  return scene;
}

Hit::What shown(const cv::Vec3b& bgr) {
  const bool red = bgr[2] > 8, green = bgr[1] > 8, blue = bgr[0] > 8;
  if (red && green) return Hit::What::capsule;
  if (red) return Hit::What::bucket;
  if (green) return Hit::What::tyre;
  return blue ? Hit::What::deck : Hit::What::surroundings;
}

}  // namespace

TEST_CASE("what a ray meets first is what its pixel shows") {
  CameraModel lens;
  lens.given = lens.rectified = {320, 240, 168, 168, 159.5, 119.5};
  lens.response = {Response::Curve::linear, 1};
  const StillCamera camera{lens, lens, 0.5};
  Renderer renderer(2);
  Dice dice(1, "pixels");
  int compared = 0, differ = 0;
  std::array<int, 6> met{};
  for (int number = 0; number < 30; ++number) {
    Scene scene = coloured(draw_still(camera, 3, number).scene);
    for (Bucket& bucket : scene.buckets) bucket.handle_rise_m = 0.001;
    const cv::Mat picture = renderer.render(scene);
    const auto what_at = [&](double u, double v) {
      const Eigen::Vector3d ray = scene.eye.rigid.ned_from_local * lens.given.unproject({u, v});
      const auto hit = first_hit(scene, scene.eye.rigid.position_ned_m, ray.normalized());
      return hit ? hit->what : Hit::What::surroundings;
    };
    for (int i = 0; i < 1500; ++i) {
      const int u = dice.whole(1, 318), v = dice.whole(1, 238);
      const Hit::What what = what_at(u, v);
      bool on_an_edge = false;
      for (const auto& [du, dv] : {std::pair(-1, 0), {1, 0}, {0, -1}, {0, 1}})
        on_an_edge = on_an_edge || what_at(u + du, v + dv) != what;
      if (on_an_edge) continue;
      ++compared;
      ++met[static_cast<size_t>(what)];
      differ += shown(picture.at<cv::Vec3b>(v, u)) != what;
    }
  }
  INFO(differ << " of " << compared);
  REQUIRE(compared > 30000);
  for (const auto what : {Hit::What::deck, Hit::What::bucket, Hit::What::tyre, Hit::What::capsule})
    CHECK(met[static_cast<size_t>(what)] > 20);
  // handles, drawn grey in the picture, and people's limbs that pass through each other
  CHECK(differ < compared / 1000);
}
