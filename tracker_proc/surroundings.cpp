#include "tracker_proc/surroundings.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace stevedore {
namespace {

// The ground that belongs to the mark: a neighbour begins farther out, and what lies beside a vehicle or a
// deck moves another way. Cells of a sixth of a radius: a size that is a tenth wrong displaces them by one.
constexpr int kCells = 20;
constexpr double kRadii = 1.7;
constexpr int kFine = 2;  // samples across a cell

// The mark, its blurred edge and the error of its size.
constexpr double kMarkRadii = 1.2;

// Less than this share of the cells, or less scatter than noise (5 grey levels) has: nothing to compare.
constexpr double kLeastShare = 0.15;
constexpr double kLeastScatter = 5;

/// 2x3: from cell coordinates (0, 0 the centre of the first of `cells` in a row) to the image, stretched as
/// the ellipse is: what lies in the plane of the mark looks the same from another direction, but for a turn.
cv::Matx23d image_from_cells(const Ellipse& e, int cells) {
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad);
  const cv::Matx22d turn(c, -s, s, c);
  const cv::Matx22d stretch =
      turn * cv::Matx22d(e.a_px, 0, 0, e.b_px) * turn.t() * (2 * kRadii / static_cast<double>(cells));
  const cv::Vec2d corner = cv::Vec2d(e.u_px, e.v_px) - stretch * cv::Vec2d(1, 1) * ((cells - 1) / 2.0);
  return {stretch(0, 0), stretch(0, 1), corner[0], stretch(1, 0), stretch(1, 1), corner[1]};
}

cv::Mat cells_around(const cv::Mat& image, const Ellipse& e) {
  const float outside = std::numeric_limits<float>::quiet_NaN();
  cv::Mat fine, grey, levels, cells;
  const cv::Size fine_size(kFine * kCells, kFine * kCells);
  cv::warpAffine(image, fine, image_from_cells(e, kFine * kCells), fine_size,
                 cv::INTER_LINEAR | cv::WARP_INVERSE_MAP, cv::BORDER_REPLICATE);
  if (fine.channels() == 3) cv::cvtColor(fine, grey, cv::COLOR_BGR2GRAY);
  (grey.empty() ? fine : grey).convertTo(levels, CV_32F);
  cv::resize(levels, cells, {kCells, kCells}, 0, 0, cv::INTER_AREA);
  const cv::Matx23d to_image = image_from_cells(e, kCells);
  for (int y = 0; y < kCells; ++y)
    for (int x = 0; x < kCells; ++x) {
      const cv::Vec2d at = to_image * cv::Vec3d(x, y, 1);
      const double radii = std::hypot(x - (kCells - 1) / 2.0, y - (kCells - 1) / 2.0) * 2 * kRadii / kCells;
      const bool in_image = at[0] >= 0 && at[1] >= 0 && at[0] <= image.cols - 1 && at[1] <= image.rows - 1;
      if (!in_image || radii < kMarkRadii) cells.at<float>(y, x) = outside;
    }
  return cells;
}

bool is_usable(const cv::Mat& image) {
  return !image.empty() && (image.type() == CV_8UC1 || image.type() == CV_8UC3);
}

/// The cells whose grey level is known, i.e. no NaN: only a NaN differs from itself.
cv::Mat known(const cv::Mat& cells) {
  cv::Mat mask;
  cv::compare(cells, cells, mask, cv::CMP_EQ);
  return mask;
}

}  // namespace

void Surroundings::learn(const cv::Mat& image, const Ellipse& target) {
  if (!is_usable(image)) return;
  cv::Mat cells = cells_around(image, target);
  if (cells_.empty() || cv::countNonZero(known(cells)) >= kLeastShare * kCells * kCells)
    cells_ = std::move(cells);
}

std::optional<double> Surroundings::correlation(const cv::Mat& image, const Ellipse& around) const {
  if (!is_usable(image) || cells_.empty()) return std::nullopt;
  const cv::Mat now = cells_around(image, around);
  const cv::Mat both = known(cells_) & known(now);
  if (cv::countNonZero(both) < kLeastShare * kCells * kCells) return std::nullopt;
  cv::Scalar mean_1, mean_2, scatter_1, scatter_2;
  cv::meanStdDev(cells_, mean_1, scatter_1, both);
  cv::meanStdDev(now, mean_2, scatter_2, both);
  if (scatter_1[0] < kLeastScatter || scatter_2[0] < kLeastScatter) return std::nullopt;
  cv::Mat product = (cells_ - mean_1[0]).mul(now - mean_2[0]);
  return cv::mean(product, both)[0] / (scatter_1[0] * scatter_2[0]);
}

}  // namespace stevedore
