// Looking for the few values that count.
#pragma once

#include <algorithm>
#include <opencv2/core.hpp>
#include <opencv2/core/hal/intrin.hpp>

namespace stevedore {

/// Calls visit(u) for every value of the row that is above the limit; most are not.
template <class Visit>
void for_each_above(const ushort* row, int width, int limit, Visit visit) {
  int u = 0;
#if CV_SIMD
  const cv::v_uint16 limits = cv::vx_setall_u16(static_cast<ushort>(std::min(limit, 65535)));
  for (; u <= width - cv::v_uint16::nlanes; u += cv::v_uint16::nlanes) {
    if (!cv::v_check_any(cv::vx_load(row + u) > limits)) continue;
    for (int k = u; k < u + cv::v_uint16::nlanes; ++k) {
      if (row[k] > limit) visit(k);
    }
  }
#endif
  for (; u < width; ++u) {
    if (row[u] > limit) visit(u);
  }
}

}  // namespace stevedore
