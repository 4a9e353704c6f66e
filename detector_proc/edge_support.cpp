#include "detector_proc/edge_support.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "detector_proc/arcs.hpp"
#include "detector_proc/ellipse_distance.hpp"

namespace stevedore {
namespace {

/// Cosine and sine of 256 directions.
struct Circle {
  static constexpr int size = 256;
  std::array<float, size> cosine, sine;
};

const Circle& unit_circle() {
  static const Circle circle = [] {
    Circle c{};
    for (int k = 0; k < Circle::size; ++k) {
      const double t = 2 * std::numbers::pi * k / Circle::size;
      c.cosine[static_cast<std::size_t>(k)] = static_cast<float>(std::cos(t));
      c.sine[static_cast<std::size_t>(k)] = static_cast<float>(std::sin(t));
    }
    return c;
  }();
  return circle;
}

/// One search along a normal.
class NormalSearch {
 public:
  NormalSearch(const GradientField& field, Bright bright, float band_px, int threshold)
      : gradient_(field.gradient.ptr<short>()),
        width_(field.magnitude.cols),
        height_(field.magnitude.rows),
        sign_(bright == Bright::within ? -1.F : 1.F),
        band_px_(band_px),
        threshold_(static_cast<float>(threshold)) {}

  /// From the point (u, v), outward normal (nu, nv).
  void search(float u, float v, float nu, float nv, EdgeSample& sample) const {
    // one pixel a step along the axis nearer to the normal, the nearest pixel across it
    const bool along_u = std::abs(nu) >= std::abs(nv);
    const float major = along_u ? nu : nv, minor = along_u ? nv : nu;
    const float from = along_u ? u : v, other_from = along_u ? v : u;
    const int step = along_u ? 1 : width_, across = along_u ? width_ : 1;
    const int limit = (along_u ? width_ : height_) - 2, other_limit = (along_u ? height_ : width_) - 2;
    const int reach = static_cast<int>(band_px_ * std::abs(major) + 0.5F);
    const int middle = static_cast<int>(from + 0.5F);
    const int first = std::max(middle - reach, 1), last = std::min(middle + reach, limit);
    const float slope = minor / major;
    float other = other_from + (static_cast<float>(first) - from) * slope + 0.5F;
    int best_pixel = -1, best_i = 0, best_j = 0;
    float best = threshold_;
    for (int i = first; i <= last; ++i, other += slope) {
      const int j = std::clamp(static_cast<int>(other), 1, other_limit);
      const int pixel = i * step + j * across;
      const float s = along(pixel, nu, nv);
      if (s > best) best = s, best_pixel = pixel, best_i = i, best_j = j;
    }
    if (best_pixel < 0) return;
    const float gu = gradient_[2 * best_pixel], gv = gradient_[2 * best_pixel + 1];
    const float square = gu * gu + gv * gv;
    if (best * best < 0.82F * square) return;  // cos^2 of 25 degrees
    const float before = along(best_pixel - step, nu, nv), behind = along(best_pixel + step, nu, nv);
    const float curvature = 2 * best - before - behind;
    const float vertex = curvature > 0 ? std::clamp(0.5F * (behind - before) / curvature, -1.F, 1.F) : 0;
    sample.found = true;
    sample.strength = best;
    sample.offset_px = (static_cast<float>(best_i) + vertex - from) * major +
                       (static_cast<float>(best_j) - other_from) * minor;
    const float inverse = 1 / std::sqrt(square);
    sample.point = {u + sample.offset_px * nu, v + sample.offset_px * nv, gv * inverse, -gu * inverse};
  }

 private:
  [[nodiscard]] float along(int pixel, float nu, float nv) const {
    return sign_ * (static_cast<float>(gradient_[2 * pixel]) * nu +
                    static_cast<float>(gradient_[2 * pixel + 1]) * nv);
  }

  const short* gradient_;
  int width_, height_;
  float sign_;
  float band_px_;
  float threshold_;
};

void sum_up(EdgeSupport& support) {
  support.perimeter_px = support.visible_px = support.supported_px = 0;
  support.rms_px = support.strength = support.unevenness = 0;
  double squares = 0, strengths = 0, strength_squares = 0, found = 0;
  for (int k = 0; k < support.count; ++k) {
    const EdgeSample& s = support.samples[static_cast<std::size_t>(k)];
    support.perimeter_px += s.length_px;
    if (s.in_frame) support.visible_px += s.length_px;
    if (!s.found) continue;
    support.supported_px += s.length_px;
    squares += s.offset_px * s.offset_px;
    strengths += s.strength;
    strength_squares += s.strength * s.strength;
    ++found;
  }
  if (found == 0) return;
  support.rms_px = std::sqrt(squares / found);
  support.strength = strengths / found;
  const double variance = strength_squares / found - support.strength * support.strength;
  support.unevenness = std::sqrt(std::max(variance, 0.0)) / support.strength;
}

/// One weighted fit to the edges found.
std::optional<Ellipse> weighted_fit(const EdgeSupport& support, const Ellipse& ellipse,
                                    double least_deviation_px) {
  const double tolerance = outlier_limit_px(support, least_deviation_px);
  const FitFrame frame{ellipse.u_px, ellipse.v_px, ellipse.a_px};
  ConicSums sums;
  int used = 0;
  for (int k = 0; k < support.count; ++k) {
    const EdgeSample& s = support.samples[static_cast<std::size_t>(k)];
    const double ratio = s.offset_px / tolerance;
    if (!s.found || std::abs(ratio) >= 1) continue;
    ++used;
    // |grad Q| at a point of the ellipse is proportional to its tangent's length in the parameter t
    const double tukey = (1 - ratio * ratio) * (1 - ratio * ratio) / (s.length_px * s.length_px);
    sums.add(s.point, frame, tukey, tangent_lever_px);
  }
  return used >= 6 ? sums.solve(frame) : std::nullopt;
}

}  // namespace

int sample_count(const Ellipse& ellipse) {
  return std::clamp(static_cast<int>(perimeter_px(ellipse) / 3), 24, EdgeSupport::max_samples);
}

EdgeSupport look_along(const GradientField& field, const Ellipse& e, Bright bright, double band_px,
                       int threshold, int count) {
  const Circle& circle = unit_circle();
  const NormalSearch search(field, bright, static_cast<float>(band_px), threshold);
  const float c = static_cast<float>(std::cos(e.alpha_rad)), s = static_cast<float>(std::sin(e.alpha_rad));
  const float a = static_cast<float>(e.a_px), b = static_cast<float>(e.b_px);
  const float u0 = static_cast<float>(e.u_px), v0 = static_cast<float>(e.v_px);
  const float right = static_cast<float>(field.magnitude.cols - 1),
              bottom = static_cast<float>(field.magnitude.rows - 1);
  const float step_rad = 2 * std::numbers::pi_v<float> / static_cast<float>(count);
  EdgeSupport support;
  support.count = count;
  for (int k = 0; k < count; ++k) {
    const auto t = static_cast<std::size_t>(k * Circle::size / count);
    const float ct = circle.cosine[t], st = circle.sine[t];
    const float x = a * ct, y = b * st, nx = b * ct, ny = a * st;
    const float speed = std::sqrt(nx * nx + ny * ny);  // also the length of the tangent (-a sin, b cos)
    EdgeSample& sample = support.samples[static_cast<std::size_t>(k)];
    sample.length_px = speed * step_rad;
    const float u = u0 + c * x - s * y, v = v0 + s * x + c * y;
    sample.in_frame = u > 1 && v > 1 && u < right - 1 && v < bottom - 1;
    if (sample.in_frame) search.search(u, v, (c * nx - s * ny) / speed, (s * nx + c * ny) / speed, sample);
  }
  sum_up(support);
  return support;
}

void drop_outliers(EdgeSupport& support) {
  const double limit = std::min(outlier_limit_px(support, 0.06), 1.0);
  for (int k = 0; k < support.count; ++k) {
    EdgeSample& s = support.samples[static_cast<std::size_t>(k)];
    s.found = s.found && std::abs(s.offset_px) < limit;
  }
  sum_up(support);
}

double outlier_limit_px(const EdgeSupport& support, double least_deviation_px) {
  // the median to a sixteenth of a pixel will do
  constexpr int bins = 128;
  constexpr float per_px = 16;
  std::array<int, bins> histogram{};
  int found = 0;
  for (int k = 0; k < support.count; ++k) {
    const EdgeSample& s = support.samples[static_cast<std::size_t>(k)];
    if (!s.found) continue;
    ++histogram[static_cast<std::size_t>(std::min(std::abs(s.offset_px) * per_px, bins - 1.F))];
    ++found;
  }
  int bin = 0;
  for (int below = 0; bin < bins - 1; ++bin) {
    below += histogram[static_cast<std::size_t>(bin)];
    if (2 * below > found) break;
  }
  const double median_px = (bin + 0.5) / per_px;
  return 4.7 * std::max(1.48 * median_px, least_deviation_px);
}

void measure_from(EdgeSupport& support, const Ellipse& e) {
  const EllipseDistance distance(e);
  for (int k = 0; k < support.count; ++k) {
    EdgeSample& s = support.samples[static_cast<std::size_t>(k)];
    if (s.found) s.offset_px = static_cast<float>(distance(s.point.u_px, s.point.v_px));
  }
}

std::optional<Ellipse> refit(EdgeSupport& support, const Ellipse& ellipse) {
  std::optional<Ellipse> e = ellipse;
  // from a scale that lets every edge's own error pass to one that leaves out what runs along at half a pixel
  for (const double least_deviation_px : {0.3, 0.2, 0.1}) {
    e = weighted_fit(support, *e, least_deviation_px);
    if (!e) return std::nullopt;
    measure_from(support, *e);
  }
  return e;
}

}  // namespace stevedore
