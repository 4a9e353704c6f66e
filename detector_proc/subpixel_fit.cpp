#include "detector_proc/subpixel_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core/hal/intrin.hpp>
#include <vector>

namespace stevedore {
namespace {

using std::numbers::pi;
using Row = Eigen::Matrix<double, 5, 1>;

constexpr int most_pixels = 32;         ///< of one strip: 10 px to either side of a diagonal edge
constexpr double widest_blur_px = 3.5;  ///< whose strips are as long

/// One row or column of pixels across the edge.
struct Strip {
  Strip() {}  // NOLINT(modernize-use-equals-default): pixels stay unset, it costs a third of filling them in

  Row shift;                                   ///< of the edge there by the parameters
  double curvature;                            ///< 1 / px
  double share;                                ///< of a row or column that this strip stands for
  int count = 0;                               ///< of pixels; the rest of the last four are `nowhere`
  std::array<float, most_pixels> distance_px;  ///< outwards from the ellipse
  std::array<float, most_pixels> light;
  double inside = 0, outside = 0;          ///< levels
  double offset_px = 0, variance_px2 = 0;  ///< of the edge from the ellipse, in light^2 of noise
  double blur_gain = 0, blur_weight = 0;   ///< least-squares step of the blur
  bool used = false;
};

constexpr float nowhere_px = 1e4F;

/// The normal distribution at four places, to 1e-5; beyond six deviations as there.
struct Normal {
  cv::v_float32x4 cdf, density;

  explicit Normal(cv::v_float32x4 z) {
    const auto all = [](float value) { return cv::v_setall_f32(value); };
    const cv::v_float32x4 one = all(1);
    // exp(-z^2 / 2) as a power of two: a whole one, and a series for the rest, within a half
    const cv::v_float32x4 power = z * z * all(-0.5F * std::numbers::log2e_v<float>);
    const cv::v_int32x4 whole = cv::v_round(power);
    const cv::v_float32x4 x = (power - cv::v_cvt_f32(whole)) * all(std::numbers::ln2_v<float>);
    const cv::v_float32x4 rest =
        one + x * (one + x * (all(1.F / 2) + x * (all(1.F / 6) + x * (all(1.F / 24) + x * all(1.F / 120)))));
    const cv::v_float32x4 two_to_whole =
        cv::v_reinterpret_as_f32((whole + cv::v_setall_s32(127)) << 23);  // the exponent of a float
    density = rest * two_to_whole * all(std::numbers::inv_sqrtpi_v<float> / std::numbers::sqrt2_v<float>);
    // Abramowitz and Stegun 1964, 26.2.16
    const cv::v_float32x4 t = one / (one + all(0.33267F) * cv::v_abs(z));
    const cv::v_float32x4 tail =
        density * t * (all(0.4361836F) + t * (all(-0.1201676F) + t * all(0.937298F)));
    cdf = cv::v_select(z > all(0), one - tail, tail);
  }
};

/// Strips at the places where the edge crosses the rows (or columns, whichever it crosses more squarely).
class StripCutter {
 public:
  StripCutter(const LightImage& image, const Ellipse& e, double half_width_px)
      : image_(image),
        e_(e),
        c_(std::cos(e.alpha_rad)),
        s_(std::sin(e.alpha_rad)),
        half_width_px_(half_width_px) {}

  /// One for every row or column, where there is more than one each counts for less.
  void cut(int most_strips, std::vector<Strip>& strips) const {
    strips.clear();
    const int all = static_cast<int>(2 * pi * e_.a_px) + 8;
    const int count = most_strips > 0 ? std::min(all, most_strips) : all;
    const double step_rad = 2 * pi / count, step_cosine = std::cos(step_rad), step_sine = std::sin(step_rad);
    double cosine = 1, sine = 0;
    for (int k = 0; k < count; ++k) {
      add(cosine, sine, step_rad, strips);
      const double next = cosine * step_cosine - sine * step_sine;
      sine = sine * step_cosine + cosine * step_sine;
      cosine = next;
    }
  }

 private:
  void add(double ct, double st, double step_rad, std::vector<Strip>& strips) const {
    const double x = e_.a_px * ct, y = e_.b_px * st, nx = e_.b_px * ct, ny = e_.a_px * st;
    const double speed = std::sqrt(nx * nx + ny * ny);
    const double u = e_.u_px + c_ * x - s_ * y, v = e_.v_px + s_ * x + c_ * y;
    const double nu = (c_ * nx - s_ * ny) / speed, nv = (s_ * nx + c_ * ny) / speed;
    const bool along_u = std::abs(nu) >= std::abs(nv);
    const double major = along_u ? nu : nv;
    const double from = along_u ? u : v, other = along_u ? v : u;
    const int row = cvRound(other);
    const int limit = along_u ? image_.width() : image_.height(),
              row_limit = along_u ? image_.height() : image_.width();
    if (row < 0 || row >= row_limit) return;
    const double reach = half_width_px_ / std::abs(major);
    const int first = cvCeil(from - reach), last = cvFloor(from + reach);
    if (first < 0 || last >= limit || last - first >= most_pixels) return;
    Strip& strip = strips.emplace_back();
    const double along = nx / speed, across = ny / speed;  // the normal, in the axes' frame
    strip.shift << nu, nv, along * ct, across * st, across * x - along * y;
    strip.curvature = e_.a_px * e_.b_px / (speed * speed * speed);
    strip.share = std::min(1.0, speed * step_rad * std::abs(major));
    const auto major_f = static_cast<float>(major), minor_f = static_cast<float>(along_u ? nv : nu);
    const auto side = static_cast<float>(row - other), bend = static_cast<float>(strip.curvature / 2);
    strip.count = last - first + 1;
    image_.read(along_u ? first : row, along_u ? row : first, along_u, strip.count, strip.light.data());
    for (std::size_t k = 0; k < static_cast<std::size_t>(strip.count); ++k) {
      const auto ahead = static_cast<float>(first + static_cast<int>(k) - from);
      const float tangential = ahead * minor_f - side * major_f;
      // the ellipse bends away from its tangent
      strip.distance_px[k] = ahead * major_f + side * minor_f + bend * tangential * tangential;
    }
    for (auto k = static_cast<std::size_t>(strip.count); k % 4 != 0; ++k)
      strip.distance_px[k] = nowhere_px, strip.light[k] = 0;
  }

  const LightImage& image_;
  const Ellipse& e_;
  double c_, s_;
  double half_width_px_;
};

/// Levels on both sides, each the mean over the strip and its neighbours along the edge.
void find_levels(std::vector<Strip>& strips, double blur_px) {
  struct Sums {
    double inside = 0, inside_count = 0, outside = 0, outside_count = 0;
  };
  const auto count = static_cast<int>(strips.size());
  std::vector<Sums> sums(strips.size() + 1);                                           // running
  const cv::v_float32x4 clear = cv::v_setall_f32(1.6F * static_cast<float>(blur_px)),  // 95 % of the step
      nowhere = cv::v_setall_f32(nowhere_px), one = cv::v_setall_f32(1), none = cv::v_setall_f32(0);
  for (int k = 0; k < count; ++k) {
    const Strip& strip = strips[static_cast<std::size_t>(k)];
    cv::v_float32x4 inside = none, inside_count = none, outside = none, outside_count = none;
    for (int i = 0; i < strip.count; i += 4) {
      const cv::v_float32x4 d = cv::v_load(strip.distance_px.data() + i),
                            light = cv::v_load(strip.light.data() + i);
      const cv::v_float32x4 is_inside = d < none - clear, is_outside = (d > clear) & (d < nowhere);
      inside += light & is_inside, inside_count += one & is_inside;
      outside += light & is_outside, outside_count += one & is_outside;
    }
    Sums s = sums[static_cast<std::size_t>(k)];
    s.inside += cv::v_reduce_sum(inside), s.inside_count += cv::v_reduce_sum(inside_count);
    s.outside += cv::v_reduce_sum(outside), s.outside_count += cv::v_reduce_sum(outside_count);
    sums[static_cast<std::size_t>(k) + 1] = s;
  }
  constexpr int neighbours = 4;
  for (int k = 0; k < count; ++k) {
    const Sums &low = sums[static_cast<std::size_t>(std::max(k - neighbours, 0))],
               &high = sums[static_cast<std::size_t>(std::min(k + neighbours, count - 1)) + 1];
    Strip& strip = strips[static_cast<std::size_t>(k)];
    strip.used = high.inside_count > low.inside_count && high.outside_count > low.outside_count;
    if (!strip.used) continue;
    strip.inside = (high.inside - low.inside) / (high.inside_count - low.inside_count);
    strip.outside = (high.outside - low.outside) / (high.outside_count - low.outside_count);
  }
}

/// The edge's place in each strip: one step of least squares from the ellipse.
void find_offsets(std::vector<Strip>& strips, Bright bright, double blur_px, double least_contrast) {
  const double sign = bright == Bright::within ? -1 : 1;
  for (Strip& strip : strips) {
    const double contrast = strip.outside - strip.inside;
    strip.used = strip.used && sign * contrast > least_contrast;
    if (!strip.used) continue;
    const auto all = [](double value) { return cv::v_setall_f32(static_cast<float>(value)); };
    const cv::v_float32x4 inside = all(strip.inside), step = all(contrast), inverse_blur = all(1 / blur_px),
                          slope = all(-contrast / blur_px), far = all(6),
                          bend_px = all(strip.curvature * blur_px * blur_px / 2);
    cv::v_float32x4 gains = all(0), weights = all(0), blur_gains = all(0), blur_weights = all(0);
    for (int i = 0; i < strip.count; i += 4) {
      const cv::v_float32x4 d = cv::v_load(strip.distance_px.data() + i);
      const cv::v_float32x4 z = cv::v_max(all(-6), cv::v_min(far, (d + bend_px) * inverse_blur));
      const Normal normal(z);
      const cv::v_float32x4 residual = cv::v_load(strip.light.data() + i) - inside - step * normal.cdf;
      const cv::v_float32x4 by_offset = slope * normal.density, by_blur = z * by_offset;
      gains += by_offset * residual;
      weights += by_offset * by_offset;
      blur_gains += by_blur * residual;
      blur_weights += by_blur * by_blur;
    }
    const float gain = cv::v_reduce_sum(gains), weight = cv::v_reduce_sum(weights);
    strip.blur_gain = cv::v_reduce_sum(blur_gains);
    strip.blur_weight = cv::v_reduce_sum(blur_weights);
    strip.used = weight > 0;
    strip.offset_px = gain / weight;
    strip.variance_px2 = 1 / weight;
  }
}

double median_of(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double typical_contrast(const std::vector<Strip>& strips, Bright bright) {
  std::vector<double> contrasts;
  for (const Strip& strip : strips) {
    if (strip.used) contrasts.push_back((bright == Bright::within ? -1 : 1) * (strip.outside - strip.inside));
  }
  return median_of(contrasts);
}

/// One round of Gauss-Newton for the ellipse, weighted by contrast and against outliers.
struct Solver {
  EllipseCovariance information = EllipseCovariance::Zero();
  Row right = Row::Zero();
  double chi_square = 0, weights = 0;
  int used = 0;

  void add(const Strip& strip, double weight) {
    const Row& row = strip.shift;
    const double w = weight / strip.variance_px2;
    information += w * row * row.transpose();
    right += w * strip.offset_px * row;
    chi_square += w * strip.offset_px * strip.offset_px;
    weights += weight;
    ++used;
  }

  [[nodiscard]] Row solve() const {
    // a circle has no direction: hold what nothing speaks about
    EllipseCovariance damped = information;
    const double scale = information(0, 0) + information(1, 1);
    damped.diagonal() += Row::Constant(1e-9 * scale);
    damped(4, 4) += 1e-6 * scale;
    return damped.llt().solve(right);
  }
};

Solver weigh(std::vector<Strip>& strips, double limit_px) {
  Solver solver;
  for (Strip& strip : strips) {
    if (!strip.used) continue;
    const double ratio = strip.offset_px / limit_px;
    strip.used = std::abs(ratio) < 1;
    if (strip.used) solver.add(strip, strip.share * (1 - ratio * ratio) * (1 - ratio * ratio));
  }
  return solver;
}

double outlier_limit_px(const std::vector<Strip>& strips) {
  std::vector<double> offsets;
  for (const Strip& strip : strips) {
    if (strip.used) offsets.push_back(std::abs(strip.offset_px));
  }
  return 4.7 * std::max(1.48 * median_of(offsets), 0.05);
}

Ellipse moved(const Ellipse& e, const Row& by) {
  return normalized({e.u_px + by[0], e.v_px + by[1], e.a_px + by[2], e.b_px + by[3], e.alpha_rad + by[4]});
}

double better_blur(const std::vector<Strip>& strips, double blur_px) {
  double gain = 0, weight = 0;
  for (const Strip& strip : strips) {
    if (strip.used) gain += strip.blur_gain, weight += strip.blur_weight;
  }
  if (!(weight > 0)) return blur_px;
  // A pixel's square alone is 0.29 px.
  return std::clamp(blur_px + std::clamp(gain / weight, -0.4 * blur_px, 0.6 * blur_px), 0.29, widest_blur_px);
}

}  // namespace

std::optional<SubpixelFit> fit_subpixel(const LightImage& image, const Ellipse& guess, Bright bright,
                                        double blur_px, double reach_px, const StripCounts& counts) {
  constexpr int rounds = 3;
  constexpr double faintest = 2.0 / 255;  // of contrast, in light: two grey levels
  Ellipse e = guess;
  // kept: so much memory, given back each time, would be cleared by the kernel each time
  static thread_local std::vector<Strip> strips;
  Solver solver;
  for (int round = 0; round < rounds; ++round) {
    // the step and, on either side, two pixels of level
    const double half_width_px = std::min(2.2 * blur_px + 2, std::max(reach_px, 1.6 * blur_px + 0.7));
    const bool last = round + 1 == rounds;
    StripCutter(image, e, half_width_px).cut(last ? counts.last_round : counts.first_rounds, strips);
    find_levels(strips, blur_px);
    find_offsets(strips, bright, blur_px, std::max(faintest, 0.3 * typical_contrast(strips, bright)));
    solver = weigh(strips, outlier_limit_px(strips));
    if (solver.used < 12) return std::nullopt;
    const Row step = solver.solve();
    if (!step.allFinite() || step.head<4>().cwiseAbs().maxCoeff() > 0.3 * e.b_px) return std::nullopt;
    e = moved(e, step);
    if (!is_valid(e)) return std::nullopt;
    if (!last) blur_px = better_blur(strips, blur_px);
  }
  SubpixelFit result;
  result.fit.ellipse = e;
  result.blur_px = blur_px;
  // Noise from what the strips scatter; Tukey's weights keep 0.76 of a normal variance's weight.
  const double noise = solver.chi_square / std::max(0.76 * solver.weights - 5, 1.0);
  EllipseCovariance information = solver.information / std::max(noise, 1e-12);
  information.diagonal() += (Row() << 1e-8, 1e-8, 1e-8, 1e-8, 12 / (pi * pi)).finished();
  result.fit.covariance = information.llt().solve(EllipseCovariance::Identity());
  // What no blurred step explains: the shape of a pixel and of the lens' blur. Largest error on clean
  // renders.
  constexpr double model_px = 0.01;
  result.fit.covariance.diagonal().head<4>().array() += model_px * model_px;
  return result;
}

}  // namespace stevedore
