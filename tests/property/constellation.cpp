// Marks that all look alike, under a camera that moves, jumps and looks away: which is which, and how far
// from where it is said to be.
#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <random>

#include "tracker_proc/tracker.hpp"

using namespace stevedore;

namespace {

constexpr double kFrame_s = 1.0 / 30;
constexpr double kWidth_px = 640, kHeight_px = 480;
const FrameView kView{{640, 480}, 337, std::nullopt};

using Random = std::mt19937;

double between(Random& random, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(random);
}

Eigen::Vector2d scatter(Random& random, double sigma) {
  std::normal_distribution<double> normal(0, sigma);
  const double u = normal(random);
  return {u, normal(random)};
}

/// Equal marks on a grid of one to three rows: spacing 2.2 to 4 radii, so that none touch.
struct Constellation {
  double radius_px;
  std::vector<Eigen::Vector2d> places_px;

  explicit Constellation(Random& random) : radius_px(between(random, 12, 30)) {
    const int rows = static_cast<int>(between(random, 1, 4)),
              columns = static_cast<int>(between(random, 2, 5));
    const double spacing_px = between(random, 2.2, 4) * radius_px;
    for (int r = 0; r < rows; ++r)
      for (int c = 0; c < columns; ++c)
        places_px.emplace_back(320 + (c - (columns - 1) / 2.0) * spacing_px,
                               240 + (r - (rows - 1) / 2.0) * spacing_px);
  }
};

/// Where the picture stands: velocity changes as a gust would change it, and now and then a frame is missing.
class Camera {
 public:
  explicit Camera(double walk_pxps) : walk_pxps_(walk_pxps) {}
  void move(Random& random, const Eigen::Vector2d& towards_pxps2) {
    velocity_pxps_ += scatter(random, walk_pxps_ * std::sqrt(kFrame_s)) + towards_pxps2 * kFrame_s;
    velocity_pxps_ *= 0.98;
    place_px += velocity_pxps_ * kFrame_s;
  }
  Eigen::Vector2d place_px = Eigen::Vector2d::Zero();

 private:
  double walk_pxps_;
  Eigen::Vector2d velocity_pxps_ = Eigen::Vector2d::Zero();
};

bool in_view(const Eigen::Vector2d& p) {
  return p.x() > 0 && p.y() > 0 && p.x() < kWidth_px && p.y() < kHeight_px;
}

Detection measured(const Eigen::Vector2d& centre, double radius_px, Random& random) {
  const Eigen::Vector2d noise = scatter(random, 0.3), size = scatter(random, 0.2);
  Detection d;
  d.outer.ellipse = normalized({centre.x() + noise.x(), centre.y() + noise.y(), radius_px + size.x(),
                                0.85 * radius_px + size.y(), 0.3});
  d.label = Label::circle;
  return d;
}

/// The film of one constellation, and what the tracker must have made of it.
class Film {
 public:
  explicit Film(unsigned seed) : random_(seed), marks_(random_), camera_(60) {}

  /// pull_pxps2: what draws the camera aside (to leave some marks out of view); chance that a mark is missed.
  void step(const Eigen::Vector2d& pull_pxps2, double missed, double false_ones,
            const std::optional<Eigen::Matrix3d>& turn = std::nullopt) {
    camera_.move(random_, pull_pxps2);
    show(missed, false_ones, turn);
  }

  /// The picture jumps to where all marks are in view as well.
  void jump() {
    Eigen::Vector2d low = marks_.places_px.front(), high = marks_.places_px.back();
    camera_.place_px = {between(random_, -low.x(), kWidth_px - high.x()),
                        between(random_, -low.y(), kHeight_px - high.y())};
    show(0, 0);
  }

  /// The camera turns aside and back, until all marks have left the view; the attitude is told.
  void look_away(int frames) {
    for (int k = 1; k <= frames; ++k) {
      const double step_px = 700 * std::numbers::pi / frames * std::sin(2 * std::numbers::pi * k / frames);
      camera_.place_px.x() += step_px;
      Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
      turn(0, 2) = step_px;  // as far from the axis as the focal length is long: near enough a shift
      step({0, 0}, 0.05, 0, turn);
    }
  }

  int kept = 0;     ///< sightings of a mark that was seen less than two seconds before ...
  int renewed = 0;  ///< ... and has another id now: where nothing tells which one it is, that is right

  [[nodiscard]] const Eigen::Vector2d& camera_px() const { return camera_.place_px; }

 private:
  void show(double missed, double false_ones, const std::optional<Eigen::Matrix3d>& turn = std::nullopt) {
    std::vector<Detection> detections;
    std::vector<int> mark_of;
    for (std::size_t i = 0; i < marks_.places_px.size(); ++i) {
      const Eigen::Vector2d place = marks_.places_px[i] + camera_.place_px;
      if (!in_view(place) || between(random_, 0, 1) < missed) continue;
      detections.push_back(measured(place, marks_.radius_px, random_));
      mark_of.push_back(static_cast<int>(i));
    }
    // upon a mark that is missed nothing could tell a false ellipse from it
    const double false_v = between(random_, 0, kHeight_px), false_u = between(random_, 0, kWidth_px);
    const Eigen::Vector2d false_one(false_u, false_v);
    const bool is_upon_mark =
        std::any_of(marks_.places_px.begin(), marks_.places_px.end(), [&](const Eigen::Vector2d& place) {
          return (place + camera_.place_px - false_one).norm() < 2 * marks_.radius_px;
        });
    if (!is_upon_mark && between(random_, 0, 1) < false_ones) {
      detections.push_back(measured(false_one, marks_.radius_px * between(random_, 0.5, 2), random_));
      mark_of.push_back(-1);
    }
    time_s_ += kFrame_s;
    FrameView view = kView;
    view.turn = turn;
    check(tracker_.step(time_s_, {}, detections, view), mark_of);
  }

  void check(const TrackerResult& result, const std::vector<int>& mark_of) {
    for (const Track& track : result.tracks) {
      if (track.detection_index < 0) continue;
      const int mark = mark_of[static_cast<std::size_t>(track.detection_index)];
      if (mark < 0) continue;
      INFO("mark " << mark << " at " << time_s_ << " s");
      const auto owner = mark_of_id_.emplace(track.id, mark);
      REQUIRE(owner.first->second == mark);  // an id is never another mark's
      const auto last = last_seen_.find(mark);
      if (last != last_seen_.end() && time_s_ - last->second.time_s < 1.9) {
        ++kept;
        renewed += last->second.id != track.id;
      }
      last_seen_[mark] = {track.id, time_s_};
    }
  }

  struct Seen {
    std::int64_t id;
    double time_s;
  };

  Random random_;
  Constellation marks_;
  Camera camera_;
  Tracker tracker_{TrackerSettings{}};
  double time_s_ = 0;
  std::map<std::int64_t, int> mark_of_id_;
  std::map<int, Seen> last_seen_;
};

constexpr unsigned kFilms = 60;

/// The share of renewed ids over all films.
class Renewals {
 public:
  void add(const Film& film) {
    kept_ += film.kept;
    renewed_ += film.renewed;
  }
  [[nodiscard]] double share() const { return renewed_ / kept_; }

 private:
  double kept_ = 0, renewed_ = 0;
};

}  // namespace

TEST_CASE("identical marks: no id switches with drop-outs and false detections under a restless camera") {
  Renewals renewals;
  for (unsigned seed = 0; seed < kFilms; ++seed) {
    INFO("seed " << seed);
    Film film(seed);
    for (int k = 0; k < 300; ++k) film.step(-film.camera_px(), k < 10 ? 0 : 0.15, k < 10 ? 0 : 0.3);
    renewals.add(film);
  }
  CHECK(renewals.share() <= 0);
}

TEST_CASE("identical marks: a picture that jumps by many radii takes all ids along") {
  Renewals renewals;
  for (unsigned seed = 0; seed < kFilms; ++seed) {
    INFO("seed " << seed);
    Film film(1000 + seed);
    for (int k = 0; k < 200; ++k)
      k % 20 == 19 ? film.jump() : film.step(-film.camera_px(), k < 10 ? 0 : 0.05, 0.1);
    renewals.add(film);
  }
  CHECK(renewals.share() <= 2e-3);
}

TEST_CASE(
    "identical marks: all but a few are covered, or some leave the image and come back, with their ids") {
  Renewals renewals;
  for (unsigned seed = 0; seed < kFilms; ++seed) {
    INFO("seed " << seed);
    Film film(2000 + seed);
    const double aside = seed % 2 == 0 ? 400 : -400;
    for (int k = 0; k < 360; ++k) {
      const bool away = k % 120 > 60 && k % 120 < 80;
      const bool covered = k % 120 > 30 && k % 120 < 50;
      const Eigen::Vector2d pull = away ? Eigen::Vector2d(aside, 0) : Eigen::Vector2d(-4 * film.camera_px());
      film.step(pull, covered ? 0.8 : 0.02, 0.1);
    }
    renewals.add(film);
  }
  CHECK(renewals.share() <= 1e-3);
}

TEST_CASE(
    "identical marks: the camera looks away for a second, is told how it turned, and knows them again") {
  Renewals renewals;
  for (unsigned seed = 0; seed < kFilms; ++seed) {
    INFO("seed " << seed);
    Film film(3000 + seed);
    for (int k = 0; k < 60; ++k) film.step(-film.camera_px(), k < 10 ? 0 : 0.05, 0);
    film.look_away(50);
    for (int k = 0; k < 30; ++k) film.step(-film.camera_px(), 0.05, 0);
    renewals.add(film);
  }
  CHECK(renewals.share() <= 1e-3);
}

TEST_CASE("predicted places: the covariance is honest, and grows") {
  double sum = 0, outside = 0;
  int count = 0;
  for (unsigned seed = 0; seed < 300; ++seed) {
    Random random(seed);
    const TrackerSettings settings;
    const double radius = 20, step = std::sqrt(kFrame_s);
    Eigen::Vector2d camera_velocity = Eigen::Vector2d::Zero(), velocities[3];
    Eigen::Vector2d places[3] = {{200, 200}, {320, 240}, {400, 300}};
    for (auto& v : velocities) v = scatter(random, 20);
    Tracker tracker{settings};
    double first = 0;
    for (int k = 0; k < 50; ++k) {
      camera_velocity += scatter(random, settings.camera_unrest_radps * kView.focal_px * step);
      std::vector<Detection> detections;
      for (int i = 0; i < 3; ++i) {
        velocities[i] += scatter(random, settings.mark_unrest_radiips * radius * step);
        places[i] += (velocities[i] + camera_velocity) * kFrame_s;
        const bool hidden = k >= 30 && (i == 0 || seed % 2 == 0);  // one alone, or all of them
        if (!hidden) detections.push_back(measured(places[i], radius, random));
      }
      const auto result = tracker.step(k * kFrame_s, {}, detections, kView);
      for (const Track& track : result.tracks) {
        if (track.id != 1 || track.detection_index >= 0) continue;
        CHECK(track.unseen_s == Approx((k - 29) * kFrame_s));
        const Ellipse& e = track.detection.outer.ellipse;
        const Eigen::Matrix2d c = track.detection.outer.covariance.topLeftCorner<2, 2>();
        const Eigen::Vector2d off = places[0] - Eigen::Vector2d(e.u_px, e.v_px);
        const double nees = off.dot(c.ldlt().solve(off));
        if (k == 30) first = c.trace();
        if (k == 49) CHECK(c.trace() > first);
        sum += nees;
        outside += nees > 5.99;  // 95 % of chi-squared with two degrees of freedom
        ++count;
      }
    }
  }
  REQUIRE(count == 300 * 20);
  CHECK(sum / count / 2 > 0.7);
  CHECK(sum / count / 2 < 1.4);
  CHECK(outside / count < 0.11);  // 5 % if all were normal and nothing shared
}
