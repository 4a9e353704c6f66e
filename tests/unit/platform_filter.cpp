// The deck's motion and measurement models against numbers worked out otherwise, late measurements against
// the same in order, and the aircraft's history.
#include <Eigen/Dense>
#include <Eigen/Eigenvalues>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>

#include "geometry/vehicle_history.hpp"
#include "platform/deck_filter.hpp"
#include "platform/deck_outlook.hpp"

using namespace stevedore;
using std::numbers::pi;

namespace {

constexpr std::int64_t second_us = 1'000'000;

DeckVector some_state() {
  DeckVector mean = DeckVector::Zero();
  mean.head<at::course_size>() << 3, -2, 0.9, -0.4, 0.1, 0.2, 0.7, 0.08;
  mean[at::down] = -0.8;
  for (Eigen::Index i = at::heave; i < at::attitude_error; ++i)
    mean[i] = 0.03 * std::sin(static_cast<double>(i));
  mean.segment<3>(at::attitude_error) << 0.01, -0.006, 0.004;
  mean[at::scale_error] = 0.004;
  mean[at::layout_error] = -0.01;
  return mean;
}

DeckSight some_sight(std::int64_t utime, const DeckVector& mean, std::mt19937& random) {
  std::normal_distribution<double> noise(0, 0.01);
  DeckSight sight{utime, {2, -3, -6}, 1e-5, {}, {}};
  for (const Eigen::Vector2d& place_m :
       {Eigen::Vector2d(0.8, -0.8), Eigen::Vector2d(0.8, 0.8), Eigen::Vector2d(-0.8, 0.8)}) {
    const CircleNumbers expected = expected_circle(mean, place_m, sight.aircraft_odometry_m).value;
    CircleView view{
        expected.head<3>(), Eigen::Matrix3d::Identity() * 1e-4, {expected[3], expected[4], -1}, 1e-4};
    for (const Eigen::Index i : {2, 1, 0}) view.from_aircraft_ned_m[i] += noise(random);
    view.normal_ned.normalize();
    sight.places_m.push_back(place_m);
    sight.circles.push_back(view);
  }
  return sight;
}

/// A deck known to a metre and ten degrees.
DeckState rough_state(const DeckMotion& motion) {
  DeckState state = motion.unknown();
  state.mean[at::down] = -0.8;
  state.mean.head<2>() << 3, -2;
  state.mean[at::heading] = 0.7;
  for (const Eigen::Index i : {at::north, at::east, at::down}) state.covariance(i, i) = 1;
  state.covariance(at::heading, at::heading) = 0.03;
  return state;
}

}  // namespace

TEST_CASE("what is expected of a circle has the derivatives that it says it has") {
  const Eigen::Vector2d place_m(0.8, -0.7);
  const Eigen::Vector3d aircraft_m(2, -3, -6);
  const DeckVector mean = some_state();
  const ExpectedCircle circle = expected_circle(mean, place_m, aircraft_m);
  constexpr double h = 1e-6;
  for (Eigen::Index i = 0; i < at::size; ++i) {
    DeckVector up = mean, down = mean;
    up[i] += h;
    down[i] -= h;
    const CircleNumbers slope =
        (expected_circle(up, place_m, aircraft_m).value - expected_circle(down, place_m, aircraft_m).value) /
        (2 * h);
    INFO("state " << i);
    // products of the errors, which are small, are left out
    CHECK((slope - circle.by_state.col(i)).norm() < 0.02 * (1 + slope.norm()));
  }
}

TEST_CASE("a level deck, looked at by hand") {
  DeckVector mean = DeckVector::Zero();
  mean[at::north] = 10;
  mean[at::down] = -1;
  mean[at::heading] = pi / 2;  // its front is east
  const ExpectedCircle circle = expected_circle(mean, {2, 1}, {10, 0, -7});
  CHECK((circle.value.head<3>() - Eigen::Vector3d(-1, 2, 6)).norm() < 1e-12);
  CHECK(circle.value.tail<2>().norm() < 1e-12);
  mean[at::roll] = 0.1;  // right side down: the normal leans to the right, which is south
  CHECK(deck_normal(mean).value.x() == Approx(-std::sin(0.1)));
  CHECK((place_on_deck(mean, {0, 1}).value - Eigen::Vector3d(10 - std::cos(0.1), 0, -1 + std::sin(0.1)))
            .norm() < 1e-12);
}

TEST_CASE("a deck that turns is predicted along its circle, steps don't matter") {
  const DeckMotion motion{PlatformSettings{}};
  DeckState state;
  state.mean[at::velocity_north] = 1.5;
  state.mean[at::turn_rate] = 0.1;
  const DeckState ahead = motion.predicted(state, 2, {});
  const double angle_rad = 0.1 * 20 * (1 - std::exp(-2.0 / 20));  // a turn rate fades
  CHECK(ahead.mean[at::heading] == Approx(angle_rad).epsilon(1e-3));
  CHECK(ahead.mean[at::north] == Approx(3 * std::sin(angle_rad) / angle_rad).epsilon(0.01));
  CHECK(ahead.mean[at::east] == Approx(3 * (1 - std::cos(angle_rad)) / angle_rad).epsilon(0.05));
  const Disturbance disturbance{0.3, 2e-4};
  DeckState once = motion.predicted(motion.unknown(), 1.2, disturbance), often = motion.unknown();
  for (int i = 0; i < 12; ++i) often = motion.predicted(often, 0.1, disturbance);
  CHECK((once.covariance - often.covariance).norm() < 0.02 * often.covariance.norm());
}

TEST_CASE("waves keep their size when left alone, and a wave of 6 s is followed between the two kept") {
  const DeckMotion motion{PlatformSettings{}};
  const DeckState later = motion.predicted(motion.unknown(), 30, {});
  const auto block = later.covariance.block<4, 4>(at::heave, at::heave);
  CHECK(block(0, 0) + block(2, 2) == Approx(0.25 * 0.25).epsilon(1e-6));
  CHECK(std::abs(block(0, 1)) < 1e-9);
}

TEST_CASE("covariances stay symmetric and positive through thousands of updates") {
  const DeckMotion motion{PlatformSettings{}};
  std::mt19937 random(3);
  DeckFilter filter(motion, 0.3, second_us, rough_state(motion));
  DeckVector truth = rough_state(motion).mean;
  for (int i = 1; i <= 3000; ++i) {
    const std::int64_t utime = second_us + i * 66'000;
    REQUIRE(filter.add(some_sight(utime, truth, random)) == Verdict::used);
  }
  const DeckState state = filter.at_time(filter.newest_utime());
  CHECK((state.covariance - state.covariance.transpose()).norm() < 1e-9);
  CHECK(Eigen::SelfAdjointEigenSolver<DeckMatrix>(state.covariance).eigenvalues().minCoeff() > -1e-10);
  const Eigen::Vector2d velocity = state.mean.segment<2>(at::velocity_north);  // the deck lies still
  const Eigen::Matrix2d expected = state.covariance.block<2, 2>(at::velocity_north, at::velocity_north);
  CHECK(expected.trace() < 2 * 0.05 * 0.05);
  CHECK(velocity.dot(expected.inverse() * velocity) < 13.8);  // one in a thousand is above
}

TEST_CASE("measurements that come late are as good as in order, twice is once, too late is refused") {
  const DeckMotion motion{PlatformSettings{}};
  std::mt19937 random(4);
  const DeckState start = rough_state(motion);
  std::vector<DeckSight> sights;
  for (int i = 1; i <= 20; ++i) sights.push_back(some_sight(second_us + i * 50'000, start.mean, random));
  const DeckReport report{second_us + 330'000, {4, -3}, {0.1, 0}, 0.75};

  DeckFilter in_order(motion, 0.3, second_us, start), late(motion, 0.3, second_us, start);
  for (const DeckSight& sight : sights) {
    if (sight.utime > report.utime && in_order.newest_utime() < report.utime)
      REQUIRE(in_order.add(report) == Verdict::used);
    REQUIRE(in_order.add(sight) == Verdict::used);
  }
  for (std::size_t i = 0; i < sights.size(); i += 2) {
    if (i + 1 < sights.size()) REQUIRE(late.add(sights[i + 1]) == Verdict::used);
    REQUIRE(late.add(sights[i]) == Verdict::used);
    CHECK(late.add(sights[i]) == Verdict::duplicate);
  }
  REQUIRE(late.add(report) == Verdict::used);
  CHECK(late.add(report) == Verdict::duplicate);
  const DeckState a = in_order.at_time(in_order.newest_utime()), b = late.at_time(late.newest_utime());
  CHECK((a.mean - b.mean).norm() < 1e-9);
  CHECK((a.covariance - b.covariance).norm() < 1e-9);

  for (int i = 21; i <= 60; ++i) late.add(some_sight(second_us + i * 50'000, start.mean, random));
  CHECK(late.add(some_sight(second_us + 25'000, start.mean, random)) == Verdict::too_late);
}

TEST_CASE("the gate lets good frames pass and stops a deck that jumps") {
  CHECK(gate_of(2) == Approx(18.4).epsilon(0.05));  // chi-square, 1 - 1e-4
  CHECK(gate_of(5) == Approx(25.7).epsilon(0.03));
  CHECK(gate_of(20) == Approx(52.4).epsilon(0.02));
  const DeckMotion motion{PlatformSettings{}};
  std::mt19937 random(5);
  DeckVector truth = rough_state(motion).mean;
  DeckFilter filter(motion, 0.3, second_us, rough_state(motion));
  for (int i = 1; i <= 30; ++i) filter.add(some_sight(second_us + i * 66'000, truth, random));
  const DeckState before = filter.at_time(second_us + 31 * 66'000);
  truth[at::east] += 1;
  CHECK(filter.add(some_sight(second_us + 31 * 66'000, truth, random)) == Verdict::gated);
  CHECK((filter.at_time(second_us + 31 * 66'000).mean - before.mean).norm() < 1e-12);
}

TEST_CASE("a prediction is safe when the deck is slow and level for sure") {
  PlatformSettings settings;
  const DeckMotion motion(settings);
  DeckState calm = motion.unknown();
  CHECK_FALSE(is_safe(calm, settings));  // a sea of state 3, phase unknown
  calm.covariance *= 1e-4;
  CHECK(is_safe(calm, settings));
  DeckState heaving = calm, leaning = calm;
  heaving.mean[at::heave + 1] = 0.35;
  leaning.mean[at::pitch] = 0.12;
  CHECK_FALSE(is_safe(heaving, settings));
  CHECK_FALSE(is_safe(leaning, settings));
  // a quarter of a period later the wave stands still
  const auto predictions = outlook(heaving, motion, {}, settings);
  REQUIRE(predictions.size() == 4);
  CHECK(predictions[0].ahead_s == Approx(0.5));
  CHECK(predictions[1].ahead_s == Approx(1));
  CHECK(predictions[3].ahead_s == Approx(2));
  CHECK_FALSE(predictions[0].safe_to_lower);
  CHECK(predictions[2].safe_to_lower);
}

TEST_CASE("the aircraft's history: odometry from velocity, attitude carried and averaged") {
  VehicleHistory history;
  CHECK_FALSE(history.at(0));
  const Eigen::Vector3d rate_radps(0.2, -0.1, 0.3);
  for (int i = 0; i <= 50; ++i) {
    const double t_s = 0.02 * i;
    VehicleSample sample;
    sample.utime = second_us + i * 20'000;
    sample.position_ned_m << 100 + 2 * t_s + 0.3 * t_s, 0, -5;  // 0.3 m/s of wander in the position
    sample.velocity_ned_mps << 2, 0, 0;
    sample.ned_from_body =
        Eigen::AngleAxisd(rate_radps.norm() * t_s + (i % 2 == 0 ? 0.01 : -0.01), rate_radps.normalized());
    sample.angular_rate_body_radps = rate_radps;
    sample.attitude_variance_rad2 = 2e-4;
    history.add(sample);
    history.add(sample);  // twice
  }
  const auto moment = history.at(second_us + 510'000);
  REQUIRE(moment);
  CHECK(moment->position_odometry_m.x() == Approx(2 * 0.51));
  CHECK((moment->position_odometry_m + moment->ned_from_odometry_m).x() == Approx(100 + 2.3 * 0.51));
  const Eigen::Quaterniond expected(Eigen::AngleAxisd(rate_radps.norm() * 0.51, rate_radps.normalized()));
  CHECK(moment->ned_from_body.angularDistance(expected) < 0.002);  // of 0.01 a sample
  CHECK(moment->attitude_variance_rad2 < 2e-5);
  REQUIRE(history.at(second_us + 1'100'000));
  CHECK(history.at(second_us + 1'100'000)->position_odometry_m.x() == Approx(2.2));
  CHECK_FALSE(history.at(second_us + 1'300'000));
  CHECK_FALSE(history.at(second_us - 1));
}
