#include "detector_proc/colour_planes.hpp"

#include <opencv2/imgproc.hpp>

namespace stevedore {

void ColourPlanes::compute(const cv::Mat& bgr, int by) {
  const cv::Size size = bgr.size() / by;
  // an odd last row or column makes no whole pixel
  cv::resize(bgr(cv::Rect({0, 0}, size * by)), reduced, size, 0, 0, cv::INTER_AREA);
  for (cv::Mat& plane : planes) plane.create(size, CV_8UC1);
  for (int v = 0; v < size.height; ++v) {
    const uchar* p = reduced.ptr(v);
    uchar *red_green = planes[0].ptr(v), *blue_yellow = planes[1].ptr(v);
    for (int u = 0; u < size.width; ++u) {
      const int blue = p[3 * u], green = p[3 * u + 1], red = p[3 * u + 2];
      red_green[u] = static_cast<uchar>((256 + red - green) >> 1);
      blue_yellow[u] = static_cast<uchar>((512 + 2 * blue - green - red) >> 2);
    }
  }
}

}  // namespace stevedore
