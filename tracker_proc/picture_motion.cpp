#include "tracker_proc/picture_motion.hpp"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

namespace stevedore {
namespace {

// Small enough to cost next to nothing, large enough for a deck or a line on the ground to be seen.
constexpr int kSmallWidthPx = 96;

// The peak is found to a third of a small pixel; what lies nearer than the ground, and perspective, make
// other parts of the picture move by a tenth more or less.
constexpr double kPeakSigma_px = 0.3;
constexpr double kPerspective = 0.1;

// Of the parts that overlap after the shift. Below, most of the picture is something else.
constexpr double kLeastCorrelation = 0.5;

int small_height(const cv::Mat& image) {
  return image.rows * kSmallWidthPx / image.cols;
}

cv::Mat small_of(const cv::Mat& image) {
  const int height = small_height(image);
  cv::Mat samples, small, grey, levels;  // four samples a small pixel: blur and noise enough are left out
  cv::resize(image, samples, {2 * kSmallWidthPx, 2 * height}, 0, 0, cv::INTER_NEAREST);
  cv::resize(samples, small, {kSmallWidthPx, height}, 0, 0, cv::INTER_AREA);
  if (small.channels() == 3) cv::cvtColor(small, grey, cv::COLOR_BGR2GRAY);
  (grey.empty() ? small : grey).convertTo(levels, CV_32F);
  return levels;
}

/// Normalised cross-correlation of `now` with `before` moved by whole pixels, where they overlap.
double correlation(const cv::Mat& before, const cv::Mat& now, const cv::Point& shift) {
  const cv::Rect all({}, now.size());
  const cv::Rect there = (all + shift) & all;
  if (there.area() < all.area() / 4) return 0;
  cv::Scalar mean_1, mean_2, scatter_1, scatter_2;
  const cv::Mat a = before(there - shift), b = now(there);
  cv::meanStdDev(a, mean_1, scatter_1);
  cv::meanStdDev(b, mean_2, scatter_2);
  const double scatter = scatter_1[0] * scatter_2[0];
  return scatter > 0 ? (a.dot(b) / there.area() - mean_1[0] * mean_2[0]) / scatter : 0;
}

}  // namespace

std::optional<PictureShift> PictureMotion::shift_to(const cv::Mat& image) {
  if (image.empty() || (image.type() != CV_8UC1 && image.type() != CV_8UC3)) return std::nullopt;
  if (small_height(image) < 2 || small_height(image) > 10 * kSmallWidthPx) return std::nullopt;  // a strip
  const cv::Mat before = before_;
  before_ = small_of(image);
  if (before.size() != before_.size()) return std::nullopt;
  if (window_.size() != before_.size()) cv::createHanningWindow(window_, before_.size(), CV_32F);
  const cv::Point2d shift = cv::phaseCorrelate(before, before_, window_);
  if (!(correlation(before, before_, {cvRound(shift.x), cvRound(shift.y)}) > kLeastCorrelation))
    return std::nullopt;
  const double scale = static_cast<double>(image.cols) / before_.cols;
  const Eigen::Vector2d shift_px(scale * shift.x, scale * shift.y);
  return PictureShift{shift_px, std::pow(scale * kPeakSigma_px, 2) +
                                    kPerspective * kPerspective * shift_px.squaredNorm() / 2};
}

}  // namespace stevedore
