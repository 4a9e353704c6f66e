// Rendered scenes for the detector's tests: ellipses with exact coverage of edge pixels.
#pragma once

#include <cmath>
#include <opencv2/core.hpp>
#include <random>

#include "geometry/ellipse.hpp"

namespace stevedore {

/// Paints an ellipse, edge pixels by the share of them that it covers (8x8 samples).
inline void paint(cv::Mat& image, const Ellipse& e, const cv::Scalar& color) {
  constexpr int grid = 8;
  const int reach = static_cast<int>(std::ceil(e.a_px)) + 2;
  const cv::Point centre(static_cast<int>(std::lround(e.u_px)), static_cast<int>(std::lround(e.v_px)));
  const cv::Rect around = cv::Rect(centre.x - reach, centre.y - reach, 2 * reach + 1, 2 * reach + 1) &
                          cv::Rect({0, 0}, image.size());
  for (int v = around.y; v < around.y + around.height; ++v) {
    for (int u = around.x; u < around.x + around.width; ++u) {
      int inside = 0;
      for (int k = 0; k < grid * grid; ++k) {
        const Eigen::Vector2d p(u + (k % grid + 0.5) / grid - 0.5, v + (k / grid + 0.5) / grid - 0.5);
        if (normalized_radius_squared(e, p) < 1) ++inside;
      }
      const double share = inside / static_cast<double>(grid * grid);
      for (int c = 0; c < image.channels(); ++c) {
        uchar& level = image.ptr<uchar>(v, u)[c];
        level = cv::saturate_cast<uchar>(level + share * (color[c] - level));
      }
    }
  }
}

inline cv::Mat grey_image(int width, int height, int level) {
  return cv::Mat(height, width, CV_8UC1, cv::Scalar(level));
}

inline void add_noise(cv::Mat& image, double sigma, std::mt19937& random) {
  std::normal_distribution<double> noise(0, sigma);
  for (int v = 0; v < image.rows; ++v) {
    uchar* row = image.ptr<uchar>(v);
    for (int i = 0; i < image.cols * image.channels(); ++i)
      row[i] = cv::saturate_cast<uchar>(row[i] + noise(random));
  }
}

/// Pixels that the ellipse runs through, at equal steps of its parameter, from t = 0 for a share of the turn.
inline std::vector<cv::Point> pixels_of(const Ellipse& e, double share = 1) {
  std::vector<cv::Point> points;
  const int n = static_cast<int>(perimeter_px(e) * share);
  for (int i = 0; i < n; ++i) {
    const Eigen::Vector2d p = point_at(e, 2 * M_PI * share * i / n);
    points.emplace_back(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
  }
  return points;
}

}  // namespace stevedore
