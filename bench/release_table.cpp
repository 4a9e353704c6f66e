// What becomes of released buckets: stands in the circle, tipped, or stands outside, by height and speed of
// the release, over a deck that moves with the sea.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <numbers>

#include "sim_proc/world/cargo.hpp"
#include "sim_proc/world/dice.hpp"
#include "sim_proc/world/platform_motion.hpp"
#include "sim_proc/world/world.hpp"

using namespace stevedore::world;

namespace {

constexpr double circle_radius_m = 0.5;
constexpr double offset_sigma_m = 0.2;  // north and east: a poor aim
constexpr double lean_sigma_rad = 0.1;  // 6 deg: a bucket that swings by 10 cm

struct Tally {
  int in_circle = 0, tipped = 0, missed = 0;
};

Eigen::Vector3d level(double length, double bearing_rad) {
  return {length * std::cos(bearing_rad), length * std::sin(bearing_rad), 0};
}

/// Hung over the deck's middle, off by a draw, at that height and speed over it; then let go.
void release(double height_m, double speed_mps, int sea_state, Dice& dice, Tally& tally) {
  const PlatformMotion motion(dice.next(), 0, sea_state);
  double time_s = dice.uniform(0, 1000);
  Floor floor{{{motion.at(time_s), {2, 2}}}, false};
  const Rigid& deck = floor.decks[0].rigid;

  Cargo cargo(Bucket{}, 0, {0, 0}, 0, floor);
  const double lean_north = dice.normal(lean_sigma_rad), lean_east = dice.normal(lean_sigma_rad);
  const Eigen::Vector3d up = Eigen::Vector3d(lean_north, lean_east, -1).normalized();
  const double off_north_m = dice.normal(offset_sigma_m), off_east_m = dice.normal(offset_sigma_m);
  const Eigen::Vector3d base_m = deck.position_ned_m + Eigen::Vector3d(off_north_m, off_east_m, -height_m);
  const Eigen::Vector3d velocity_mps =
      deck.velocity_ned_mps + level(speed_mps, dice.uniform(0, 2 * std::numbers::pi));
  for (int i = 0; i < 2; ++i) cargo.hang(base_m + 0.15 * up, velocity_mps, up, World::step_s);
  cargo.let_go();
  for (const double until_s = time_s + 5; time_s < until_s; time_s += World::step_s) {
    floor.decks[0].rigid = motion.at(time_s);
    cargo.step(floor, World::step_s);
  }
  const Eigen::Vector3d stands_m = floor.decks[0].rigid.to_local(cargo.bucket().rigid.position_ned_m);
  const bool inside = cargo.deck() == 0 && stands_m.head<2>().norm() <= circle_radius_m;
  ++(cargo.tipped() ? tally.tipped : inside ? tally.in_circle : tally.missed);
}

void print_table(std::uint64_t seed, int sea_state, int releases) {
  const std::array<double, 5> heights_m{0.05, 0.15, 0.3, 0.6, 1.0}, speeds_mps{0, 0.25, 0.5, 1.0, 1.5};
  Dice dice(seed, "releases");
  std::cout << fmt::format(
      "sea state {}, {} releases a cell: stands in circle / tipped / stands outside, %\n"
      "height over the deck |",
      sea_state, releases);
  for (const double speed_mps : speeds_mps) std::cout << fmt::format("{:>9.2f} m/s |", speed_mps);
  for (const double height_m : heights_m) {
    std::cout << fmt::format("\n{:>18.2f} m |", height_m);
    for (const double speed_mps : speeds_mps) {
      Tally tally;
      for (int i = 0; i < releases; ++i) release(height_m, speed_mps, sea_state, dice, tally);
      const auto share = [&](int count) { return 100.0 * count / releases; };
      std::cout << fmt::format("{:>4.0f}/{:>3.0f}/{:>3.0f} |", share(tally.in_circle), share(tally.tipped),
                               share(tally.missed));
    }
  }
  std::cout << "\n";
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Released buckets: a table of in circle, tipped and missed, by height and speed of the release."};
  std::uint64_t seed = 1;
  int sea_state = 2, releases = 400;
  app.add_option("--seed", seed, "of offsets, leans and seas")->capture_default_str();
  app.add_option("--sea-state", sea_state, "0 to 4")->check(CLI::Range(0, 4))->capture_default_str();
  app.add_option("--releases", releases, "in each cell")
      ->check(CLI::Range(1, 1000000))
      ->capture_default_str();
  CLI11_PARSE(app, argc, argv);
  print_table(seed, sea_state, releases);
}
