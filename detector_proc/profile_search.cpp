#include "detector_proc/profile_search.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <opencv2/core/hal/intrin.hpp>
#include <optional>

#include "detector_proc/evidence.hpp"

namespace stevedore {
namespace {

using Row = Eigen::Matrix<float, 5, 1>;

/// Grey levels at places of the reduced image, of the pixel that is nearest.
class Levels {
 public:
  Levels(const cv::Mat& image, int factor)
      : data_(image.data),
        step_(static_cast<int>(image.step)),
        channels_(image.channels()),
        right_(static_cast<float>(image.cols - 1)),
        bottom_(static_cast<float>(image.rows - 1)),
        factor_(static_cast<float>(factor)) {}

  /// Where the pixel nearest to a place is; beyond the border the outermost one.
  [[nodiscard]] int index(float u, float v) const {
    return nearest(v, bottom_) * step_ + nearest(u, right_) * channels_;
  }

  /// Luminance, Rec. 601.
  [[nodiscard]] int operator[](int index) const {
    const uchar* p = data_ + index;
    return channels_ == 1 ? p[0] : (29 * p[0] + 150 * p[1] + 77 * p[2]) >> 8;
  }

  [[nodiscard]] bool is_in_view(float u, float v, float margin) const {
    return u > margin && v > margin && u < (right_ + 1) / factor_ - 1 - margin &&
           v < (bottom_ + 1) / factor_ - 1 - margin;
  }

 private:
  /// (place + 0.5) * factor - 0.5, and 0.5 for rounding.
  [[nodiscard]] int nearest(float place, float last) const {
    return static_cast<int>(std::min(std::max((place + 0.5F) * factor_, 0.F), last));
  }

  const uchar* data_;
  int step_, channels_;
  float right_, bottom_, factor_;
};

/// The light along the normals of an ellipse and its derivative, one place a pixel.
class Profiles {
 public:
  static constexpr int count = 48, most_reach = 30;
  static constexpr float not_found = 1e6F;

  Profiles(const Levels& levels, const Ellipse& e, int reach) : ellipse_(e), reach_(reach) {
    find_normals(levels);
    sample(levels);
    differentiate();
  }

  /// The steepest step of this contrast on each profile, outwards from the ellipse; nothing: not_found.
  [[nodiscard]] std::array<float, count> steps(Bright bright) const {
    Line steepest, place{};
    steepest.fill(faintest);
    const auto sign = static_cast<short>(bright == Bright::within ? -1 : 1);
    for (int i = -reach_; i <= reach_; ++i) {
      const Line& slope = slope_[at(i)];
      for (std::size_t k = 0; k < count; ++k) {
        const auto s = static_cast<short>(sign * slope[k]);
        const bool more = s > steepest[k];
        steepest[k] = more ? s : steepest[k];
        place[k] = more ? static_cast<short>(i) : place[k];
      }
    }
    std::array<float, count> offset_px;
    for (std::size_t k = 0; k < count; ++k) {
      offset_px[k] = not_found;
      if (!in_view_[k] || steepest[k] == faintest) continue;
      const auto before = static_cast<float>(sign * slope_[at(place[k] - 1)][k]),
                 behind = static_cast<float>(sign * slope_[at(place[k] + 1)][k]);
      const float curvature = 2.F * steepest[k] - before - behind;
      const float vertex = curvature > 0 ? std::clamp(0.5F * (behind - before) / curvature, -1.F, 1.F) : 0;
      offset_px[k] = static_cast<float>(place[k]) + vertex;
    }
    return offset_px;
  }

  /// The ellipse through the steps: least squares with Tukey's weights, in the ellipse's own tangent space.
  [[nodiscard]] std::optional<Ellipse> fit(const std::array<float, count>& offset_px) const;

  /// What an ellipse has for it of the steps.
  [[nodiscard]] EdgeSupport support(const std::array<float, count>& offset_px, const Ellipse& fitted) const {
    EdgeSupport support;
    support.count = count;
    for (std::size_t k = 0; k < count; ++k) {
      EdgeSample& sample = support.samples[k];
      sample.length_px = length_px_[k];
      sample.in_frame = in_view_[k];
      sample.found = offset_px[k] < not_found;
      if (!sample.found) continue;
      sample.point = {u_[k] + offset_px[k] * nu_[k], v_[k] + offset_px[k] * nv_[k], -nv_[k], nu_[k]};
    }
    measure_from(support, fitted);
    drop_outliers(support);
    return support;
  }

 private:
  using Line = std::array<short, count>;  ///< one place on every profile
  static constexpr int margin = 3;        ///< two of the derivative's, one beside the steepest step
  /// A step of four grey levels, as EdgeThresholds. What is steepest on a profile has no more to show than
  /// that it lies where those of the others do.
  static constexpr short faintest = 4 * 6;

  [[nodiscard]] static std::size_t at(int i) { return static_cast<std::size_t>(i + most_reach + margin); }

  void find_normals(const Levels& levels) {
    const Ellipse& e = ellipse_;
    const auto c = static_cast<float>(std::cos(e.alpha_rad)), s = static_cast<float>(std::sin(e.alpha_rad));
    const auto a = static_cast<float>(e.a_px), b = static_cast<float>(e.b_px);
    constexpr float step_rad = 2 * std::numbers::pi_v<float> / count;
    const float step_cosine = std::cos(step_rad), step_sine = std::sin(step_rad);
    float ct = 1, st = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const float x = b * ct, y = a * st, speed = std::sqrt(x * x + y * y);
      u_[k] = static_cast<float>(e.u_px) + c * a * ct - s * b * st;
      v_[k] = static_cast<float>(e.v_px) + s * a * ct + c * b * st;
      nu_[k] = (c * x - s * y) / speed;
      nv_[k] = (s * x + c * y) / speed;
      length_px_[k] = speed * step_rad;
      const float along = x / speed, across = y / speed;  // the normal, in the axes' frame
      shift_[0][k] = nu_[k], shift_[1][k] = nv_[k];
      shift_[2][k] = along * ct, shift_[3][k] = across * st;
      shift_[4][k] = across * a * ct - along * b * st;
      in_view_[k] = levels.is_in_view(u_[k], v_[k], 1);
      const float next = ct * step_cosine - st * step_sine;
      st = st * step_cosine + ct * step_sine;
      ct = next;
    }
  }

  /// Two pixels each, a quarter before and behind.
  void sample(const Levels& levels) {
    std::array<int, count> before, behind;
    for (int i = -reach_ - margin; i <= reach_ + margin; ++i) {
      const float near = static_cast<float>(i) - 0.25F, far = static_cast<float>(i) + 0.25F;
      for (std::size_t k = 0; k < count; ++k) {
        before[k] = levels.index(u_[k] + near * nu_[k], v_[k] + near * nv_[k]);
        behind[k] = levels.index(u_[k] + far * nu_[k], v_[k] + far * nv_[k]);
      }
      Line& light = light_[at(i)];
      for (std::size_t k = 0; k < count; ++k)
        light[k] = static_cast<short>(levels[before[k]] + levels[behind[k]]);
    }
  }

  /// (-1 -2 0 2 1), as GradientField along an axis.
  void differentiate() {
    for (int i = -reach_ - 1; i <= reach_ + 1; ++i) {
      const Line &a = light_[at(i - 2)], &b = light_[at(i - 1)], &d = light_[at(i + 1)],
                 &e = light_[at(i + 2)];
      Line& slope = slope_[at(i)];
      for (std::size_t k = 0; k < count; ++k) slope[k] = static_cast<short>(2 * (d[k] - b[k]) + e[k] - a[k]);
    }
  }

  Ellipse ellipse_;
  int reach_;
  std::array<float, count> u_, v_, nu_, nv_, length_px_;
  std::array<bool, count> in_view_;
  std::array<std::array<float, count>, 5> shift_;  ///< of the edge there by the parameters
  std::array<Line, 2 * (most_reach + margin) + 1> light_, slope_;
};

/// Where Tukey's weights end: 4.7 deviations (Huber 1981), by the median.
float outlier_limit_px(const std::array<float, Profiles::count>& left_px) {
  constexpr float least_deviation_px = 0.2F;  // a step's own error
  std::array<float, Profiles::count> found;
  const auto end = std::copy_if(left_px.begin(), left_px.end(), found.begin(),
                                [](float r) { return r < Profiles::not_found / 2; });
  if (end == found.begin()) return 0;
  for (auto r = found.begin(); r != end; ++r) *r = std::abs(*r);
  const auto middle = found.begin() + (end - found.begin()) / 2;
  std::nth_element(found.begin(), middle, end);
  return 4.7F * std::max(1.48F * *middle, least_deviation_px);
}

float dot(const std::array<float, Profiles::count>& a, const std::array<float, Profiles::count>& b) {
  cv::v_float32x4 sum = cv::v_setall_f32(0);
  for (std::size_t k = 0; k < a.size(); k += 4) sum += cv::v_load(a.data() + k) * cv::v_load(b.data() + k);
  return cv::v_reduce_sum(sum);
}

std::optional<Ellipse> Profiles::fit(const std::array<float, count>& offset_px) const {
  // what motion and another view change of a shape between frames, and the guess of it
  constexpr float shape_share = 0.15F;
  constexpr float step_px = 0.3F;
  constexpr int rounds = 3, fewest = 12;
  const auto a = static_cast<float>(ellipse_.a_px), b = static_cast<float>(ellipse_.b_px);
  const float axis = step_px / (shape_share * b),
              turn = step_px / std::min(3.F, shape_share / std::max(1e-3F, 1 - b / a));
  std::array<float, count> left_px = offset_px;
  Row by = Row::Zero();
  for (int round = 0; round < rounds; ++round) {
    const float limit_px = outlier_limit_px(left_px);
    std::array<float, count> weight;
    int used = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const float ratio = left_px[k] / limit_px, rest = std::max(0.F, 1 - ratio * ratio);
      weight[k] = rest * rest;
      used += rest > 0 ? 1 : 0;
    }
    if (used < fewest) return std::nullopt;
    Eigen::Matrix<float, 5, 5> information;
    Row right;
    for (std::size_t i = 0; i < 5; ++i) {
      std::array<float, count> weighted;
      for (std::size_t k = 0; k < count; ++k) weighted[k] = weight[k] * shift_[i][k];
      right[static_cast<int>(i)] = dot(weighted, offset_px);
      for (std::size_t j = 0; j <= i; ++j)
        information(static_cast<int>(i), static_cast<int>(j)) = dot(weighted, shift_[j]);
    }
    information.diagonal() += Row(1e-6F, 1e-6F, axis * axis, axis * axis, turn * turn);
    by = information.selfadjointView<Eigen::Lower>().llt().solve(right);
    left_px = offset_px;
    for (std::size_t i = 0; i < 5; ++i)
      for (std::size_t k = 0; k < count; ++k) left_px[k] -= by[static_cast<int>(i)] * shift_[i][k];
  }
  const Ellipse e = normalized({ellipse_.u_px + by[0], ellipse_.v_px + by[1], ellipse_.a_px + by[2],
                                ellipse_.b_px + by[3], ellipse_.alpha_rad + by[4]});
  return is_valid(e) ? std::optional(e) : std::nullopt;
}

}  // namespace

std::vector<EllipseEdge> look_across(const cv::Mat& image, const Ellipse& expected, int factor,
                                     double reach_px, const DetectorSettings& settings) {
  const int reach = std::min(static_cast<int>(reach_px) + 1, Profiles::most_reach);
  const Profiles wide(Levels(image, factor), expected, reach);
  std::vector<EllipseEdge> edges;
  for (const Bright bright : {Bright::within, Bright::without}) {
    const auto near = wide.fit(wide.steps(bright));
    if (!near) continue;
    if (auto edge = look_closely(image, *near, bright, factor, settings)) edges.push_back(std::move(*edge));
  }
  return edges;
}

std::optional<EllipseEdge> look_closely(const cv::Mat& image, const Ellipse& near, Bright bright, int factor,
                                        const DetectorSettings& settings) {
  constexpr int close_px = 2;
  const Profiles close(Levels(image, factor), near, close_px);
  const auto steps = close.steps(bright);
  const auto e = close.fit(steps);
  if (!e || e->b_px < settings.min_semi_minor_px) return std::nullopt;
  EllipseEdge edge{*e, bright, close.support(steps, *e), 0, 0, {}};
  edge.evidence = log_odds(edge.support);
  if (edge.evidence < settings.min_log_odds) return std::nullopt;
  const double deviation_px = std::max(edge.support.rms_px, 0.1);
  edge.open_px = worst_deviation_px(*e, covariance_of(*e, edge.support, deviation_px));
  if (edge.open_px > settings.max_open_ratio * e->b_px) return std::nullopt;
  return edge;
}

bool is_plain_within(const cv::Mat& image, const Ellipse& e, int factor) {
  constexpr int grid = 24;
  constexpr float margin_px = 4;       // what a circle's own edge reaches, blur and all
  constexpr int faintest_step = 7;     // as EdgeThresholds' start
  constexpr double noise_medians = 5;  // 3.4 deviations: of white noise one step in 1500 is larger
  const auto a = static_cast<float>(e.a_px) - margin_px, b = static_cast<float>(e.b_px) - margin_px;
  if (b < 0.4F * static_cast<float>(e.b_px)) return false;
  const auto c = static_cast<float>(std::cos(e.alpha_rad)), s = static_cast<float>(std::sin(e.alpha_rad));
  const Levels levels(image, factor);
  constexpr int beyond = -1;
  std::array<std::array<int, grid>, grid> level;
  int inside = 0, in_view = 0;
  for (std::size_t i = 0; i < grid; ++i) {
    for (std::size_t j = 0; j < grid; ++j) {
      const float x = (2 * static_cast<float>(i) + 1) / grid - 1,
                  y = (2 * static_cast<float>(j) + 1) / grid - 1;
      level[i][j] = beyond;
      if (x * x + y * y > 1) continue;
      ++inside;
      const float u = static_cast<float>(e.u_px) + c * a * x - s * b * y,
                  v = static_cast<float>(e.v_px) + s * a * x + c * b * y;
      if (!levels.is_in_view(u, v, 1)) continue;
      ++in_view;
      level[i][j] = levels[levels.index(u, v)];
    }
  }
  std::array<int, 256> steps{};
  int pairs = 0;
  const auto count = [&](int one, int other) {
    if (one != beyond && other != beyond) ++steps[static_cast<std::size_t>(std::abs(one - other))], ++pairs;
  };
  for (std::size_t i = 0; i < grid; ++i) {
    for (std::size_t j = 0; j + 1 < grid; ++j) {
      count(level[i][j], level[i][j + 1]);
      count(level[j][i], level[j + 1][i]);
    }
  }
  int median = 0;
  for (int below = 0; median < 255; ++median) {
    below += steps[static_cast<std::size_t>(median)];
    if (2 * below >= pairs) break;
  }
  const int largest_of_noise = std::clamp(static_cast<int>(noise_medians * median), faintest_step, 254);
  const auto large = steps.begin() + largest_of_noise + 1;
  // a rim of a quarter of the circle's size has a hundredth of the samples on its edge
  return 2 * in_view >= inside && 200 * std::accumulate(large, steps.end(), 0) < in_view;
}

}  // namespace stevedore
