#include "detector_proc/gradient_field.hpp"

#include <algorithm>
#include <array>
#include <opencv2/core/hal/intrin.hpp>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace stevedore {
namespace {

constexpr int reach = 2;  // of the 5x5 kernels

/// Sums over a column of five rows: smoothed (1 4 6 4 1) and derived (-1 -2 0 2 1). At most 16 * 255.
void filter_columns(const std::array<const uchar*, 5>& rows, int width, short* smooth, short* derived) {
  int u = 0;
#if CV_SIMD
  for (; u <= width - cv::v_int16::nlanes; u += cv::v_int16::nlanes) {
    const auto load = [&](std::size_t k) {
      return cv::v_reinterpret_as_s16(cv::vx_load_expand(rows[k] + u));
    };
    const cv::v_int16 r0 = load(0), r1 = load(1), r2 = load(2), r3 = load(3), r4 = load(4);
    const cv::v_int16 inner = (r1 + r3 + r2) << 2;
    cv::v_store(smooth + u, r0 + r4 + inner + (r2 << 1));
    cv::v_store(derived + u, (r4 - r0) + ((r3 - r1) << 1));
  }
#endif
  for (; u < width; ++u) {
    const int r0 = rows[0][u], r1 = rows[1][u], r2 = rows[2][u], r3 = rows[3][u], r4 = rows[4][u];
    smooth[u] = static_cast<short>(r0 + r4 + 4 * (r1 + r3) + 6 * r2);
    derived[u] = static_cast<short>(r4 - r0 + 2 * (r3 - r1));
  }
}

/// Repeats the outermost values `reach` times on either side.
void extend(short* row, int width) {
  for (int k = 1; k <= reach; ++k) {
    row[-k] = row[0];
    row[width - 1 + k] = row[width - 1];
  }
}

/// max + 3/8 min of the absolute values: within -2.8 % and +6.8 % of Euclid's.
int octagonal(int du, int dv) {
  const int high = std::max(std::abs(du), std::abs(dv)), low = std::min(std::abs(du), std::abs(dv));
  return high + (low >> 2) + (low >> 3);
}

/// Sums along a row: the gradient and its magnitude. At most 48 * 255 each, 1.38 times that the magnitude.
void filter_row(const short* smooth, const short* derived, int width, short* gradient, ushort* magnitude) {
  int u = 0;
#if CV_SIMD
  for (; u <= width - cv::v_int16::nlanes; u += cv::v_int16::nlanes) {
    const auto s = [&](int k) { return cv::vx_load(smooth + u + k); };
    const auto d = [&](int k) { return cv::vx_load(derived + u + k); };
    const cv::v_int16 du = (s(2) - s(-2)) + ((s(1) - s(-1)) << 1);
    const cv::v_int16 centre = d(0);
    const cv::v_int16 dv = d(-2) + d(2) + ((d(-1) + d(1) + centre) << 2) + (centre << 1);
    cv::v_store_interleave(gradient + 2 * u, du, dv);
    const cv::v_uint16 x = cv::v_abs(du), y = cv::v_abs(dv);
    const cv::v_uint16 low = cv::v_min(x, y);
    cv::v_store(magnitude + u, cv::v_max(x, y) + (low >> 2) + (low >> 3));
  }
#endif
  for (; u < width; ++u) {
    const short *s = smooth + u, *d = derived + u;
    const int du = s[2] - s[-2] + 2 * (s[1] - s[-1]);
    const int dv = d[-2] + d[2] + 4 * (d[-1] + d[1]) + 6 * d[0];
    gradient[2 * u] = static_cast<short>(du);
    gradient[2 * u + 1] = static_cast<short>(dv);
    magnitude[u] = static_cast<ushort>(octagonal(du, dv));
  }
}

void clear_border(cv::Mat& magnitude) {
  magnitude.row(0).setTo(0);
  magnitude.row(magnitude.rows - 1).setTo(0);
  for (int v = 0; v < magnitude.rows; ++v) {
    ushort* row = magnitude.ptr<ushort>(v);
    row[0] = row[magnitude.cols - 1] = 0;
  }
}

}  // namespace

void compute_gradient(const cv::Mat& image, GradientField& field) {
  const bool has_colour = image.channels() == 3;
  if (has_colour) cv::cvtColor(image, field.grey, cv::COLOR_BGR2GRAY);
  const cv::Mat& grey = has_colour ? field.grey : image;
  const int width = image.cols, height = image.rows;
  field.gradient.create(height, width, CV_16SC2);
  field.magnitude.create(height, width, CV_16UC1);
  std::vector<short> smooth(static_cast<std::size_t>(width + 2 * reach)), derived(smooth.size());
  for (int v = 0; v < height; ++v) {
    std::array<const uchar*, 5> rows{};
    for (int k = -reach; k <= reach; ++k) {
      rows[static_cast<std::size_t>(k + reach)] = grey.ptr(std::clamp(v + k, 0, height - 1));
    }
    filter_columns(rows, width, smooth.data() + reach, derived.data() + reach);
    extend(smooth.data() + reach, width);
    extend(derived.data() + reach, width);
    filter_row(smooth.data() + reach, derived.data() + reach, width, field.gradient.ptr<short>(v),
               field.magnitude.ptr<ushort>(v));
  }
  clear_border(field.magnitude);
}

}  // namespace stevedore
