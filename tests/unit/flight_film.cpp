#include "tools/flight_film.hpp"

#include <Eigen/Geometry>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "sim_proc/world/renderer.hpp"

using namespace stevedore;
using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

world::WorldSettings settings(std::uint64_t seed) {
  world::WorldSettings settings;
  settings.seed = seed;
  settings.camera.given = settings.camera.rectified = {160, 120, 84, 84, 79.5, 59.5};
  return settings;
}

nlohmann::ordered_json line_of(const FilmFrame& frame) {
  return truth_of(frame, "f.png", "camera.yaml");
}

Vector3d vector_of(const nlohmann::ordered_json& json) {
  return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
}

Eigen::Quaterniond turn_of(const nlohmann::ordered_json& json) {
  return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>(), json[3].get<double>()};
}

/// Contrast across the outline, at this distance outwards, mean over its circumference.
double contrast_at(const cv::Mat& levels, const Ellipse& outline, double outwards_px) {
  constexpr int points = 180;
  cv::Mat at(2, points, CV_32FC2), seen;
  for (int i = 0; i < points; ++i) {
    const double angle = 2 * std::numbers::pi * i / points;
    const Vector2d along = point_at(outline, angle + 1e-4) - point_at(outline, angle - 1e-4);
    const Vector2d outwards = Vector2d(along.y(), -along.x()).normalized();
    for (int side = 0; side < 2; ++side) {
      const Vector2d px = point_at(outline, angle) + (outwards_px + side - 0.5) * outwards;
      at.at<cv::Vec2f>(side, i) = {static_cast<float>(px.x()), static_cast<float>(px.y())};
    }
  }
  cv::remap(levels, seen, at, cv::noArray(), cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  cv::Mat steps;
  cv::absdiff(seen.row(0), seen.row(1), steps);
  const cv::Scalar mean = cv::mean(steps);
  return mean[0] + mean[1] + mean[2];
}

/// Where, within 3 px, there is most contrast across the outline: outwards, px.
double edge_off_px(const cv::Mat& picture, const Ellipse& outline) {
  cv::Mat levels;
  picture.convertTo(levels, CV_32F);
  constexpr double step_px = 0.1;
  double best_px = 0, most = 0;
  for (double off_px = -3; off_px <= 3; off_px += step_px) {
    const double contrast = contrast_at(levels, outline, off_px);
    if (contrast <= most) continue;
    most = contrast;
    best_px = off_px;
  }
  return best_px;
}

}  // namespace

TEST_CASE("a film depends on its seed alone") {
  FlightFilm a(settings(3), 10, 0), b(settings(3), 10, 0), other(settings(4), 10, 0);
  nlohmann::ordered_json last_a, last_other;
  for (int i = 0; i < 30; ++i) {
    last_a = line_of(a.next());
    CHECK(last_a == line_of(b.next()));
    last_other = line_of(other.next());
  }
  CHECK(last_a != last_other);
}

TEST_CASE("a film begins where it is asked to, at its rate, and what was flown before is the same flight") {
  FlightFilm whole(settings(3), 5, 0), late(settings(3), 5, 2);
  FilmFrame frame;
  for (int i = 0; i <= 10; ++i) {
    frame = whole.next();
    CHECK(frame.time_s == Approx(0.2 * i).margin(world::World::step_s + 1e-9));
    CHECK(frame.time_s >= 0.2 * i - 1e-9);
  }
  const FilmFrame first = late.next();
  CHECK(first.time_s == Approx(2));
  CHECK(first.truth.camera.position_ned_m == frame.truth.camera.position_ned_m);
  CHECK(first.stamp_s != first.time_s);
  CHECK(std::abs(first.stamp_s - first.time_s) < 0.03);  // six times the 5 ms that are drawn
}

TEST_CASE("a film flies from the pad to over a platform, with the camera level and the readings at hand") {
  FlightFilm film(settings(3), 2, 0);
  double highest_m = 0;
  bool over_platform = false;
  for (int i = 0; i < 80; ++i) {
    const auto line = line_of(film.next());
    highest_m = std::max(highest_m, -line.at("aircraft_ned")[2].get<double>());
    for (const char* list : {"ellipses", "hidden"})  // from 12 m they are a few of these small pixels
      for (const auto& e : line.at(list)) over_platform = over_platform || e.at("platform") < 2;
    if (i < 4) continue;
    CHECK(line.at("gravity")[2] > std::cos(0.06));  // 3.4 deg: attitude, mount and lag together
    CHECK_FALSE(line.at("vehicle").is_null());
    CHECK_FALSE(line.at("gimbal").is_null());
    CHECK_FALSE(line.at("altimeter").is_null());
    CHECK_FALSE(line.at("hook").is_null());
  }
  CHECK(highest_m == Approx(12).margin(2));
  CHECK(over_platform);
}

TEST_CASE("films of one seed have the same pictures and lines, to the byte") {
  FlightFilm a(settings(3), 5, 0), b(settings(3), 5, 0);
  world::Renderer one(1), two(2);
  for (int i = 0; i < 8; ++i) {
    const FilmFrame frame_a = a.next(), frame_b = b.next();
    CHECK(line_of(frame_a).dump() == line_of(frame_b).dump());
    CHECK(cv::norm(one.render(frame_a.still.scene), two.render(frame_b.still.scene), cv::NORM_INF) == 0);
  }
}

TEST_CASE("a film's camera, circles and platforms belong together: a circle stays where it is painted") {
  FlightFilm film(settings(5), 2, 25);
  std::map<std::pair<int, int>, Vector3d> painted_m;
  int seen = 0;
  for (int i = 0; i < 30; ++i) {
    const auto line = line_of(film.next());
    for (const char* list : {"ellipses", "hidden"})
      for (const auto& circle : line.at(list)) {
        const int deck = circle.at("platform");
        if (deck > 1) continue;  // the pad is no platform
        const auto& platform = line.at("platforms")[static_cast<size_t>(deck)];
        const Vector3d center_ned_m = vector_of(line.at("camera_ned")) +
                                      turn_of(line.at("ned_from_camera")) * vector_of(circle.at("center"));
        const Vector3d on_deck_m = turn_of(platform.at("ned_from_platform")).conjugate() *
                                   (center_ned_m - vector_of(platform.at("position_ned")));
        const auto& first_m = painted_m.try_emplace({deck, circle.at("slot")}, on_deck_m).first->second;
        CHECK((on_deck_m - first_m).norm() < 1e-9);
        CHECK(std::abs(on_deck_m.z()) < 1e-9);
        ++seen;
      }
  }
  CHECK(painted_m.size() >= 4);
  CHECK(seen > 30);
}

TEST_CASE("in a film's pictures the edges are where its truth says") {
  world::WorldSettings large = settings(3);
  large.camera.given = large.camera.rectified = {640, 480, 337, 337, 319.5, 239.5};
  FlightFilm film(large, 1, 97);  // a descent
  world::Renderer renderer(2);
  int outlines = 0;
  for (int i = 0; i < 10; ++i) {
    FilmFrame frame = film.next();
    frame.still.scene.eye.noise_levels = 0;
    const cv::Mat picture = renderer.render(frame.still.scene);
    const auto line = line_of(frame);
    for (const auto& e : line.at("ellipses")) {
      if (e.at("whole") == false || e.at("b") < 15) continue;
      ++outlines;
      INFO("frame " << i << ": " << e.dump());
      CHECK(std::abs(edge_off_px(picture, {e.at("u"), e.at("v"), e.at("a"), e.at("b"), e.at("alpha")})) <
            0.25);
    }
  }
  CHECK(outlines >= 20);
}
