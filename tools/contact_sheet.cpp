#include "tools/contact_sheet.hpp"

#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "tools/draw.hpp"

namespace stevedore {
namespace {

Ellipse ellipse_of(const nlohmann::ordered_json& json) {
  return {json.at("u"), json.at("v"), json.at("a"), json.at("b"), json.at("alpha")};
}

}  // namespace

cv::Mat with_truth(const cv::Mat& picture, const nlohmann::ordered_json& truth) {
  Canvas canvas(picture);
  const auto draw = [&](const nlohmann::ordered_json& json, const Colour& colour, bool whole) {
    if (whole)
      canvas.ellipse(ellipse_of(json), colour, 2);
    else
      canvas.dashed_ellipse(ellipse_of(json), colour, 2);
  };
  for (const auto& circle : truth.at("ellipses"))
    draw(circle, circle.at("occupied") ? green : cyan, circle.at("whole"));
  constexpr double mostly_seen = 0.5;
  for (const auto& cargo : truth.at("cargoes")) draw(cargo, yellow, cargo.at("visible_share") > mostly_seen);
  return canvas.image();
}

cv::Mat contact_sheet(const std::vector<cv::Mat>& pictures, int columns, int width_px) {
  if (pictures.empty()) return {};
  const int height_px = width_px * pictures.front().rows / pictures.front().cols;
  const int rows = (static_cast<int>(pictures.size()) + columns - 1) / columns;
  cv::Mat sheet(rows * height_px, columns * width_px, CV_8UC3, cv::Scalar::all(255));
  for (size_t i = 0; i < pictures.size(); ++i) {
    const int column = static_cast<int>(i) % columns, row = static_cast<int>(i) / columns;
    cv::Mat cell = sheet(cv::Rect(column * width_px, row * height_px, width_px, height_px));
    cv::resize(pictures[i], cell, cell.size(), 0, 0, cv::INTER_AREA);
  }
  return sheet;
}

void write_jpeg(const std::string& path, const cv::Mat& picture, size_t most_bytes) {
  std::vector<uchar> bytes;
  for (int quality = 95; quality >= 10; quality -= 3) {
    cv::imencode(".jpg", picture, bytes, {cv::IMWRITE_JPEG_QUALITY, quality});
    if (bytes.size() <= most_bytes) break;
  }
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!file.flush()) throw std::runtime_error(path + ": not written");
}

}  // namespace stevedore
