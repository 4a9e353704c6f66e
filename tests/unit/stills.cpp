#include "tools/stills.hpp"

#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "runtime/camera_file.hpp"
#include "tools/camera_yaml.hpp"
#include "tools/still_truth.hpp"

using namespace stevedore;

namespace {

CameraModel paper_camera() {
  CameraModel camera;
  camera.given = camera.rectified = {640, 480, 337, 337, 319.5, 239.5};
  return camera;
}

}  // namespace

TEST_CASE("a still depends on seed and number alone, and stays within the heights of the competition") {
  const StillCamera camera = draw_still_camera(paper_camera(), 4, false);
  for (int i = 0; i < 40; ++i) {
    const Still a = draw_still(camera, 4, i), b = draw_still(camera, 4, i);
    CHECK(truth_of(a, "a.png", "c.yaml") == truth_of(b, "a.png", "c.yaml"));
    CHECK(a.height_m >= 1.5);
    CHECK(a.height_m <= 12);
    CHECK(a.circles.size() == 9);
    CHECK(a.cargoes.size() == a.scene.buckets.size());
  }
  CHECK(draw_still(camera, 4, 0).height_m != draw_still(camera, 4, 1).height_m);
  CHECK(draw_still(camera, 4, 0).height_m != draw_still(camera, 5, 0).height_m);
}

TEST_CASE("the real camera is near the told one, exactly it if asked for") {
  const StillCamera exact = draw_still_camera(paper_camera(), 1, true);
  CHECK(exact.real.given.fx_px == 337);
  CHECK(exact.circle_radius_m == 0.5);
  const StillCamera real = draw_still_camera(paper_camera(), 1, false);
  CHECK(real.told.given.fx_px == 337);
  CHECK(real.real.given.fx_px != 337);
  CHECK(real.real.given.fx_px == Approx(337).epsilon(0.015));
  CHECK(real.real.given.cx_px == Approx(319.5).margin(10));
  CHECK(real.circle_radius_m == Approx(0.5).epsilon(0.025));
}

TEST_CASE("truth lists every circle in view once, with a pose that projects onto its ellipse") {
  const StillCamera camera = draw_still_camera(paper_camera(), 2, true);
  int circles = 0, hidden = 0, cut = 0, empty = 0, occupied = 0, cargoes = 0;
  for (int i = 0; i < 60; ++i) {
    const auto truth = truth_of(draw_still(camera, 2, i), "x.png", "camera.yaml");
    CHECK(truth.at("labelled") == true);
    for (const auto& e : truth.at("ellipses")) {
      ++circles;
      const double share = e.at("visible_share"), u = e.at("u"), a = e.at("a"), b = e.at("b");
      CHECK(share >= 0.25);
      CHECK(b >= 4);
      CHECK(e.at("whole") == (share >= 0.98));
      cut += share < 0.98;
      occupied += e.at("occupied") == true;
      const double x = e.at("center")[0], z = e.at("center")[2];
      CHECK(std::abs(u - (319.5 + 337 * x / z)) <
            0.1 * a);  // the centre's image, which is not the ellipse's centre
      CHECK(a == Approx(337 * 0.5 / z).epsilon(0.25));
      CHECK(e.at("normal")[2] < -0.8);
    }
    hidden += static_cast<int>(truth.at("hidden").size());
    cargoes += static_cast<int>(truth.at("cargoes").size());
    empty += truth.at("ellipses").empty();
  }
  CHECK(circles > 100);
  CHECK(cut > circles / 10);
  CHECK(occupied > circles / 5);
  CHECK(hidden > 0);
  CHECK(cargoes > 50);
  CHECK(empty > 0);
  CHECK(empty < 20);
}

TEST_CASE("a camera file that is written is read back the same") {
  CameraModel camera = paper_camera();
  camera.given.fx_px = 302.123456789;
  camera.distortion = Distortion::plumb_bob;
  camera.coefficients = {-0.28, 0.075, 0.0006, -0.0004, 0.001};
  camera.response = {Response::Curve::gamma, 2.2};
  camera.mount.pitch_rad = 0.01;
  const auto path = std::filesystem::temp_directory_path() / "stevedore_camera_yaml_test.yaml";
  std::ofstream(path) << camera_yaml(camera, "test");
  const CameraFile file = load_camera_file(path.string());
  std::filesystem::remove(path);
  CHECK(file.warnings.empty());
  CHECK(file.camera.given.matrix() == camera.given.matrix());
  CHECK(file.camera.rectified.matrix() == camera.rectified.matrix());
  CHECK(file.camera.coefficients == camera.coefficients);
  CHECK(file.camera.response.gamma == 2.2);
  CHECK(file.camera.mount.pitch_rad == Approx(0.01));
}

TEST_CASE("another size shows the same view") {
  const CameraModel large = resized(paper_camera(), 1280, 960);
  CHECK(large.given.fx_px == 674);
  CHECK(large.given.cx_px == 639.5);
  // the left edge of the image, half a pixel before the first centre, looks the same way
  CHECK((-0.5 - large.given.cx_px) / large.given.fx_px == Approx((-0.5 - 319.5) / 337));
}
