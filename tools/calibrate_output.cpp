#include "tools/calibrate_output.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "tools/calibrate_coverage.hpp"
#include "tools/camera_yaml.hpp"

namespace stevedore {
namespace {

constexpr int panel_px = 640, caption_px = 28;
const cv::Scalar paper(255, 255, 255), ink(40, 40, 40), faint(205, 205, 205), red(40, 40, 220),
    blue(190, 110, 30);

cv::Scalar colour_of(std::size_t view) {
  const double hue = std::fmod(static_cast<double>(view) * 0.618, 1);  // golden ratio: neighbours differ
  cv::Mat pixel(1, 1, CV_8UC3, cv::Scalar(180 * hue, 200, 190));
  cv::cvtColor(pixel, pixel, cv::COLOR_HSV2BGR);
  const auto bgr = pixel.at<cv::Vec3b>(0);
  return {static_cast<double>(bgr[0]), static_cast<double>(bgr[1]), static_cast<double>(bgr[2])};
}

/// A white image of the camera's shape with a caption below.
struct Panel {
  double scale;
  cv::Mat image;

  Panel(const cv::Size& image_px, const std::string& caption) : scale(1.0 * panel_px / image_px.width) {
    const int height = static_cast<int>(std::lround(scale * image_px.height));
    image = cv::Mat(height + caption_px, panel_px, CV_8UC3, paper);
    for (const Region& region : regions(image_px))
      cv::rectangle(image, at(region.area_px.tl()), at(region.area_px.br()), faint, 1);
    cv::rectangle(image, {0, 0}, {panel_px - 1, height - 1}, ink, 1);
    cv::putText(image, caption, {8, height + caption_px - 9}, cv::FONT_HERSHEY_SIMPLEX, 0.48, ink, 1,
                cv::LINE_AA);
  }
  [[nodiscard]] cv::Point at(const cv::Point2d& p) const {
    return {static_cast<int>(std::lround(p.x * scale)), static_cast<int>(std::lround(p.y * scale))};
  }
};

}  // namespace

std::string calibrated_yaml(const Fit& fit, const std::string& name, const std::string& date,
                            const std::vector<std::string>& missing) {
  const auto names = parameter_names(fit.camera);
  std::string text = camera_yaml(fit.camera, name);
  text += fmt::format(
      "# How the numbers above were found; nothing reads this. The covariance is of the corners' noise: a "
      "bent board or\n"
      "# a lens of another kind is not in it.\n"
      "calibration:\n  date: {}\n  views: {}\n  corners: {}\n  rms_px: {:.4f}\n",
      date, fit.views.size(), fit.corners, fit.rms_px);
  text += "  sigma: {";
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    text += fmt::format("{}{}: {:.4g}", i ? ", " : "", names[i], std::sqrt(fit.covariance(k, k)));
  }
  text += fmt::format("}}\n  covariance:\n    parameters: [{}]\n    rows: {}\n    cols: {}\n    data: [",
                      fmt::join(names, ", "), names.size(), names.size());
  for (Eigen::Index row = 0; row < fit.covariance.rows(); ++row)
    for (Eigen::Index col = 0; col < fit.covariance.cols(); ++col)
      text += fmt::format("{}{:.9g}", col ? ", " : row ? ",\n           " : "", fit.covariance(row, col));
  text += "]\n";
  for (const std::string& line : missing) text += "# missing: " + line + "\n";
  return text;
}

cv::Mat calibration_picture(const Fit& fit) {
  const cv::Size image_px(fit.camera.given.width_px, fit.camera.given.height_px);
  double enlarged = 10;  // the usual residual should be seen, and most of them stay apart
  for (const double factor : {20, 50, 100, 200, 500, 1000})
    if (fit.rms_px * factor <= 12) enlarged = factor;
  Panel coverage(image_px, fmt::format("{} views, {} corners", fit.views.size(), fit.corners));
  Panel misses(image_px,
               fmt::format("residuals x {:.0f}, rms {:.3f} px; red: above 3 rms", enlarged, fit.rms_px));
  for (std::size_t i = 0; i < fit.views.size(); ++i) {
    const FittedView& v = fit.views[i];
    for (std::size_t k = 0; k < v.misses_px.size(); ++k) {
      const cv::Point2d corner = v.view.corners_px[k], miss = v.misses_px[k];
      cv::circle(coverage.image, coverage.at(corner), 2, colour_of(i), cv::FILLED, cv::LINE_AA);
      const cv::Scalar colour = cv::norm(miss) > 3 * fit.rms_px ? red : blue;
      cv::line(misses.image, misses.at(corner), misses.at(corner + miss * enlarged / misses.scale), colour, 1,
               cv::LINE_AA);
    }
  }
  cv::Mat both;
  cv::hconcat(coverage.image, misses.image, both);
  return both;
}

}  // namespace stevedore
