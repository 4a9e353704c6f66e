#include "detector_proc/subpixel_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace stevedore {
namespace {

using std::numbers::pi;
using Row = Eigen::Matrix<double, 5, 1>;

constexpr int most_pixels = 32;         ///< of one strip: 10 px to either side of a diagonal edge
constexpr double widest_blur_px = 3.5;  ///< whose strips are as long

/// One row or column of pixels across the edge.
struct Strip {
  Row shift;         ///< of the edge there by the parameters
  double curvature;  ///< 1 / px
  double share;      ///< of a row or column that this strip stands for
  int count = 0;
  std::array<float, most_pixels> distance_px;  ///< outwards from the ellipse
  std::array<float, most_pixels> light;
  double inside = 0, outside = 0;          ///< levels
  double offset_px = 0, variance_px2 = 0;  ///< of the edge from the ellipse, in light^2 of noise
  double blur_gain = 0, blur_weight = 0;   ///< least-squares step of the blur
  bool used = false;
};

/// The normal distribution, by table to 1e-4.
class Normal {
 public:
  struct Value {
    float cdf, density;
  };

  static const Normal& table() {
    static const Normal normal;
    return normal;
  }

  [[nodiscard]] Value operator()(float z) const {
    const float place = std::clamp((z + limit) * per_unit, 0.F, static_cast<float>(size) - 1.001F);
    const auto k = static_cast<std::size_t>(place);
    const float part = place - static_cast<float>(k);
    const Value &low = values_[k], &high = values_[k + 1];
    return {low.cdf + part * (high.cdf - low.cdf), low.density + part * (high.density - low.density)};
  }

 private:
  static constexpr float limit = 5, per_unit = 32;
  static constexpr int size = static_cast<int>(2 * limit * per_unit) + 1;

  Normal() {
    for (int k = 0; k < size; ++k) {
      const double z = k / static_cast<double>(per_unit) - limit;
      values_[static_cast<std::size_t>(k)] = {
          static_cast<float>(0.5 * std::erfc(-z * std::numbers::sqrt2 / 2)),
          static_cast<float>(std::exp(-z * z / 2) / std::sqrt(2 * pi))};
    }
  }

  std::array<Value, static_cast<std::size_t>(size)> values_{};
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
    const int row = static_cast<int>(std::lround(other));
    const int limit = along_u ? image_.width() : image_.height(),
              row_limit = along_u ? image_.height() : image_.width();
    if (row < 0 || row >= row_limit) return;
    const double reach = half_width_px_ / std::abs(major);
    const int first = static_cast<int>(std::ceil(from - reach)),
              last = static_cast<int>(std::floor(from + reach));
    if (first < 0 || last >= limit || last - first >= most_pixels) return;
    Strip& strip = strips.emplace_back();
    const double along = nx / speed, across = ny / speed;  // the normal, in the axes' frame
    strip.shift << nu, nv, along * ct, across * st, across * x - along * y;
    strip.curvature = e_.a_px * e_.b_px / (speed * speed * speed);
    strip.share = std::min(1.0, speed * step_rad * std::abs(major));
    const auto major_f = static_cast<float>(major), minor_f = static_cast<float>(along_u ? nv : nu);
    const auto side = static_cast<float>(row - other), bend = static_cast<float>(strip.curvature / 2);
    for (int i = first; i <= last; ++i) {
      const float ahead = static_cast<float>(i - from);
      const float tangential = ahead * minor_f - side * major_f;
      // the ellipse bends away from its tangent
      const auto k = static_cast<std::size_t>(strip.count++);
      strip.distance_px[k] = ahead * major_f + side * minor_f + bend * tangential * tangential;
      strip.light[k] = along_u ? image_(i, row) : image_(row, i);
    }
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
  std::vector<Sums> sums(strips.size() + 1);  // running
  const double clear_px = 1.6 * blur_px;      // 95 % of the step lies within
  for (int k = 0; k < count; ++k) {
    const Strip& strip = strips[static_cast<std::size_t>(k)];
    Sums s = sums[static_cast<std::size_t>(k)];
    for (int i = 0; i < strip.count; ++i) {
      const double d = strip.distance_px[static_cast<std::size_t>(i)],
                   light = strip.light[static_cast<std::size_t>(i)];
      if (d < -clear_px) s.inside += light, ++s.inside_count;
      if (d > clear_px) s.outside += light, ++s.outside_count;
    }
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
  const Normal& normal = Normal::table();
  for (Strip& strip : strips) {
    const double contrast = strip.outside - strip.inside;
    strip.used = strip.used && sign * contrast > least_contrast;
    if (!strip.used) continue;
    const auto inside = static_cast<float>(strip.inside), step = static_cast<float>(contrast);
    const auto inverse_blur = static_cast<float>(1 / blur_px);
    const auto bend_px = static_cast<float>(strip.curvature * blur_px * blur_px / 2);
    float gain = 0, weight = 0, blur_gain = 0, blur_weight = 0;
    for (std::size_t i = 0; i < static_cast<std::size_t>(strip.count); ++i) {
      const float z = (strip.distance_px[i] + bend_px) * inverse_blur;
      const auto [cdf, density] = normal(z);
      const float residual = strip.light[i] - inside - step * cdf;
      const float by_offset = -step * density * inverse_blur, by_blur = z * by_offset;
      gain += by_offset * residual;
      weight += by_offset * by_offset;
      blur_gain += by_blur * residual;
      blur_weight += by_blur * by_blur;
    }
    strip.blur_gain = blur_gain;
    strip.blur_weight = blur_weight;
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
                                        double blur_px, double reach_px, int most_strips) {
  constexpr int rounds = 3;
  constexpr int last_round_more = 4;      // the ones before need only come near
  constexpr double faintest = 2.0 / 255;  // of contrast, in light: two grey levels
  Ellipse e = guess;
  std::vector<Strip> strips;
  strips.reserve(most_strips > 0 ? static_cast<std::size_t>(last_round_more * most_strips) : 512);
  Solver solver;
  for (int round = 0; round < rounds; ++round) {
    // the step and, on either side, two pixels of level
    const double half_width_px = std::min(2.2 * blur_px + 2, std::max(reach_px, 1.6 * blur_px + 0.7));
    const bool last = round + 1 == rounds;
    StripCutter(image, e, half_width_px).cut(last ? last_round_more * most_strips : most_strips, strips);
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
