#include "tracker_proc/appearance.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <opencv2/video/tracking.hpp>

namespace stevedore {
namespace {

// OpenCV's hue is 0..179; 72 codes above it hold the grey levels. Bins of 6 codes: 12 degrees of hue, 21
// levels.
constexpr int kHues = 180, kGreys = 72, kCodesPerBin = 6;
constexpr int kBins = (kHues + kGreys) / kCodesPerBin;

// max - min of B, G, R. Noise of 5 grey levels turns the hue by 60 deg x 5 / 40 = 7 degrees: within a bin or
// two.
constexpr int kLeastChroma = 40;

// CAMShift sees this many windows around the expected one, in each direction. An object that moved farther
// than that no longer overlaps the place it was expected at, and mean shift can't have followed it; a white
// wall or a neighbour out there could only pull the window away.
constexpr double kSearchedWindows = 1.0;

// Usable windows: surroundings at most half as probable as the inside (where they are more, the window only
// shows where it started); at most 1.8 radii from the expected centre (at two a neighbour of the same size
// may be); not larger or smaller than by a factor of two (a thin ring fills a window sqrt(2) times its size;
// more is a leak, less the rest of a covered target).
constexpr double kLargestLikeness = 0.5;
constexpr double kFarthestRadii = 1.8;
constexpr double kSizeRatio = 2.0;

// A mark is looked at with no more pixels than a radius of this many gives: its window is then good to half a
// pixel or two, a small part of the radius, and a large mark costs no more than a small one.
constexpr double kRadiusPx = 12;

// Pixels on the edge are a mixture and belong to neither side.
constexpr double kEdgePx = 2.0;

// A histogram of fewer pixels than bins says nothing.
constexpr int kLeastPixels = kBins;

bool is_usable(const cv::Mat& image) {
  return !image.empty() && (image.type() == CV_8UC1 || image.type() == CV_8UC3);
}

uchar grey_code(int level) {
  return static_cast<uchar>(kHues + level * kGreys / 256);
}

/// The rectangle with so many times its size added on each side, as far as it lies in the frame.
cv::Rect grown(const cv::Rect& r, double by, const cv::Size& frame) {
  const int du = cvRound(r.width * by), dv = cvRound(r.height * by);
  return cv::Rect(r.x - du, r.y - dv, r.width + 2 * du, r.height + 2 * dv) & cv::Rect({}, frame);
}

/// The features of a part of the frame, every step-th pixel of every step-th row.
struct Part {
  cv::Rect in_frame;
  int step;
  cv::Mat features;

  [[nodiscard]] Ellipse from_frame(const Ellipse& e) const {
    return {(e.u_px - in_frame.x) / step, (e.v_px - in_frame.y) / step, e.a_px / step, e.b_px / step,
            e.alpha_rad};
  }
  [[nodiscard]] Ellipse to_frame(const Ellipse& e) const {
    return {e.u_px * step + in_frame.x, e.v_px * step + in_frame.y, e.a_px * step, e.b_px * step,
            e.alpha_rad};
  }
};

Part part_around(const cv::Mat& image, const Ellipse& e) {
  const cv::Rect there = grown(tangent_rectangle(e, image.size()), kSearchedWindows, image.size());
  const int step = std::max(1, static_cast<int>(e.b_px / kRadiusPx));
  if (there.empty() || step == 1) return {there, 1, there.empty() ? cv::Mat() : feature_image(image(there))};
  cv::Mat thinned((there.height + step - 1) / step, (there.width + step - 1) / step, image.type());
  const std::size_t size = image.elemSize();
  for (int y = 0; y < thinned.rows; ++y) {
    const uchar* from = image.ptr(there.y + y * step, there.x);
    uchar* to = thinned.ptr(y);
    for (int x = 0; x < thinned.cols; ++x, from += size * static_cast<std::size_t>(step), to += size)
      std::copy_n(from, size, to);
  }
  return {there, step, feature_image(thinned)};
}

/// 255 inside the ellipse.
cv::Mat mask_of(const Ellipse& in_frame, const Part& part) {
  constexpr int kShift = 4;  // fractional bits
  const Ellipse e = part.from_frame(in_frame);
  const auto fixed = [](double px) { return cvRound(px * (1 << kShift)); };
  cv::Mat mask = cv::Mat::zeros(part.features.size(), CV_8U);
  cv::ellipse(mask, {fixed(e.u_px), fixed(e.v_px)}, {fixed(e.a_px), fixed(e.b_px)},
              e.alpha_rad * 180 / std::numbers::pi, 0, 360, cv::Scalar(255), cv::FILLED, cv::LINE_8, kShift);
  return mask;
}

Ellipse enlarged(const Ellipse& e, double by_px) {
  return {e.u_px, e.v_px, e.a_px + by_px, e.b_px + by_px, e.alpha_rad};
}

cv::Mat histogram_of(const cv::Mat& features, const cv::Mat& mask) {
  cv::Mat histogram;
  const int channel = 0, bins = kBins;
  const float range[] = {0, kHues + kGreys};
  const float* ranges[] = {range};
  cv::calcHist(&features, 1, &channel, mask, histogram, 1, &bins, ranges);
  return histogram / cv::sum(histogram)[0];
}

/// Step 3.
cv::Mat back_projection(const cv::Mat& features, const cv::Mat& histogram) {
  double largest = 0;
  cv::minMaxLoc(histogram, nullptr, &largest);
  cv::Mat probability;
  const int channel = 0;
  const float range[] = {0, kHues + kGreys};
  const float* ranges[] = {range};
  cv::calcBackProject(&features, 1, &channel, histogram, probability, ranges,
                      largest > 0 ? 255 / largest : 0);
  return probability;
}

/// Mean probability around the window over the mean inside it: 0 for white on black, 1 where all looks alike.
double likeness_of_surroundings(const cv::Mat& probability, const cv::Mat& inside) {
  const cv::Mat outside = ~inside;
  if (cv::countNonZero(outside) == 0) return 1;
  return cv::mean(probability, outside)[0] / std::max(1.0, cv::mean(probability, inside)[0]);
}

/// Why a window can't be used.
std::string fault_of(const Ellipse& window, const Ellipse& expected, const cv::Mat& probability,
                     const Part& part) {
  const double radii = std::sqrt(normalized_radius_squared(expected, {window.u_px, window.v_px}));
  if (radii > kFarthestRadii) return "the CAMShift window ran away";
  const double ratio = std::sqrt(window.a_px * window.b_px / (expected.a_px * expected.b_px));
  if (ratio < 1 / kSizeRatio) return "the CAMShift window collapsed";
  if (ratio > kSizeRatio) return "the CAMShift window leaked into the background";
  if (likeness_of_surroundings(probability, mask_of(window, part)) > kLargestLikeness)
    return "the background looks like the target to CAMShift";
  return {};
}

}  // namespace

cv::Mat feature_image(const cv::Mat& image) {
  cv::Mat features(image.size(), CV_8U);
  if (image.type() == CV_8UC1) {
    for (int y = 0; y < image.rows; ++y)
      std::transform(image.ptr(y), image.ptr(y) + image.cols, features.ptr(y), grey_code);
    return features;
  }
  CV_Assert(image.type() == CV_8UC3);
  cv::Mat hsv, grey;
  cv::cvtColor(image, hsv, cv::COLOR_BGR2HSV);
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  for (int y = 0; y < image.rows; ++y)
    for (int x = 0; x < image.cols; ++x) {
      const auto& [hue, saturation, value] = hsv.at<cv::Vec3b>(y, x).val;
      const bool coloured = saturation * value >= kLeastChroma * 255;
      features.at<uchar>(y, x) = coloured ? hue : grey_code(grey.at<uchar>(y, x));
    }
  return features;
}

cv::Rect tangent_rectangle(const Ellipse& e, const cv::Size& frame) {
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad);
  const double half_u = std::hypot(e.a_px * c, e.b_px * s), half_v = std::hypot(e.a_px * s, e.b_px * c);
  const auto column = [&](double u) { return static_cast<int>(std::clamp(u, 0.0, double(frame.width))); };
  const auto row = [&](double v) { return static_cast<int>(std::clamp(v, 0.0, double(frame.height))); };
  // a pixel reaches from -0.5 to 0.5 around its centre
  return {cv::Point(column(std::floor(e.u_px - half_u + 0.5)), row(std::floor(e.v_px - half_v + 0.5))),
          cv::Point(column(std::ceil(e.u_px + half_u + 0.5)), row(std::ceil(e.v_px + half_v + 0.5)))};
}

cv::Mat updated_histogram(const cv::Mat& histogram, const cv::Mat& of_this_frame, double weight) {
  return weight * histogram + (1 - weight) * of_this_frame;
}

void Appearance::learn(const cv::Mat& image, const Ellipse& target) {
  if (!is_usable(image)) return;
  const Part part = part_around(image, target);
  if (part.features.empty()) return;
  const cv::Mat inside = mask_of(enlarged(target, (1 - part.step) / 2.0), part);
  const cv::Mat outside = ~mask_of(enlarged(target, kEdgePx), part);
  if (cv::countNonZero(inside) < kLeastPixels || cv::countNonZero(outside) < kLeastPixels) return;
  const bool first = histogram_.empty() || channels_ != image.channels();
  const auto learn_one = [&](cv::Mat& histogram, const cv::Mat& mask) {
    const cv::Mat now = histogram_of(part.features, mask);
    histogram = first ? now : updated_histogram(histogram, now, weight_);
  };
  learn_one(histogram_, inside);
  learn_one(surroundings_, outside);
  channels_ = image.channels();
}

WindowSearch Appearance::find(const cv::Mat& image, const Ellipse& expected) const {
  if (!is_usable(image)) return {std::nullopt, "no image in this frame"};
  if (histogram_.empty()) return {std::nullopt, "too little of the target was seen to learn its look"};
  if (channels_ != image.channels()) return {std::nullopt, "the frames changed between colour and grey"};
  if (tangent_rectangle(expected, image.size()).empty())
    return {std::nullopt, "the target has left the image"};

  const Part part = part_around(image, expected);
  const cv::Mat probability = back_projection(part.features, cv::max(histogram_ - surroundings_, 0));
  cv::Rect start = tangent_rectangle(part.from_frame(expected), probability.size());
  if (start.empty()) return {std::nullopt, "the target has left the image"};
  // A pixel of movement is far below the gate; mean shift needs a step for each half window of movement.
  const cv::RotatedRect box =
      cv::CamShift(probability, start, {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 20, 1});
  const Ellipse window =
      normalized(part.to_frame({double(box.center.x), double(box.center.y), double(box.size.width) / 2,
                                double(box.size.height) / 2, double(box.angle) * std::numbers::pi / 180}));
  if (!is_valid(window)) return {std::nullopt, "CAMShift saw nothing that looks like the target"};
  return {window, fault_of(window, expected, probability, part)};
}

}  // namespace stevedore
