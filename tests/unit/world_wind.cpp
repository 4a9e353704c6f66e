// Wind: Dryden's spectra by what they mean for a sample of winds, one seed each.
#include <Eigen/Dense>
#include <catch2/catch.hpp>
#include <cmath>

#include "sim_proc/world/wind.hpp"

using namespace stevedore::world;

namespace {

constexpr int winds = 6000;

/// Gusts of many seeds before and after some steps: along the mean wind, across it, down.
struct Sample {
  Eigen::MatrixX3d before{winds, 3}, after{winds, 3};
};

Sample sample(double step_s, int steps) {
  Sample sample;
  for (int i = 0; i < winds; ++i) {
    Wind wind(static_cast<std::uint64_t>(i), {}, step_s);
    const Eigen::Vector3d along = wind.mean_ned_mps().normalized(), across(-along.y(), along.x(), 0);
    const auto in_wind_axes = [&](const Eigen::Vector3d& gust) {
      return Eigen::RowVector3d(gust.dot(along), gust.dot(across), gust.z());
    };
    sample.before.row(i) = in_wind_axes(wind.gust_ned_mps());
    for (int step = 0; step < steps; ++step) wind.step();
    sample.after.row(i) = in_wind_axes(wind.gust_ned_mps());
  }
  return sample;
}

Eigen::RowVector3d rms(const Eigen::MatrixX3d& gusts) {
  return (gusts.cwiseAbs2().colwise().sum() / winds).cwiseSqrt();
}

Eigen::RowVector3d correlation(const Sample& sample) {
  const Eigen::RowVector3d product = sample.before.cwiseProduct(sample.after).colwise().sum() / winds;
  return product.cwiseQuotient(rms(sample.before).cwiseProduct(rms(sample.after)));
}

// MIL-F-8785C at 20 feet: 43.7 m and 6.1 m, at 5 m/s.
constexpr double horizontal_s = 43.7 / 5, vertical_s = 6.096 / 5;
constexpr double vertical_share = 0.519;  // 0.19346^0.4

}  // namespace

TEST_CASE("turbulence is 1 m/s rms, less in the vertical, from the first step on") {
  const Sample gusts = sample(0.005, 300);
  for (const auto& each : {rms(gusts.before), rms(gusts.after)}) {
    CHECK(each[0] == Approx(1).epsilon(0.03));  // 3 sigma of the sample
    CHECK(each[1] == Approx(1).epsilon(0.03));
    CHECK(each[2] == Approx(vertical_share).epsilon(0.03));
  }
}

TEST_CASE("gusts are correlated in time as Dryden's: exp(-t/T) along, (1 - t/2T) exp(-t/T) across") {
  const Eigen::RowVector3d coarse = correlation(sample(horizontal_s / 2, 1));
  CHECK(coarse[0] == Approx(std::exp(-0.5)).margin(0.03));
  CHECK(coarse[1] == Approx(0.75 * std::exp(-0.5)).margin(0.03));
  const Eigen::RowVector3d fine = correlation(sample(vertical_s / 100, 50));
  CHECK(fine[2] == Approx(0.75 * std::exp(-0.5)).margin(0.03));
}

TEST_CASE("mean wind is 5 m/s, level, from anywhere, and in a calm there is none of either") {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const Wind wind(seed, {}, 0.005);
    CHECK(wind.mean_ned_mps().norm() == Approx(5));
    CHECK(wind.mean_ned_mps().z() == 0);
    sum += wind.mean_ned_mps();
  }
  CHECK(sum.norm() / 200 < 1);
  Wind calm(1, {0, 0}, 0.005);
  for (int i = 0; i < 100; ++i) calm.step();
  CHECK(calm.mean_ned_mps().norm() + calm.gust_ned_mps().norm() == 0);
}
