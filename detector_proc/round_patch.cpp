#include "detector_proc/round_patch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace stevedore {
namespace {

/// Into what was strongest of the planes before: the larger of the two, pixel by pixel.
void take_stronger(const short* along, const short* down, int* best_along, int* best_down, int* squares) {
  for (int u = 1; u < patch_px - 1; ++u) {
    const int du = along[u], dv = down[u], square = du * du + dv * dv;
    const bool stronger = square > squares[u];
    best_along[u] = stronger ? du : best_along[u];
    best_down[u] = stronger ? dv : best_down[u];
    squares[u] = stronger ? square : squares[u];
  }
}

/// To a sixteenth, of every second pixel of every second row.
float median_of(const cv::Mat_<float>& levels) {
  std::array<int, 4096> histogram{};
  int count = 0;
  for (int v = 0; v < levels.rows; v += 2)
    for (int u = 0; u < levels.cols; u += 2, ++count)
      ++histogram[static_cast<std::size_t>(std::min(16 * levels(v, u), 4095.F))];
  std::size_t median = 0;
  for (int below = histogram[0]; 2 * below < count; below += histogram[median]) ++median;
  return static_cast<float>(median) / 16;
}

}  // namespace

cv::Matx23d image_from_patch(const Ellipse& e) {
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad), a = e.a_px / unit_px,
               b = e.b_px / unit_px;
  return {a * c, -b * s, e.u_px - middle_px * (a * c - b * s),  //
          a * s, b * c,  e.v_px - middle_px * (a * s + b * c)};
}

Eigen::Vector3d in_patch(const Ellipse& edge, const Ellipse& circle) {
  const double c = std::cos(circle.alpha_rad), s = std::sin(circle.alpha_rad);
  const double u = edge.u_px - circle.u_px, v = edge.v_px - circle.v_px;
  return {middle_px + unit_px * (c * u + s * v) / circle.a_px,
          middle_px + unit_px * (c * v - s * u) / circle.b_px,
          unit_px * std::sqrt(edge.a_px * edge.b_px / (circle.a_px * circle.b_px))};
}

double share_in_view(const Ellipse& e, cv::Size size) {
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad);
  int in = 0, all = 0;
  for (double x = -0.95; x < 1; x += 0.1) {
    for (double y = -0.95; y < 1; y += 0.1) {
      if (x * x + y * y > 1) continue;
      const double u = e.u_px + e.a_px * x * c - e.b_px * y * s, v = e.v_px + e.a_px * x * s + e.b_px * y * c;
      ++all;
      in += u >= 0 && v >= 0 && u < size.width && v < size.height ? 1 : 0;
    }
  }
  return static_cast<double>(in) / all;
}

RoundPatch round_patch(const cv::Mat& image, Ellipse e) {
  cv::Mat source = image;
  if (const int reduction = static_cast<int>(e.b_px / unit_px); reduction > 1) {
    // of the neighbourhood alone, and by whole pixels' means, so that nothing is aliased
    const double reach_px = 1.45 * e.a_px;
    const cv::Rect box = cv::Rect(cv::Point(cvFloor(e.u_px - reach_px), cvFloor(e.v_px - reach_px)),
                                  cv::Point(cvCeil(e.u_px + reach_px), cvCeil(e.v_px + reach_px))) &
                         cv::Rect({0, 0}, image.size());
    if (box.width < reduction || box.height < reduction) return {{}, {}};
    cv::resize(image(box), source, box.size() / reduction, 0, 0, cv::INTER_AREA);
    const double scale_u = static_cast<double>(source.cols) / box.width,
                 scale_v = static_cast<double>(source.rows) / box.height;
    e.u_px = (e.u_px - box.x + 0.5) * scale_u - 0.5;
    e.v_px = (e.v_px - box.y + 0.5) * scale_v - 0.5;
    e.a_px *= scale_u;
    e.b_px *= scale_u;
  }
  RoundPatch patch{{}, cv::Mat_<std::uint8_t>(patch_px, patch_px)};
  const cv::Matx23d m = image_from_patch(e);
  cv::warpAffine(source, patch.pixels, m, {patch_px, patch_px}, cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                 cv::BORDER_REPLICATE);
  const auto has = [&](int v, int u) {
    const double x = m(0, 0) * u + m(0, 1) * v + m(0, 2), y = m(1, 0) * u + m(1, 1) * v + m(1, 2);
    return x >= 0 && y >= 0 && x <= source.cols - 1 && y <= source.rows - 1;
  };
  constexpr int last = patch_px - 1;
  if (has(0, 0) && has(0, last) && has(last, 0) && has(last, last)) {
    patch.seen.setTo(1);
    return patch;
  }
  for (int v = 0; v < patch_px; ++v)
    for (int u = 0; u < patch_px; ++u) patch.seen(v, u) = has(v, u) ? 1 : 0;
  return patch;
}

PatchEdges edges_of(const RoundPatch& patch) {
  cv::Mat smooth;
  cv::GaussianBlur(patch.pixels, smooth, {5, 5}, 1.0);
  std::vector<cv::Mat> planes;
  cv::split(smooth, planes);
  cv::Mat_<int> squares(patch_px, patch_px, 0), along(patch_px, patch_px, 0), down(patch_px, patch_px, 0);
  cv::Mat_<short> du, dv;
  for (const cv::Mat& plane : planes) {
    cv::spatialGradient(plane, du, dv);
    for (int v = 1; v < patch_px - 1; ++v) take_stronger(du[v], dv[v], along[v], down[v], squares[v]);
  }
  squares.setTo(0, patch.seen == 0);
  constexpr float per_level = 8;  // the 3x3 derivative of a slope of one level a pixel
  PatchEdges edges;
  along.convertTo(edges.along, CV_32F, 1 / per_level);
  down.convertTo(edges.down, CV_32F, 1 / per_level);
  squares.convertTo(edges.magnitude, CV_32F, 1 / (per_level * per_level));
  cv::sqrt(edges.magnitude, edges.magnitude);
  // noise and texture have the median; an edge of less than two grey levels a pixel is none to be trusted
  edges.threshold = std::max(2.F, 2 * median_of(edges.magnitude));
  return edges;
}

}  // namespace stevedore
