// The whole job can be flown in this world: a crane that knows the truth takes every bucket from the first
// platform to circles of the second.
#include <Eigen/Dense>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstddef>
#include <optional>

#include "sim_proc/world/world.hpp"

using namespace stevedore;
using namespace stevedore::world;

namespace {

constexpr double handle_over_rim_m = 0.12, handle_over_base_m = 0.42;

/// Brings the hook to a point that moves with a platform. It knows what the aircraft does with a command:
/// velocity comes 0.1 s + 2 damping / w = 0.66 s late, so that commands lead the deck's motion by as much.
class Crane {
 public:
  explicit Crane(World& world) : world_(world) {}

  /// `where` names the place in each step. False: not `done` within the time.
  template <typename Where, typename Done>
  bool bring(const Where& where, double time_s, const Done& done) {
    std::optional<Eigen::Vector3d> before_m, pace_before_mps;
    for (int i = 0; i < std::lround(time_s / period_s); ++i) {
      const Truth truth = world_.whereabouts();
      if (done(truth)) return true;
      const Eigen::Vector3d goal_m = where(truth), still = Eigen::Vector3d::Zero();
      const Eigen::Vector3d pace_mps = before_m ? Eigen::Vector3d((goal_m - *before_m) / period_s) : still;
      const Eigen::Vector3d change_mps2 =
          pace_before_mps ? Eigen::Vector3d((pace_mps - *pace_before_mps) / period_s) : still;
      if (before_m) pace_before_mps = pace_mps;
      before_m = goal_m;
      fly(truth, goal_m, pace_mps + late_s * change_mps2);
    }
    return false;
  }

 private:
  static constexpr double period_s = 0.05, late_s = 0.66, per_s = 0.8, hang_time_s = 3, max_mps2 = 1.5;

  /// By where the hook hangs in the mean: its swings are left to die out.
  void fly(const Truth& truth, const Eigen::Vector3d& goal_m, const Eigen::Vector3d& pace_mps) {
    const Eigen::Vector3d hangs_m = truth.hook_ned_m - truth.aircraft.position_ned_m;
    hangs_m_ =
        hangs_m_ ? Eigen::Vector3d(*hangs_m_ + (hangs_m - *hangs_m_) * period_s / hang_time_s) : hangs_m;
    Eigen::Vector3d wanted_mps = pace_mps + per_s * (goal_m - *hangs_m_ - truth.aircraft.position_ned_m);
    const double horizontal_mps = wanted_mps.head<2>().norm();
    if (horizontal_mps > 3) wanted_mps.head<2>() *= 3 / horizontal_mps;
    wanted_mps.z() = std::clamp(wanted_mps.z(), -1.0, 1.0);
    const Eigen::Vector3d change_mps = wanted_mps - velocity_mps_;
    const double most_mps = max_mps2 * period_s;
    velocity_mps_ +=
        change_mps.norm() > most_mps ? Eigen::Vector3d(most_mps * change_mps.normalized()) : change_mps;
    world_.command({velocity_mps_, 0});
    for (int i = 0; i < std::lround(period_s / World::step_s); ++i) world_.step();
  }

  World& world_;
  Eigen::Vector3d velocity_mps_ = Eigen::Vector3d::Zero();
  std::optional<Eigen::Vector3d> hangs_m_;
};

const CargoTruth& cargo_of(const Truth& truth, int index) {
  return truth.cargoes.at(static_cast<std::size_t>(index));
}

const CircleTruth& free_circle(const Truth& truth) {
  return *std::find_if(truth.circles.begin(), truth.circles.end(),
                       [](const CircleTruth& circle) { return circle.platform == 1 && !circle.occupied; });
}

bool load(World& world, Crane& crane, int index) {
  const auto over = [&](double height_m) {
    return [=](const Truth& truth) -> Eigen::Vector3d {
      const CargoTruth& cargo = cargo_of(truth, index);
      return cargo.center_ned_m + handle_over_rim_m * cargo.axis_ned - Eigen::Vector3d(0, 0, height_m);
    };
  };
  const auto near = [&](double height_m, double within_m) {
    return [=](const Truth& truth) { return (over(height_m)(truth) - truth.hook_ned_m).norm() < within_m; };
  };
  world.command_hook(false);
  if (!crane.bring(over(4), 90, near(4, 0.5)) || !crane.bring(over(0.5), 60, near(0.5, 0.15))) return false;
  // what is taken at the gate's edge may slip off: the jaws wait until the handle is well inside
  if (!crane.bring(over(0), 60, near(0, 0.03))) return false;
  world.command_hook(true);
  const auto taken = [&](const Truth& truth) { return cargo_of(truth, index).on_hook; };
  const auto lifted = [&](const Truth& truth) { return cargo_of(truth, index).platform == -1; };
  if (!crane.bring(over(0), 60, taken)) return false;
  const auto up = [](const Truth& truth) -> Eigen::Vector3d {
    return truth.hook_ned_m - Eigen::Vector3d(0, 0, 1);
  };
  return crane.bring(up, 10, lifted);
}

bool drop(World& world, Crane& crane, int index) {
  const int slot = free_circle(world.whereabouts()).slot;
  const auto over = [&](double base_over_m) {
    return [=](const Truth& truth) -> Eigen::Vector3d {
      const auto circle =
          std::find_if(truth.circles.begin(), truth.circles.end(),
                       [&](const CircleTruth& each) { return each.platform == 1 && each.slot == slot; });
      return circle->center_ned_m - Eigen::Vector3d(0, 0, handle_over_base_m + base_over_m);
    };
  };
  const auto near = [&](double base_over_m, double within_m) {
    return
        [=](const Truth& truth) { return (over(base_over_m)(truth) - truth.hook_ned_m).norm() < within_m; };
  };
  const auto lost = [&](const Truth& truth) { return !cargo_of(truth, index).on_hook; };
  const auto stands = [&](const Truth& truth) { return cargo_of(truth, index).platform == 1 || lost(truth); };
  if (!crane.bring(over(4), 90, near(4, 0.5)) || !crane.bring(over(0.5), 60, near(0.5, 0.15))) return false;
  if (!crane.bring(over(-0.1), 60, stands) || lost(world.whereabouts())) return false;
  world.command_hook(false);
  const auto away = [](const Truth& truth) -> Eigen::Vector3d {
    return truth.hook_ned_m - Eigen::Vector3d(0, 0, 1);
  };
  crane.bring(away, 3, [](const Truth&) { return false; });
  const CargoTruth cargo = cargo_of(world.whereabouts(), index);
  return cargo.platform == 1 && cargo.slot >= 0 && !cargo.tipped;
}

}  // namespace

TEST_CASE("a crane that knows the truth moves all four buckets in sea states 0 to 3") {
  for (int sea_state = 0; sea_state <= 3; ++sea_state) {
    WorldSettings settings;
    settings.seed = 40 + static_cast<std::uint64_t>(sea_state);
    settings.sea_state = sea_state;
    settings.camera.given = settings.camera.rectified = {640, 480, 337, 337, 319.5, 239.5};
    World world(settings);
    Crane crane(world);
    world.command({{0, 0, -1}, 0});
    for (int i = 0; i < 1200; ++i) world.step();
    for (int index = 0; index < 4; ++index) {
      INFO("sea state " << sea_state << ", bucket " << index << ", at " << world.time_s() << " s");
      bool moved = false;
      for (int attempt = 0; attempt < 4 && !moved;
           ++attempt) {  // a deck may heave away from the closing jaws
        const CargoTruth cargo = cargo_of(world.whereabouts(), index);
        if (cargo.platform < 0 || cargo.tipped) break;
        moved = load(world, crane, index) && drop(world, crane, index);
      }
      CHECK(moved);
    }
  }
}
