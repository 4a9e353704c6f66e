// How good `calibrate` is, and how honest: errors over sigmas on rendered boards, and what --check sees of a
// right file and of wrong ones. The figures of docs/calibration.md.
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "tests/support/board_film.hpp"
#include "tools/calibrate_fit.hpp"

using namespace stevedore;

namespace {

constexpr unsigned first_seed = 11, seeds = 8;
constexpr double noise_levels = 4;

std::vector<View> seen_views(const Board& board, const CameraModel& camera, const BoardFilm& film,
                             unsigned seed) {
  std::vector<View> views;
  unsigned number = 100 * seed;
  for (const BoardPose& pose : good_poses(board, camera, seed)) {
    auto seen = look(board, film.take(pose, noise_levels, number++), "view");
    if (auto* view = std::get_if<View>(&seen)) views.push_back(std::move(*view));
  }
  return views;
}

struct Range {
  double least = HUGE_VAL, most = 0;
  void add(double value) {
    least = std::min(least, value);
    most = std::max(most, value);
  }
};

struct Sums {
  double squares = 0, worst = 0, nees = 0, focal = 0, rms_px = 0;
  int parameters = 0;
  Range right, third_percent, percent;  ///< of the file's share, px
};

void add(const Board& board, const CameraModel& camera, const std::vector<View>& views, Sums& sums) {
  std::vector<RefusedView> refused;
  const Fit made = fit_without_outliers(board, views, example_px, camera.distortion, refused);
  const Eigen::VectorXd error = parameters(made.camera) - parameters(camera);
  const Eigen::VectorXd in_sigmas = error.cwiseQuotient(made.covariance.diagonal().cwiseSqrt());
  sums.squares += in_sigmas.squaredNorm();
  sums.worst = std::max(sums.worst, in_sigmas.cwiseAbs().maxCoeff());
  sums.nees += error.dot(made.covariance.ldlt().solve(error));
  sums.focal = std::max(sums.focal, error.head<2>().cwiseAbs().maxCoeff() / camera.given.fx_px);
  sums.rms_px += made.rms_px / seeds;
  sums.parameters += static_cast<int>(error.size());
  const auto share_px = [&](double factor) {
    CameraModel other = camera;
    other.given.fx_px *= factor;
    other.given.fy_px *= factor;
    return check(board, views, other).systematic_px;
  };
  sums.right.add(share_px(1));
  sums.third_percent.add(share_px(1.003));
  sums.percent.add(share_px(1.01));
}

}  // namespace

int main() {
  fmt::print(
      "board, lens: residual px; parameters, error over sigma: rms, worst; NEES a parameter; worst focal "
      "length %; file's share px: right, 0.3 % off, 1 % off\n");
  for (const auto kind : {Board::Kind::chessboard, Board::Kind::charuco})
    for (const auto lens : {Distortion::plumb_bob, Distortion::equidistant}) {
      Board board;
      board.kind = kind;
      const CameraModel camera = example_lens(lens);
      const BoardFilm film(board, camera);
      Sums s;
      for (unsigned seed = first_seed; seed < first_seed + seeds; ++seed)
        add(board, camera, seen_views(board, camera, film, seed), s);
      fmt::print(
          "{}, {}: {:.3f}; {}, {:.2f}, {:.1f}; {:.2f}; {:.3f}; {:.3f}-{:.3f}, {:.3f}-{:.3f}, {:.3f}-{:.3f}\n",
          kind == Board::Kind::charuco ? "charuco" : "chessboard",
          lens == Distortion::plumb_bob ? "plumb_bob" : "equidistant", s.rms_px, s.parameters,
          std::sqrt(s.squares / s.parameters), s.worst, s.nees / s.parameters, 100 * s.focal, s.right.least,
          s.right.most, s.third_percent.least, s.third_percent.most, s.percent.least, s.percent.most);
    }
}
