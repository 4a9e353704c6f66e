#include "detector_proc/contours.hpp"

#include <iterator>
#include <opencv2/imgproc.hpp>
#include <utility>

namespace stevedore {
namespace {

using PointLists = std::vector<std::vector<cv::Point>>;

/// Mask of the pixels in a range; hue in OpenCV's units of two degrees.
cv::Mat in_range(const cv::Mat& hsv, const ColorRange& range) {
  const double low = range.hue_low_deg / 2, high = range.hue_high_deg / 2;
  const auto between = [&](double from, double to) {
    cv::Mat mask;
    cv::inRange(hsv, cv::Scalar(from, range.saturation_low, range.value_low),
                cv::Scalar(to, range.saturation_high, range.value_high), mask);
    return mask;
  };
  if (low <= high) return between(low, high);
  return between(low, 180) | between(0, high);
}

/// Pixels on the image's border are where the image ends, not where the paint does.
void drop_border(std::vector<cv::Point>& points, cv::Size size) {
  std::erase_if(points, [&](const cv::Point& p) {
    return p.x == 0 || p.y == 0 || p.x == size.width - 1 || p.y == size.height - 1;
  });
}

/// Contours of a mask's regions and of the holes in them.
std::vector<Contour> trace(const cv::Mat& mask, Trace region, Trace hole, const DetectorSettings& settings) {
  PointLists lists;
  std::vector<cv::Vec4i> hierarchy;  // next, previous, child, parent
  cv::findContours(mask, lists, hierarchy, cv::RETR_CCOMP, cv::CHAIN_APPROX_NONE);
  std::vector<Contour> contours;
  for (std::size_t i = 0; i < lists.size(); ++i) {
    drop_border(lists[i], mask.size());
    if (lists[i].size() < static_cast<std::size_t>(settings.min_contour_points)) continue;
    contours.push_back({std::move(lists[i]), hierarchy[i][3] < 0 ? region : hole});
  }
  return contours;
}

}  // namespace

cv::Mat blurred_grey(const cv::Mat& image) {
  cv::Mat grey, blurred;
  if (image.channels() == 3) {
    cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  } else {
    grey = image;
  }
  cv::GaussianBlur(grey, blurred, cv::Size(5, 5), 0);
  return blurred;
}

cv::Mat edge_map(const cv::Mat& blurred, const DetectorSettings& settings) {
  cv::Mat edges;
  cv::Canny(blurred, edges, settings.canny_low, settings.canny_high);
  return edges;
}

std::vector<Contour> edge_contours(const cv::Mat& edges, const DetectorSettings& settings) {
  return trace(edges, Trace::edge_outside, Trace::edge_inside, settings);
}

std::vector<Contour> color_contours(const cv::Mat& image, const DetectorSettings& settings) {
  std::vector<Contour> contours;
  if (settings.colors.empty()) return contours;
  cv::Mat color = image, hsv;
  if (image.channels() == 1) cv::cvtColor(image, color, cv::COLOR_GRAY2BGR);
  cv::cvtColor(color, hsv, cv::COLOR_BGR2HSV);
  for (const ColorRange& range : settings.colors) {
    auto found = trace(in_range(hsv, range), Trace::region, Trace::hole, settings);
    std::move(found.begin(), found.end(), std::back_inserter(contours));
  }
  return contours;
}

}  // namespace stevedore
