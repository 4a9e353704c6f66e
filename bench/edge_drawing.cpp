// OpenCV's EdgeDrawing::detectEllipses (Akinlar and Topal 2013) on image files, its answers in the form of
// `locate`: what a detector of ours is compared with, and how hard `scenes` are.
//   edge_drawing IMAGE... > found.jsonl
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/ximgproc/edge_drawing.hpp>

#include "geometry/ellipse.hpp"

namespace {

using Json = nlohmann::ordered_json;

/// x, y, radius of a circle (else 0), semi-axes of an ellipse (else 0), angle in degrees.
Json json_of(const cv::Vec6d& found) {
  const bool is_circle = found[2] > 0;
  const stevedore::Ellipse e =
      stevedore::normalized({found[0], found[1], is_circle ? found[2] : found[3],
                             is_circle ? found[2] : found[4], found[5] * std::numbers::pi / 180});
  return {{"u", e.u_px}, {"v", e.v_px},          {"a", e.a_px},
          {"b", e.b_px}, {"alpha", e.alpha_rad}, {"label", "unknown"}};
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  const auto detector = cv::ximgproc::createEdgeDrawing();
  for (int i = 1; i < argc; ++i) {
    cv::Mat gray = cv::imread(argv[i], cv::IMREAD_GRAYSCALE);
    if (gray.empty()) {
      std::cerr << argv[i] << ": not a readable image\n";
      return 1;
    }
    const int64_t begin = cv::getTickCount();
    detector->detectEdges(gray);
    std::vector<cv::Vec6d> found;
    detector->detectEllipses(found);
    const double ms = 1000 * static_cast<double>(cv::getTickCount() - begin) / cv::getTickFrequency();
    Json line{{"image", argv[i]}, {"width", gray.cols}, {"height", gray.rows}, {"detect_ms", ms}};
    line["ellipses"] = Json::array();
    for (const cv::Vec6d& each : found) line["ellipses"].push_back(json_of(each));
    std::cout << line.dump() << '\n';
  }
  return 0;
}
