// The platforms' estimator over whole flights with every error that the sensors have: 20 seeds, sea state 3.
#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <vector>

#include "tests/support/platform_world.hpp"

using namespace stevedore;
using namespace stevedore::test;

namespace {

constexpr int seeds = 20;

/// A value that goes evenly from point to point in time.
double on_line(double t_s, const std::vector<std::pair<double, double>>& points) {
  if (t_s <= points.front().first) return points.front().second;
  for (std::size_t i = 1; i < points.size(); ++i)
    if (t_s < points[i].first)
      return std::lerp(points[i - 1].second, points[i].second,
                       (t_s - points[i - 1].first) / (points[i].first - points[i - 1].first));
  return points.back().second;
}

/// Down over the first platform, up and over to the second, down, and back to the first.
constexpr double tour_s = 96;
Station tour(double t_s) {
  Station station;
  station.height_m = on_line(
      t_s, {{6, 12}, {14, 3}, {26, 3}, {32, 12}, {44, 12}, {52, 5}, {60, 5}, {66, 12}, {78, 12}, {86, 4}});
  station.over = on_line(t_s, {{32, 0}, {44, 1}, {66, 1}, {78, 0}});
  return station;
}

WorldOptions options_of(int seed) {
  WorldOptions options;
  options.seed = static_cast<std::uint64_t>(seed);
  options.manner = static_cast<Manner>(seed % 3);
  options.row = seed % 2 == 1;
  return options;
}

bool in_view(const PlatformEstimate& estimate) {
  return std::any_of(estimate.slots.begin(), estimate.slots.end(),
                     [&](const SlotEstimate& s) { return s.seen_utime == estimate.utime; });
}

/// Slots of a deck in view that lie elsewhere than the slots of those numbers do.
int slot_errors(const PlatformEstimate& estimate, const PlatformWorld& world) {
  int errors = 0;
  for (std::size_t i = 0; i < estimate.slots.size(); ++i) {
    const Eigen::Vector3d off_m = estimate.slots[i].center_ned_m - world.position_bias_m() -
                                  world.slot_ned_m(estimate.platform, i, world.time_s());
    errors += estimate.slots[i].seen_utime == estimate.utime && off_m.norm() > 0.8;
  }
  return errors;
}

/// Runs a flight and shows every estimate, with how long its platform has been in view without a second's
/// gap.
template <class StationAt, class Visit>
void fly(PlatformWorld& world, PlatformEstimator& estimator, double duration_s, StationAt station_at,
         Visit visit) {
  std::array<double, 2> since_s{-1, -1}, seen_s{-9, -9};
  while (world.time_s() < duration_s) {
    for (const PlatformEstimate& estimate : world.next_frame(estimator, station_at)) {
      const auto p = static_cast<std::size_t>(estimate.platform);
      const double now_s = world.time_s();
      if (in_view(estimate)) {
        if (now_s - seen_s[p] > 1) since_s[p] = now_s;
        seen_s[p] = now_s;
      }
      visit(estimate, now_s - seen_s[p] < 1 ? now_s - since_s[p] : 0.0);
    }
  }
}

struct Rms {
  double squares = 0;
  double n = 0;
  void add(const Eigen::Vector3d& error) {
    squares += error.squaredNorm();
    ++n;
  }
  [[nodiscard]] double value() const { return std::sqrt(squares / n); }
};

}  // namespace

TEST_CASE("20 flights over both platforms: no slot is mistaken while identity is certain") {
  int errors = 0, wrong_states = 0, states = 0;
  double certain = 0, views = 0;
  Rms velocity_mps, position_m, predicted_m, held_m;
  for (int seed = 1; seed <= seeds; ++seed) {
    PlatformWorld world(options_of(seed));
    PlatformEstimator estimator{PlatformSettings{}};
    fly(world, estimator, tour_s, tour, [&](const PlatformEstimate& e, double in_view_s) {
      if (!in_view(e)) return;
      ++views;
      certain += e.identity_certain;
      if (e.identity_certain) errors += slot_errors(e, world);
      const double t_s = world.time_s();
      if (in_view_s < 3 || tour(t_s).height_m > 6) return;
      const DeckTruth truth = world.deck(e.platform, t_s);
      const Eigen::Vector3d bias_m = world.position_bias_m();
      velocity_mps.add(e.velocity_ned_mps - truth.velocity_mps);
      position_m.add(e.center_ned_m - bias_m - truth.center_m);
      const Eigen::Vector3d later_m = world.deck(e.platform, t_s + 1).center_m + bias_m;
      predicted_m.add(e.predictions[1].center_ned_m - later_m);
      held_m.add(e.center_ned_m - later_m);
      for (std::size_t i = 0; i < e.slots.size() && e.identity_certain; ++i) {
        if (e.slots[i].state == SlotState::unknown) continue;
        ++states;
        wrong_states += (e.slots[i].state == SlotState::occupied) !=
                        world.occupied[static_cast<std::size_t>(e.platform)][i];
      }
    });
  }
  WARN("certain " << certain / views << " of the frames in view; below 6 m: velocity rms "
                  << velocity_mps.value() << " m/s, position " << position_m.value() << " m; a second ahead "
                  << predicted_m.value() << " m, held " << held_m.value() << " m; slot states wrong "
                  << wrong_states << " of " << states);
  CHECK(errors == 0);
  CHECK(certain / views > 0.9);
  CHECK(velocity_mps.value() < 0.05);
  CHECK(predicted_m.value() < 0.2 * held_m.value());
  CHECK(wrong_states < 0.002 * states);
}

TEST_CASE("the covariance is honest: NEES and NIS over all flights") {
  double nees = 0, relative_n = 0, nis = 0, nis_n = 0, beyond = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    PlatformWorld world(options_of(seed));
    PlatformEstimator estimator{PlatformSettings{}};
    fly(world, estimator, 30, tour, [&](const PlatformEstimate& e, double in_view_s) {
      if (e.platform != 0 || in_view_s < 3) return;
      const DeckTruth truth = world.deck(0, world.time_s());
      Eigen::Matrix<double, 6, 1> error;
      error << e.center_ned_m - world.position_bias_m() - truth.center_m,
          e.velocity_ned_mps - truth.velocity_mps;
      const double squares = error.dot(e.covariance.ldlt().solve(error));
      nees += squares / 6;
      beyond += squares > 12.59;  // chi-square of six, 95 %
      ++relative_n;
      const Nis& last = estimator.track(0)->filter().last_nis();
      if (last.numbers < numbers_per_circle + 1) return;
      nis += last.value;
      nis_n += static_cast<double>(last.numbers);
    });
  }
  WARN("NEES/6 " << nees / relative_n << ", beyond the 95 % ellipsoid " << beyond / relative_n << ", NIS/n "
                 << nis / nis_n);
  CHECK(nees / relative_n > 0.5);
  CHECK(nees / relative_n < 1.25);
  CHECK(beyond / relative_n < 0.08);
  CHECK(nis / nis_n > 0.4);  // paint is laid out better here than the filter trusts it to be
  CHECK(nis / nis_n < 1.1);
}

TEST_CASE("out of view for up to a minute: platforms and slots are found again, none mistaken") {
  int errors = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    PlatformWorld world(options_of(seed));
    PlatformEstimator estimator{PlatformSettings{}};
    const auto high = [](double) { return Station{0, Eigen::Vector2d::Zero(), 8}; };
    double blind_from_s = 8, blind_s = 2 + 3 * seed, found_s = -1;
    while (world.time_s() < blind_from_s + blind_s + 5) {
      world.blind = world.time_s() > blind_from_s && world.time_s() < blind_from_s + blind_s;
      world.mute_reports = seed % 4 == 0 && world.blind;  // some are not told either
      for (const PlatformEstimate& e : world.next_frame(estimator, high)) {
        if (e.identity_certain && in_view(e)) errors += slot_errors(e, world);
        if (world.time_s() > blind_from_s + blind_s && found_s < 0 && e.platform == 0 && in_view(e))
          found_s = world.time_s() - blind_from_s - blind_s;
      }
    }
    INFO("seed " << seed << " found after " << found_s);
    CHECK(found_s >= 0);
    CHECK(found_s < 2);
  }
  CHECK(errors == 0);
}

TEST_CASE("platforms that never speak are followed all the same, and said to be uncertain") {
  Rms velocity_mps;
  for (int seed = 1; seed <= 6; ++seed) {
    WorldOptions options = options_of(seed);
    options.silent = true;
    PlatformWorld world(options);
    PlatformEstimator estimator{PlatformSettings{}};
    int estimates = 0;
    fly(world, estimator, 26, tour, [&](const PlatformEstimate& e, double in_view_s) {
      CHECK_FALSE(e.identity_certain);
      ++estimates;
      const std::size_t true_platform =
          (e.center_ned_m - world.position_bias_m() - world.deck(0, world.time_s()).center_m).norm() < 7 ? 0
                                                                                                         : 1;
      if (in_view_s > 3 && tour(world.time_s()).height_m < 6)
        velocity_mps.add(e.velocity_ned_mps -
                         world.deck(static_cast<int>(true_platform), world.time_s()).velocity_mps);
    });
    CHECK(estimates > 300);
  }
  CHECK(velocity_mps.value() < 0.06);
}

TEST_CASE("a platform that speaks up late makes identity certain, with the right numbers") {
  for (int seed = 1; seed <= 8; ++seed) {
    PlatformWorld world(options_of(seed));
    PlatformEstimator estimator{PlatformSettings{}};
    int errors = 0, certain = 0;
    const auto second = [](double) {
      return Station{1, Eigen::Vector2d::Zero(), 8};
    };  // found first: number 0
    while (world.time_s() < 20) {
      world.mute_reports = world.time_s() < 10;
      for (const PlatformEstimate& e : world.next_frame(estimator, second)) {
        if (world.time_s() < 10) CHECK_FALSE(e.identity_certain);
        if (!e.identity_certain || !in_view(e)) continue;
        ++certain;
        errors += slot_errors(e, world) + (e.platform != 1);
      }
    }
    INFO("seed " << seed);
    CHECK(errors == 0);
    CHECK(certain > 60);
  }
}

TEST_CASE("platforms get other numbers by reports in a row only, and not by one now and then") {
  const bool in_a_row = GENERATE(false, true);
  PlatformWorld world(options_of(1));
  PlatformEstimator estimator{PlatformSettings{}};
  double next_s = 10;
  int number = -1;
  while (world.time_s() < 14) {
    world.mute_reports = world.time_s() > 9;
    for (const PlatformEstimate& e : world.next_frame(estimator, [](double) {
           return Station{0, {0, 0}, 8};
         })) {
      if (!in_view(e)) continue;
      number = e.platform;
      if (world.time_s() < next_s) continue;
      next_s += 1;
      PlatformReport mistaken{e.utime, 1, e.center_ned_m, Eigen::Vector3d::Zero(), 0};
      estimator.add_report(mistaken);
      mistaken.position_ned_m.x() += 40;
      if (!in_a_row) estimator.add_report(mistaken);
    }
  }
  CHECK(number == (in_a_row ? 1 : 0));
}

TEST_CASE("many false circles, wrong labels and lost frames don't move the deck") {
  Rms velocity_mps;
  int errors = 0;
  for (int seed = 1; seed <= 8; ++seed) {
    WorldOptions options = options_of(seed);
    options.false_circles = 0.9;
    options.missed = 0.4;
    options.wrong_first = 0.2;
    options.frame_rate_hz = 10;
    PlatformWorld world(options);
    PlatformEstimator estimator{PlatformSettings{}};
    fly(world, estimator, 26, tour, [&](const PlatformEstimate& e, double in_view_s) {
      if (e.platform != 0 || !in_view(e)) return;
      if (e.identity_certain) errors += slot_errors(e, world);
      if (in_view_s > 3 && tour(world.time_s()).height_m < 6)
        velocity_mps.add(e.velocity_ned_mps - world.deck(0, world.time_s()).velocity_mps);
    });
  }
  WARN("velocity rms " << velocity_mps.value());
  CHECK(errors == 0);
  CHECK(velocity_mps.value() < 0.08);
}

TEST_CASE(
    "a minute unseen and unheard of: the heading is lost, which is said until the platform speaks again") {
  int errors = 0;
  for (int seed = 1; seed <= 8; ++seed) {
    WorldOptions options = options_of(seed);
    options.manner = Manner::turning;
    PlatformWorld world(options);
    PlatformEstimator estimator{PlatformSettings{}};
    int certain_before = 0, certain_too_soon = 0, certain_after = 0;
    while (world.time_s() < 85) {
      world.blind = world.time_s() > 10 && world.time_s() < 70;
      world.mute_reports = world.time_s() > 10 && world.time_s() < 75;
      for (const PlatformEstimate& e : world.next_frame(estimator, [](double) {
             return Station{0, {0, 0}, 8};
           })) {
        if (e.platform != 0) continue;
        if (world.time_s() > 60 && world.time_s() < 75) certain_too_soon += e.identity_certain;
        if (!in_view(e)) continue;
        if (e.identity_certain) errors += slot_errors(e, world);
        (world.time_s() < 60 ? certain_before : certain_after) += e.identity_certain;
      }
    }
    INFO("seed " << seed);
    CHECK(certain_before > 100);
    CHECK(certain_too_soon == 0);
    CHECK(certain_after > 50);
  }
  CHECK(errors == 0);
}
