#include "detector_proc/colour_planes.hpp"

#include <opencv2/core/hal/intrin.hpp>

namespace stevedore {
namespace {

#if CV_SIMD
/// Sums over 2x2 pixels of one channel.
cv::v_int16 sums_of_four(const cv::v_uint8& above, const cv::v_uint8& below) {
  cv::v_uint16 low_above, high_above, low_below, high_below;
  cv::v_expand(above, low_above, high_above);
  cv::v_expand(below, low_below, high_below);
  const cv::v_int16 ones = cv::vx_setall_s16(1);
  return cv::v_pack(cv::v_dotprod(cv::v_reinterpret_as_s16(low_above + low_below), ones),
                    cv::v_dotprod(cv::v_reinterpret_as_s16(high_above + high_below), ones));
}
#endif

/// Twice the one, four times the other, for single values and vectors alike; grey: what 128 stands for is
/// half of it.
template <class T>
T red_green(const T& grey, const T& green, const T& red) {
  return grey + red - green;
}

template <class T>
T blue_yellow(const T& grey, const T& blue, const T& green, const T& red) {
  return grey + grey + blue + blue - green - red;
}

/// One of them of single pixels.
template <std::size_t which, class T>
T opponent(const T& grey, const T& blue, const T& green, const T& red) {
  if constexpr (which == 0) return red_green(grey, green, red) >> 1;
  return blue_yellow(grey, blue, green, red) >> 2;
}

template <std::size_t which>
void opponent_row(const uchar* bgr, int width, uchar* out) {
  int u = 0;
#if CV_SIMD
  const cv::v_uint16 grey = cv::vx_setall_u16(256);
  for (; u <= width - cv::v_uint8::nlanes; u += cv::v_uint8::nlanes) {
    cv::v_uint8 blue, green, red;
    cv::v_load_deinterleave(bgr + 3 * u, blue, green, red);
    cv::v_uint16 b0, b1, g0, g1, r0, r1;
    cv::v_expand(blue, b0, b1);
    cv::v_expand(green, g0, g1);
    cv::v_expand(red, r0, r1);
    cv::v_store(out + u, cv::v_pack(opponent<which>(grey, b0, g0, r0), opponent<which>(grey, b1, g1, r1)));
  }
#endif
  for (; u < width; ++u)
    out[u] = static_cast<uchar>(opponent<which, int>(256, bgr[3 * u], bgr[3 * u + 1], bgr[3 * u + 2]));
}

/// One row of both planes, halved, from two of the image.
void halve_rows(const uchar* above, const uchar* below, int width, uchar* red_greens, uchar* blue_yellows) {
  int u = 0;
#if CV_SIMD
  constexpr int lanes = cv::v_uint8::nlanes;
  const cv::v_int16 grey = cv::vx_setall_s16(4 * 256), half_2 = cv::vx_setall_s16(4),
                    half_4 = cv::vx_setall_s16(8);
  for (; u <= width - lanes; u += lanes) {
    const auto half = [&](int from, cv::v_int16& rg, cv::v_int16& by) {
      cv::v_uint8 b0, g0, r0, b1, g1, r1;
      cv::v_load_deinterleave(above + 6 * from, b0, g0, r0);
      cv::v_load_deinterleave(below + 6 * from, b1, g1, r1);
      const cv::v_int16 blue = sums_of_four(b0, b1), green = sums_of_four(g0, g1), red = sums_of_four(r0, r1);
      rg = (red_green(grey, green, red) + half_2) >> 3;
      by = (blue_yellow(grey, blue, green, red) + half_4) >> 4;
    };
    cv::v_int16 first_rg, first_by, second_rg, second_by;
    half(u, first_rg, first_by);
    half(u + lanes / 2, second_rg, second_by);
    cv::v_store(red_greens + u, cv::v_pack_u(first_rg, second_rg));
    cv::v_store(blue_yellows + u, cv::v_pack_u(first_by, second_by));
  }
#endif
  for (; u < width; ++u) {
    const uchar *a = above + 6 * u, *b = below + 6 * u;
    const auto sum = [&](int channel) { return a[channel] + a[channel + 3] + b[channel] + b[channel + 3]; };
    red_greens[u] = static_cast<uchar>((red_green(4 * 256, sum(1), sum(2)) + 4) >> 3);
    blue_yellows[u] = static_cast<uchar>((blue_yellow(4 * 256, sum(0), sum(1), sum(2)) + 8) >> 4);
  }
}

}  // namespace

void compute_opponent(const cv::Mat& bgr, std::size_t which, cv::Mat& plane) {
  plane.create(bgr.size(), CV_8UC1);
  for (int v = 0; v < bgr.rows; ++v) {
    const auto row = which == 0 ? opponent_row<0> : opponent_row<1>;
    row(bgr.ptr(v), bgr.cols, plane.ptr(v));
  }
}

void compute_halved_opponents(const cv::Mat& bgr, std::array<cv::Mat, Opponents::count>& planes) {
  const cv::Size size = bgr.size() / 2;  // an odd last row or column makes no whole pixel
  for (cv::Mat& plane : planes) plane.create(size, CV_8UC1);
  for (int v = 0; v < size.height; ++v)
    halve_rows(bgr.ptr(2 * v), bgr.ptr(2 * v + 1), size.width, planes[0].ptr(v), planes[1].ptr(v));
}

}  // namespace stevedore
