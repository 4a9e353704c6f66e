#include "tools/draw.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace stevedore {
namespace {

constexpr int fine_width_px = 640;  // from here on a line of one pixel is thin enough
constexpr int subpixel_bits = 4;
constexpr double longest_axis_px = 1e5;  // of what is drawn: far above any frame, far below overflow
constexpr double corner_spacing_px = 3;
constexpr int corners_a_dash = 4;

constexpr int caption_line_px = 18;
constexpr double caption_font_scale = 0.45;

cv::Scalar bgr(const Colour& colour) {
  return {colour.blue, colour.green, colour.red};
}

}  // namespace

Canvas::Canvas(const cv::Mat& frame) : scale_(frame.cols < fine_width_px ? 2 : 1) {
  if (frame.channels() == 1) {
    cv::cvtColor(frame, image_, cv::COLOR_GRAY2BGR);
  } else {
    image_ = frame.clone();
  }
  if (scale_ != 1) cv::resize(image_, image_, {}, scale_, scale_, cv::INTER_LINEAR);
}

std::vector<cv::Point> Canvas::outline(const Ellipse& ellipse) const {
  if (!is_valid(ellipse) || ellipse.a_px > longest_axis_px || std::abs(ellipse.u_px) > longest_axis_px ||
      std::abs(ellipse.v_px) > longest_axis_px) {
    return {};
  }
  // a whole number of dashes and gaps
  const int dashes = std::max(
      6, static_cast<int>(perimeter_px(ellipse) * scale_ / corner_spacing_px) / (2 * corners_a_dash));
  const int corners = dashes * 2 * corners_a_dash;
  std::vector<cv::Point> points;
  for (int i = 0; i < corners; ++i) {
    const Eigen::Vector2d p = point_at(ellipse, 2 * std::numbers::pi * i / corners);
    // (0, 0) is the centre of the upper-left pixel, before and after enlarging
    const Eigen::Vector2d q = ((p.array() + 0.5) * scale_ - 0.5) * (1 << subpixel_bits);
    points.emplace_back(static_cast<int>(std::lround(q.x())), static_cast<int>(std::lround(q.y())));
  }
  return points;
}

void Canvas::ellipse(const Ellipse& ellipse, const Colour& colour, int thickness) {
  const auto points = outline(ellipse);
  if (points.empty()) return;
  cv::polylines(image_, points, true, bgr(colour), thickness, cv::LINE_AA, subpixel_bits);
}

void Canvas::dashed_ellipse(const Ellipse& ellipse, const Colour& colour, int thickness) {
  const auto points = outline(ellipse);
  for (size_t start = 0; start < points.size(); start += 2 * corners_a_dash) {
    const std::vector<cv::Point> dash(points.begin() + static_cast<std::ptrdiff_t>(start),
                                      points.begin() + static_cast<std::ptrdiff_t>(start) + corners_a_dash);
    cv::polylines(image_, dash, false, bgr(colour), thickness, cv::LINE_AA, subpixel_bits);
  }
}

void Canvas::caption(const std::vector<std::string>& lines) {
  constexpr int margin_px = 6;
  int bar_px = caption_line_px * static_cast<int>(lines.size()) + margin_px;
  bar_px += (image_.rows + bar_px) % 2;  // video encoders want even sizes
  cv::Mat with_bar;
  cv::copyMakeBorder(image_, with_bar, 0, bar_px, 0, image_.cols % 2, cv::BORDER_CONSTANT, {32, 32, 32});
  int baseline_px = image_.rows + caption_line_px - margin_px / 2;
  for (const std::string& line : lines) {
    cv::putText(with_bar, line, {margin_px, baseline_px}, cv::FONT_HERSHEY_SIMPLEX, caption_font_scale,
                {230, 230, 230}, 1, cv::LINE_AA);
    baseline_px += caption_line_px;
  }
  image_ = with_bar;
}

}  // namespace stevedore
