// Layouts, how they are found among circles, which circle is which slot, and what is believed of slots.
#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <numbers>
#include <random>

#include "platform/layout_match.hpp"
#include "platform/platform_estimator.hpp"
#include "platform/slot_assignment.hpp"
#include "platform/slot_belief.hpp"
#include "platform/slot_identity.hpp"
#include "platform/slot_layout.hpp"

using namespace stevedore;
using std::numbers::pi;

namespace {

using Circles = std::vector<Eigen::Vector3d>;

/// Where the slots are in the world when the deck is there, turned so, level.
Circles circles_of(const SlotLayout& layout, const Eigen::Vector3d& center_m, double heading_rad) {
  Circles circles_m;
  for (const Eigen::Vector2d& slot_m : layout.slots_m) {
    const Eigen::Vector2d arm_m = Eigen::Rotation2Dd(heading_rad) * slot_m;
    circles_m.emplace_back(center_m + Eigen::Vector3d(arm_m.x(), arm_m.y(), 0));
  }
  return circles_m;
}

constexpr std::int64_t second_us = 1'000'000;

}  // namespace

TEST_CASE("a square repeats every quarter turn, a row every half, an odd layout never") {
  CHECK(square_layout(1.6).period_rad == Approx(pi / 2));
  CHECK(row_layout(1.6).period_rad == Approx(pi));
  CHECK(layout_of({{0, 0}, {2, 0}, {0, 1}}).period_rad == Approx(2 * pi));
  CHECK(square_layout(1.6).spacing_m() == Approx(1.6));
  CHECK(row_layout(1.3).spacing_m() == Approx(1.3));
  // forward left comes to forward right by a quarter turn clockwise
  CHECK(square_layout(1.6).turned(0, 1) == 1);
  CHECK(square_layout(1.6).turned(0, -1) == 3);
  CHECK(row_layout(1.6).turned(0, 1) == 3);
}

TEST_CASE("layouts come from the settings, impossible ones are refused") {
  PlatformSettings settings;
  CHECK(allowed_layouts(settings).size() == 2);
  settings.layout = "row";
  settings.spacing_m = 1.3;
  REQUIRE(allowed_layouts(settings).size() == 1);
  CHECK(allowed_layouts(settings)[0].slots_m[0].x() == Approx(1.95));
  settings.slots = {{1, 0}, {-1, 0}, {0, 2}};
  CHECK(allowed_layouts(settings)[0].size() == 3);
  settings.slots = {{1, 0}, {-1, 0}};  // no deck can be told by two
  CHECK_THROWS_AS(PlatformEstimator(settings), std::invalid_argument);
  settings.slots = {{1, 0}, {-1, 0}, {1, 0.01}};
  CHECK_THROWS_AS(PlatformEstimator(settings), std::invalid_argument);
  settings.slots.assign(9, {});
  for (std::size_t i = 0; i < 9; ++i) settings.slots[i].forward_m = 1.5 * static_cast<double>(i);
  CHECK_THROWS_AS(PlatformEstimator(settings), std::invalid_argument);
}

TEST_CASE("a layout is found among other circles, turned, in any order") {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> angle(-pi, pi), place(-8, 8);
  std::normal_distribution<double> noise(0, 0.03);
  for (int i = 0; i < 50; ++i) {
    const bool square = i % 2 == 0;
    const SlotLayout layout = square ? square_layout(1.6) : row_layout(1.3);
    const double heading_rad = angle(random);
    const double east_m = place(random), north_m = place(random);
    const Eigen::Vector3d center_m(north_m, east_m, -0.8);
    Circles circles_m = circles_of(layout, center_m, heading_rad);
    for (Eigen::Vector3d& c : circles_m)
      for (const Eigen::Index axis : {2, 1, 0}) c[axis] += noise(random);
    circles_m.emplace_back(center_m + Eigen::Vector3d(4, 1.5, 0));
    std::shuffle(circles_m.begin(), circles_m.end(), random);
    for (const bool scalable : {false, true}) {
      const auto matches =
          match_layout(scalable ? (square ? square_layout(1) : row_layout(1)) : layout, scalable, circles_m);
      REQUIRE(matches.size() == 1);
      CHECK((matches[0].center_m - center_m).norm() < 0.1);
      CHECK(std::abs(std::remainder(matches[0].heading_rad - heading_rad, layout.period_rad)) < 0.06);
      CHECK(matches[0].layout.spacing_m() == Approx(layout.spacing_m()).epsilon(0.05));
      CHECK(matches[0].slots_and_circles.size() == 4);
    }
  }
}

TEST_CASE("three circles of a row may be its front or its back, three of a square are one corner of it") {
  Circles row_m = circles_of(row_layout(1.6), {3, 4, -1}, 0.4),
          square_m = circles_of(square_layout(1.6), {3, 4, -1}, 0.4);
  row_m.pop_back();
  square_m.pop_back();
  CHECK(match_layout(row_layout(1.6), false, row_m).size() == 2);
  const auto corner = match_layout(square_layout(1.6), false, square_m);
  REQUIRE(corner.size() == 1);
  CHECK((corner[0].center_m - Eigen::Vector3d(3, 4, -1)).norm() < 1e-6);
  CHECK(match_layout(square_layout(1), true, square_m).empty());  // to learn from, all must be seen
  square_m.pop_back();
  CHECK(match_layout(square_layout(1.6), false, square_m).empty());
}

TEST_CASE("circles at clearly different heights are no deck, nor are ones that touch") {
  Circles circles_m = circles_of(square_layout(1.6), {0, 0, -1}, 0);
  circles_m[0].z() -= 1;
  CHECK(match_layout(square_layout(1), true, circles_m).empty());
  CHECK(match_layout(square_layout(1), true, circles_of(square_layout(0.9), {0, 0, -1}, 0)).empty());
  CHECK(match_layout(square_layout(1), true, circles_of(square_layout(5), {0, 0, -1}, 0)).empty());
}

TEST_CASE("slots are assigned globally: nearest first would cross") {
  DeckMotion motion{PlatformSettings{}};
  DeckState state = motion.unknown();
  for (const Eigen::Index i : {at::north, at::east, at::down, at::heading}) {
    state.covariance.row(i).setZero();
    state.covariance.col(i).setZero();
    state.covariance(i, i) = i == at::heading ? 0.0025 : 0.04;
  }
  const SlotLayout row = row_layout(1.2);
  CHECK(worst_slot_sigma_m(state, row) == Approx(std::hypot(0.2, 1.8 * 0.05)).margin(0.1));
  // the deck is 0.35 m ahead of where it is expected: the second circle is nearer to the first's place than
  // half
  std::vector<CircleCandidates> circles;
  for (const Eigen::Vector3d& c : circles_of(row, {0.35, 0, -1}, 0))
    circles.push_back(
        {{{c + Eigen::Vector3d(0, 0, 6), Eigen::Matrix3d::Identity() * 1e-4, {0, 0, -1}, 1e-3}}, {1.0}});
  state.mean[at::down] = 0;
  const Eigen::Vector3d aircraft_m(0, 0, -5);
  circles.push_back({{{{0.35, 3.0, 5}, Eigen::Matrix3d::Identity() * 1e-4, {0, 0, -1}, 1e-3}}, {1.0}});
  const auto matches = assign_slots(state, row, aircraft_m, 1e-4, circles);
  REQUIRE(matches.size() == 4);
  for (const SlotMatch& match : matches) CHECK(match.circle == match.slot);
}

TEST_CASE("of the poses that a circle allows, the one that lies on the deck is taken") {
  DeckMotion motion{PlatformSettings{}};
  DeckState state = motion.unknown();
  state.covariance *= 0.01;
  state.covariance(at::north, at::north) = state.covariance(at::east, at::east) = 0.01;
  state.covariance(at::down, at::down) = 0.01;
  state.covariance(at::heading, at::heading) = 0.001;
  const Eigen::Matrix3d noise = Eigen::Matrix3d::Identity() * 1e-4;
  const Eigen::Vector3d center_m(0.8, -0.8, 5), leaning = Eigen::Vector3d(0.5, 0, -1).normalized();
  const std::vector<CircleCandidates> circles{
      {{{center_m, noise, leaning, 1e-3}, {center_m, noise, {0, 0, -1}, 1e-3}}, {0.9, 0.1}}};
  const auto matches = assign_slots(state, square_layout(1.6), {0, 0, -5}, 1e-4, circles);
  REQUIRE(matches.size() == 1);
  CHECK(matches[0].slot == 0);
  CHECK(matches[0].view == 1);
}

TEST_CASE("a slot is unknown, then as seen, corrected by what follows, and forgotten slowly") {
  SlotBelief belief;
  CHECK(belief.state(0) == SlotState::unknown);
  CHECK(belief.confidence(0) == Approx(1.0 / 3));
  std::int64_t t = second_us;
  belief.saw_cargo(t, 0.1, 0.06, 0.37);
  belief.saw_circle(t += 33'000, false);  // one frame later it counts for little
  CHECK(belief.probabilities(t)[1] > 0.5);
  for (int i = 0; i < 30; ++i) belief.saw_cargo(t += 66'000, 0.1, 0.06, 0.37);
  CHECK(belief.state(t) == SlotState::occupied);
  CHECK(belief.confidence(t) > 0.98);
  CHECK(belief.confidence(t) < 1);
  CHECK(belief.seen_utime() == t);
  const double later = belief.confidence(t + 100 * second_us);
  CHECK(later < belief.confidence(t));
  CHECK(belief.state(t + 1000 * second_us) == SlotState::unknown);
  for (int i = 0; i < 40; ++i) belief.saw_circle(t += 66'000, false);  // it was taken away
  CHECK(belief.state(t) == SlotState::empty);
}

TEST_CASE("that a circle is occupied by something without a rim counts for less than that it is empty") {
  SlotBelief belief;
  std::int64_t t = second_us;
  for (int i = 0; i < 30; ++i) belief.saw_circle(t += 300'000, i % 3 == 0);
  CHECK(belief.state(t) == SlotState::empty);
}

TEST_CASE("a cargo inside its circle occupies it, one across the paint is misplaced") {
  SlotBelief inside, across;
  std::int64_t t = second_us;
  for (int i = 0; i < 20; ++i, t += 100'000) {
    inside.saw_cargo(t, 0.1, 0.06, 0.37);
    across.saw_cargo(t, 0.55, 0.06, 0.37);
    across.saw_circle(t, i % 2 == 0);
  }
  CHECK(inside.state(t) == SlotState::occupied);
  CHECK(across.state(t) == SlotState::misplaced);
}

TEST_CASE("identity: certain after a good prediction, not after a poor one, settled by several messages") {
  SlotIdentity identity(pi / 2, 4);
  CHECK_FALSE(identity.certain());
  identity.found(0.05, 10);
  CHECK_FALSE(identity.certain());
  int messages = 0;
  for (; !identity.certain() && messages < 20; ++messages) identity.told(pi / 2 + 0.1, 0.09);
  CHECK(identity.turns() == 1);
  CHECK(messages >= 3);
  CHECK(messages <= 5);
  identity.found(0.1, 0.1);  // three sigma are 17 degrees: less than 45
  CHECK(identity.certain());
  CHECK(identity.turns() == 1);
  CHECK(identity.spread_rad2() < 0.01);
  SlotIdentity poor = identity;
  poor.found(0.0, 0.3);  // three sigma are 52 degrees
  CHECK_FALSE(poor.certain());
  for (int i = 0; i < 30; ++i) identity.told(-pi / 2, 0.09);  // it was wrong after all
  CHECK(identity.turns() == 3);
}

TEST_CASE("identity: the deck turned on while it was not seen") {
  SlotIdentity row(pi, 2);
  for (int i = 0; i < 6; ++i) row.told(0, 0.1);
  REQUIRE(row.certain());
  // found 88 degrees off, where 92 the other way is as likely: no saying which end is which
  const auto slipped = row.found(1.54, 0.5);
  CHECK(slipped[0] > 0.4);
  CHECK(slipped[1] > 0.3);
  CHECK_FALSE(row.certain());
}
