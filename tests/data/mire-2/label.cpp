// Labels the large white circle of the image sequence mire-2 in every tenth frame. Stands alone on purpose:
// it shares nothing with the detector (no edges, no contours, no ellipse fitting), so the two can be held
// against each other.
//
//   g++ -std=c++20 -O2 label.cpp -o label $(pkg-config --cflags --libs opencv4)
//   ./label /usr/share/visp-images-data/ViSP-images/mire-2 truth.jsonl mire2_labels.jpg
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <vector>

namespace {

using std::numbers::pi;

struct Label {
  double u, v, a, b, alpha;
};

/// Mean grey level of the pixels that a mask selects.
double level(const cv::Mat& grey, const cv::Mat& mask) {
  return cv::mean(grey, mask)[0];
}

/// Ellipse with the centroid, the area and the axis ratio of the blob. A pixel counts by how much of it is
/// white, from the level of the black card (0) to that of the white paint (1). A filled ellipse has second
/// moments a^2/4 and b^2/4; its size is taken from its area, which motion blur leaves as it is.
Label from_moments(const cv::Mat& grey, const cv::Mat& blob) {
  cv::Mat inside, outside, near;
  const auto disc = [](int r) {
    return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * r + 1, 2 * r + 1});
  };
  cv::erode(blob, inside, disc(5));
  cv::dilate(blob, near, disc(6));
  cv::dilate(blob, outside, disc(10));
  const double white = level(grey, inside), black = level(grey, outside & ~near);
  double m00 = 0, m10 = 0, m01 = 0, m20 = 0, m11 = 0, m02 = 0;
  for (int y = 0; y < grey.rows; ++y)
    for (int x = 0; x < grey.cols; ++x) {
      if (!near.at<uchar>(y, x)) continue;
      const double share = std::clamp((grey.at<uchar>(y, x) - black) / (white - black), 0.0, 1.0);
      // paint and card are not perfectly even: what is nearly one of the two is taken as it
      const double weight = share < 0.06 ? 0 : share > 0.94 ? 1 : share;
      m00 += weight, m10 += weight * x, m01 += weight * y;
      m20 += weight * x * x, m11 += weight * x * y, m02 += weight * y * y;
    }
  const double u = m10 / m00, v = m01 / m00;
  const double suu = m20 / m00 - u * u, suv = m11 / m00 - u * v, svv = m02 / m00 - v * v;
  const double mean = (suu + svv) / 2, spread = std::hypot((suu - svv) / 2, suv);
  const double ratio = std::sqrt((mean + spread) / (mean - spread));
  return {u, v, std::sqrt(m00 / pi * ratio), std::sqrt(m00 / pi / ratio), std::atan2(2 * suv, suu - svv) / 2};
}

/// The largest bright blob that is as large as its own ellipse (a filled one), inside the image and not a
/// small circle.
std::optional<Label> large_circle(const cv::Mat& grey) {
  cv::Mat labels, statistics, centroids;
  const int count = cv::connectedComponentsWithStats(grey > 140, labels, statistics, centroids, 4);
  std::optional<Label> best;
  for (int i = 1; i < count; ++i) {
    const int area = statistics.at<int>(i, cv::CC_STAT_AREA);
    const int x = statistics.at<int>(i, cv::CC_STAT_LEFT), width = statistics.at<int>(i, cv::CC_STAT_WIDTH);
    const int y = statistics.at<int>(i, cv::CC_STAT_TOP), height = statistics.at<int>(i, cv::CC_STAT_HEIGHT);
    if (area < 800 || x == 0 || y == 0 || x + width == grey.cols || y + height == grey.rows) continue;
    const cv::Moments m = cv::moments(labels == i, true);
    const double filled = 4 * pi * std::sqrt(m.mu20 * m.mu02 - m.mu11 * m.mu11) / m.m00 / area;
    if (filled > 1.03) continue;
    const Label label = from_moments(grey, labels == i);
    if (!best || label.a * label.b > best->a * best->b) best = label;
  }
  return best;
}

/// A piece of the frame around the label, enlarged, with the label in red and the frame's number.
cv::Mat piece(const cv::Mat& grey, const std::optional<Label>& label, int frame) {
  const int half_u = 45, half_v = 40, zoom = 2;
  const cv::Point2d centre =
      label ? cv::Point2d(std::round(label->u), std::round(label->v)) : cv::Point2d(192, 144);
  cv::Mat cut, colour;
  cv::getRectSubPix(grey, {2 * half_u + 1, 2 * half_v + 1}, cv::Point2f(centre), cut);
  cv::resize(cut, cut, {}, zoom, zoom, cv::INTER_NEAREST);
  cv::cvtColor(cut, colour, cv::COLOR_GRAY2BGR);
  if (label) {
    std::vector<cv::Point> outline;
    const double c = std::cos(label->alpha), s = std::sin(label->alpha);
    for (double t = 0; t < 2 * pi; t += 0.05) {
      const double along = label->a * std::cos(t), across = label->b * std::sin(t);
      const double u = label->u + c * along - s * across - centre.x + half_u;
      const double v = label->v + s * along + c * across - centre.y + half_v;
      // 4 fractional bits; the centre of a pixel lies in the middle of its zoomed square
      outline.emplace_back(int(std::lround(16 * (zoom * (u + 0.5) - 0.5))),
                           int(std::lround(16 * (zoom * (v + 0.5) - 0.5))));
    }
    cv::polylines(colour, outline, true, {0, 0, 255}, 1, cv::LINE_AA, 4);
  }
  cv::putText(colour, std::to_string(frame), {3, 12}, cv::FONT_HERSHEY_SIMPLEX, 0.4, {0, 255, 255});
  return colour;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 4) return std::cerr << "usage: label FOLDER TRUTH.jsonl SHEET.jpg\n", 2;
  std::ofstream truth(argv[2]);
  std::vector<cv::Mat> rows, row;
  for (int frame = 1; frame <= 501; frame += 10) {
    char name[32], line[256];
    std::snprintf(name, sizeof name, "image.%04d.pgm", frame);
    const cv::Mat grey = cv::imread(std::string(argv[1]) + "/" + name, cv::IMREAD_GRAYSCALE);
    if (grey.empty()) return std::cerr << "cannot read " << name << "\n", 1;
    const auto label = large_circle(grey);
    if (!label) return std::cerr << name << ": no circle\n", 1;
    std::snprintf(line, sizeof line,
                  "{\"image\": \"mire-2/%s\", \"labelled\": true, \"ellipses\": [{\"u\": %.3f, \"v\": %.3f, "
                  "\"a\": %.3f, \"b\": %.3f, \"alpha\": %.5f, \"whole\": true}]}\n",
                  name, label->u, label->v, label->a, label->b, label->alpha);
    truth << line;
    row.push_back(piece(grey, label, frame));
    if (row.size() == 9 || frame == 501) {
      while (row.size() < 9) row.push_back(cv::Mat::zeros(row[0].size(), row[0].type()));
      rows.emplace_back();
      cv::hconcat(row, rows.back());
      row.clear();
    }
  }
  cv::Mat sheet;
  cv::vconcat(rows, sheet);
  return cv::imwrite(argv[3], sheet, {cv::IMWRITE_JPEG_QUALITY, 75}) ? 0 : 1;
}
