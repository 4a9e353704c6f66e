#include "detector_proc/affine_moments.hpp"

#include <cmath>

namespace stevedore {

std::optional<AffineMoments> affine_moments(const cv::Moments& m) {
  if (!(std::abs(m.m00) > 0)) return std::nullopt;
  const double i1 = m.mu20 * m.mu02 - m.mu11 * m.mu11;
  const double i2 = m.mu30 * m.mu30 * m.mu03 * m.mu03 - 6 * m.mu30 * m.mu21 * m.mu12 * m.mu03 +
                    4 * m.mu30 * m.mu12 * m.mu12 * m.mu12 + 4 * m.mu21 * m.mu21 * m.mu21 * m.mu03 -
                    3 * m.mu21 * m.mu21 * m.mu12 * m.mu12;
  const double i3 = m.mu20 * (m.mu21 * m.mu03 - m.mu12 * m.mu12) -
                    m.mu11 * (m.mu30 * m.mu03 - m.mu21 * m.mu12) +
                    m.mu02 * (m.mu30 * m.mu12 - m.mu21 * m.mu21);
  return AffineMoments{i1 / std::pow(m.m00, 4), i2 / std::pow(m.m00, 10), i3 / std::pow(m.m00, 7)};
}

}  // namespace stevedore
