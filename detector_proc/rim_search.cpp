#include "detector_proc/rim_search.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <vector>

namespace stevedore {
namespace {

// ---- the circle made round ----

constexpr int patch_px = 96;
constexpr float unit_px = 34;  ///< the circle's radius in the patch: a rim of 11 px, a pixel is a tenth of it
constexpr float middle_px = (patch_px - 1) / 2.F;

/// From the patch into the image.
cv::Matx23d image_from_patch(const Ellipse& e) {
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad), a = e.a_px / unit_px,
               b = e.b_px / unit_px;
  return {a * c, -b * s, e.u_px - middle_px * (a * c - b * s),  //
          a * s, b * c,  e.v_px - middle_px * (a * s + b * c)};
}

struct Patch {
  cv::Mat pixels;
  cv::Mat_<std::uint8_t> seen;  ///< of which pixels the image has something

  [[nodiscard]] bool sees(int v, int u) const {
    return u >= 0 && v >= 0 && u < patch_px && v < patch_px && seen(v, u) != 0;
  }
};

Patch round_patch(const cv::Mat& image, Ellipse e) {
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
  Patch patch{{}, cv::Mat_<std::uint8_t>(patch_px, patch_px)};
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

/// Gradient of the channel that changes most, pixel by pixel, in levels per pixel; 0 where nothing is seen.
struct Edges {
  cv::Mat_<float> along, down, magnitude;
  float threshold = 0;
};

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

Edges edges_of(const Patch& patch) {
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
  Edges edges;
  along.convertTo(edges.along, CV_32F, 1 / per_level);
  down.convertTo(edges.down, CV_32F, 1 / per_level);
  squares.convertTo(edges.magnitude, CV_32F, 1 / (per_level * per_level));
  cv::sqrt(edges.magnitude, edges.magnitude);
  // noise and texture have the median; an edge of less than two grey levels a pixel is none to be trusted
  edges.threshold = std::max(2.F, 2 * median_of(edges.magnitude));
  return edges;
}

// ---- votes ----

/// Centres of rims: the cargo stands up to 0.4 radii off the middle, and a rim that is 0.6 radii over the
/// deck is seen that times the tangent of the line of sight further out.
constexpr float farthest_centre_px = 0.9F * unit_px;
constexpr int cell_px = 2;
constexpr std::size_t cells = patch_px / cell_px;
constexpr std::size_t places_tried = 8;

struct Place {
  float u, v, radius;
};

/// Steps of an eighth: two edge pixels of a rim.
std::vector<float> radii_tried_px(const RimRadii& radii) {
  if (radii.known) return {static_cast<float>((radii.smallest + radii.largest) / 2 * unit_px)};
  std::vector<float> tried;
  for (double r = radii.smallest; r < radii.largest * 1.06; r *= 1.125)
    tried.push_back(static_cast<float>(r * unit_px));
  return tried;
}

/// Votes for centres of circles of one radius.
class Votes {
 public:
  void add(float u, float v) {
    const float x = u - middle_px, y = v - middle_px;
    if (x * x + y * y > farthest_centre_px * farthest_centre_px) return;
    ++counts_[static_cast<std::size_t>(v) / cell_px][static_cast<std::size_t>(u) / cell_px];
  }

  /// visit(u, v, sum) for the middles of all 3x3 cells.
  template <class Visit>
  void for_each_sum(Visit visit) const {
    for (std::size_t j = 1; j + 1 < cells; ++j) {
      std::array<int, cells> columns;
      for (std::size_t i = 0; i < cells; ++i)
        columns[i] = counts_[j - 1][i] + counts_[j][i] + counts_[j + 1][i];
      for (std::size_t i = 1; i + 1 < cells; ++i)
        visit((static_cast<float>(i) + 0.5F) * cell_px, (static_cast<float>(j) + 0.5F) * cell_px,
              columns[i - 1] + columns[i] + columns[i + 1]);
    }
  }

 private:
  std::array<std::array<int, cells>, cells> counts_{};
};

/// The edge is strongest here, across it, and it is not the circle's own.
bool votes_from(const Edges& edges, int v, int u) {
  const float m = edges.magnitude(v, u);
  if (m < edges.threshold) return false;
  const float x = static_cast<float>(u) - middle_px, y = static_cast<float>(v) - middle_px;
  constexpr float own_px = 2.5F, low = unit_px - own_px, high = unit_px + own_px;
  const float square = x * x + y * y;
  if (square > low * low && square < high * high) return false;
  // the neighbour along the gradient
  const auto step = [&](float g) { return g > m / 2 ? 1 : g < -m / 2 ? -1 : 0; };
  const int su = step(edges.along(v, u)), sv = step(edges.down(v, u));
  return m >= edges.magnitude(v + sv, u + su) && m >= edges.magnitude(v - sv, u - su);
}

std::vector<Place> voted_places(const Edges& edges, const std::vector<float>& radii_px) {
  std::vector<Votes> votes(radii_px.size());
  for (int v = 2; v < patch_px - 2; ++v) {
    for (int u = 2; u < patch_px - 2; ++u) {
      if (!votes_from(edges, v, u)) continue;
      const float m = edges.magnitude(v, u), nu = edges.along(v, u) / m, nv = edges.down(v, u) / m;
      for (std::size_t r = 0; r < radii_px.size(); ++r) {
        for (const float radius : {radii_px[r], -radii_px[r]})
          votes[r].add(static_cast<float>(u) + radius * nu, static_cast<float>(v) + radius * nv);
      }
    }
  }
  struct Sum {
    float share;
    Place place;
  };
  std::vector<Sum> sums;
  for (std::size_t r = 0; r < radii_px.size(); ++r) {
    const float all = 2 * std::numbers::pi_v<float> * radii_px[r];
    votes[r].for_each_sum([&](float u, float v, int sum) {
      const float share = static_cast<float>(sum) / all;
      // a rim of which half is seen, and half of that is where it should be
      if (share > 0.25F) sums.push_back({share, {u, v, radii_px[r]}});
    });
  }
  std::stable_sort(sums.begin(), sums.end(), [](const Sum& a, const Sum& b) { return a.share > b.share; });
  std::vector<Place> places;
  for (const Sum& s : sums) {
    const bool known = std::any_of(places.begin(), places.end(), [&](const Place& p) {
      return std::hypot(p.u - s.place.u, p.v - s.place.v) < 5 && std::abs(p.radius - s.place.radius) < 2.5F;
    });
    if (!known) places.push_back(s.place);
    if (places.size() == places_tried) break;
  }
  return places;
}

// ---- a circle fitted to the edges around a place ----

struct RoundFit {
  Eigen::Vector3d circle_px;  ///< centre, radius
  Eigen::Matrix3d covariance_px2;
  double coverage = 0;
  double error = 0;
};

constexpr int directions = 64;

struct Direction {
  float u, v;
};

const std::array<Direction, directions>& all_directions() {
  static const std::array<Direction, directions> all = [] {
    std::array<Direction, directions> d{};
    for (int k = 0; k < directions; ++k) {
      const float t = 2 * std::numbers::pi_v<float> * static_cast<float>(k) / directions;
      d[static_cast<std::size_t>(k)] = {std::cos(t), std::sin(t)};
    }
    return d;
  }();
  return all;
}

/// The pixel at a place in the patch or around it.
cv::Point pixel_at(float u, float v) {
  constexpr float shift = 1024.5F;  // what is cast is positive: rounds
  return {static_cast<int>(u + shift) - 1024, static_cast<int>(v + shift) - 1024};
}

/// bands_px: of the edges looked at on either side, fit by fit.
/// radius_weight: of the place's radius, in edges.
std::optional<RoundFit> fitted(const Patch& patch, const Edges& edges, const Place& place,
                               const std::array<float, 3>& bands_px, double radius_weight) {
  constexpr float most_turn_cosine = 0.85F;  // 32 degrees: a pixel's direction at three sigma of noise
  Eigen::Vector3d circle(place.u, place.v, place.radius);
  RoundFit fit;
  for (const float band_px : bands_px) {
    Eigen::Matrix3d squares = Eigen::Matrix3d::Zero();
    Eigen::Vector3d sums = Eigen::Vector3d::Zero();
    double looked = 0, found = 0, residuals = 0, errors = 0;
    const auto centre_u = static_cast<float>(circle.x()), centre_v = static_cast<float>(circle.y()),
               radius = static_cast<float>(circle.z());
    for (const auto& [nu, nv] : all_directions()) {
      const auto along_ray = [&, nu = nu, nv = nv](float r) {
        return pixel_at(centre_u + r * nu, centre_v + r * nv);
      };
      const cv::Point expected = along_ray(radius);
      if (!patch.sees(expected.y, expected.x)) continue;
      ++looked;
      float best = 0, best_off = 0;
      for (float off = -band_px; off <= band_px; off += 0.5F) {
        const cv::Point p = along_ray(radius + off);
        if (!patch.sees(p.y, p.x)) continue;
        const float m = edges.magnitude(p);
        if (m < edges.threshold) continue;
        const float along = std::abs(edges.along(p) * nu + edges.down(p) * nv);
        if (along > best && along > most_turn_cosine * m) best = along, best_off = off;
      }
      if (best <= 0) continue;
      const Eigen::Vector3d by(nu, nv, 1);
      squares += by * by.transpose();
      sums += by * best_off;
      residuals += best_off * best_off;
      errors += std::abs(2 * best_off / circle.z());
      ++found;
    }
    if (looked < directions / 2.0 || found < directions / 4.0) return std::nullopt;
    squares(2, 2) += radius_weight;
    sums(2) += radius_weight * (place.radius - circle.z());
    const Eigen::LDLT<Eigen::Matrix3d> solver(squares);
    const Eigen::Vector3d step = solver.solve(sums);
    if (step.norm() > 4) return std::nullopt;
    circle += step;
    fit.coverage = found / looked;
    fit.error = errors / found;
    const double variance_px2 = std::max(0.1, (residuals - step.dot(sums)) / std::max(1.0, found - 3));
    fit.covariance_px2 = variance_px2 * squares.inverse();
  }
  fit.circle_px = circle;
  return fit;
}

/// A rim has two edges, a tenth of its radius apart; what is inside is the stronger one where it is dark.
RoundFit outermost(const Patch& patch, const Edges& edges, const RoundFit& fit) {
  const double radius = fit.circle_px.z();
  const Place further{static_cast<float>(fit.circle_px.x()), static_cast<float>(fit.circle_px.y()),
                      static_cast<float>(1.12 * radius)};
  const auto outer = fitted(patch, edges, further, {1.2F, 1.2F, 1.2F}, 0);
  if (!outer || outer->coverage < 0.75 || outer->error > fit.error + 0.05) return fit;
  const double ratio = outer->circle_px.z() / radius;
  const double off = (outer->circle_px - fit.circle_px).head<2>().norm() / radius;
  return ratio > 1.05 && ratio < 1.25 && off < 0.12 ? *outer : fit;
}

/// Middle and radius of an ellipse as round as the circle.
Eigen::Vector3d in_patch(const Ellipse& edge, const Ellipse& circle) {
  const double c = std::cos(circle.alpha_rad), s = std::sin(circle.alpha_rad);
  const double u = edge.u_px - circle.u_px, v = edge.v_px - circle.v_px;
  return {middle_px + unit_px * (c * u + s * v) / circle.a_px,
          middle_px + unit_px * (c * v - s * u) / circle.b_px,
          unit_px * std::sqrt(edge.a_px * edge.b_px / (circle.a_px * circle.b_px))};
}

EllipseFit in_image(const RoundFit& fit, const Ellipse& e) {
  const cv::Matx23d m = image_from_patch(e);
  EllipseFit out;
  out.ellipse = e;
  out.ellipse.u_px = m(0, 0) * fit.circle_px.x() + m(0, 1) * fit.circle_px.y() + m(0, 2);
  out.ellipse.v_px = m(1, 0) * fit.circle_px.x() + m(1, 1) * fit.circle_px.y() + m(1, 2);
  const double size = fit.circle_px.z() / unit_px;
  out.ellipse.a_px *= size;
  out.ellipse.b_px *= size;
  // the shape is the circle's, but for perspective: a hundredth of the semi-axes, and of the direction what
  // is left open
  Eigen::Matrix<double, 5, 3> by = Eigen::Matrix<double, 5, 3>::Zero();
  by.topLeftCorner<2, 2>() << m(0, 0), m(0, 1), m(1, 0), m(1, 1);
  by(2, 2) = e.a_px / unit_px;
  by(3, 2) = e.b_px / unit_px;
  out.covariance = by * fit.covariance_px2 * by.transpose();
  const double shape_px = 0.02 * out.ellipse.a_px;
  out.covariance(2, 2) += shape_px * shape_px;
  out.covariance(3, 3) += shape_px * shape_px;
  const double open_rad = std::min(1.0, 0.02 / std::max(0.02, 1 - out.ellipse.b_px / out.ellipse.a_px));
  out.covariance(4, 4) += open_rad * open_rad;
  return out;
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

// ---- colours ----

/// Grey levels are as good as colours: missing channels are zero.
using Colour = Eigen::Array3d;

class Colours {
 public:
  void add(const Patch& patch, int v, int u) {
    if (!patch.sees(v, u)) return;
    const std::uint8_t* pixel = patch.pixels.ptr(v, u);
    for (int k = 0; k < patch.pixels.channels(); ++k) ++histograms_[static_cast<std::size_t>(k)][pixel[k]];
    ++count_;
    channels_ = static_cast<std::size_t>(patch.pixels.channels());
  }
  [[nodiscard]] bool empty() const { return count_ == 0; }
  /// Share of the samples within so many levels of a colour, in the channel where they are fewest.
  [[nodiscard]] double share_near(const Colour& colour, double levels) const {
    double share = 1;
    for (std::size_t k = 0; k < channels_; ++k) {
      const double level = colour[static_cast<Eigen::Index>(k)];
      const int first = std::max(0, cvCeil(level - levels)), last = std::min(255, cvFloor(level + levels));
      const int near = std::accumulate(histograms_[k].begin() + first, histograms_[k].begin() + last + 1, 0);
      share = std::min(share, static_cast<double>(near) / std::max(count_, 1));
    }
    return share;
  }
  [[nodiscard]] Colour median() const {
    Colour out = Colour::Zero();
    for (std::size_t k = 0; k < channels_; ++k) {
      int level = 0;
      for (int below = histograms_[k][0]; 2 * below <= count_ && level < 255;)
        below += histograms_[k][static_cast<std::size_t>(++level)];
      out[static_cast<Eigen::Index>(k)] = level;
    }
    return out;
  }

 private:
  std::array<std::array<int, 256>, 3> histograms_{};
  int count_ = 0;
  std::size_t channels_ = 0;
};

/// Levels in the channel that differs most.
double difference(const Colour& a, const Colour& b) {
  return (a - b).abs().maxCoeff();
}

constexpr int sampled_each_px = 2;  // a rim's core has some fifty samples

/// In squared circle radii.
double square_off_middle(int v, int u) {
  constexpr double middle = middle_px, unit = unit_px;
  const double x = (u - middle) / unit, y = (v - middle) / unit;
  return x * x + y * y;
}

/// Within it there is no paint of the circle's own, in circle radii.
double clear_radius(const Ellipse& circle, const std::optional<EllipseFit>& inner) {
  constexpr double of_rings = 0.72;  // few are wider
  constexpr double blur = 0.06;      // two pixels
  return inner ? std::min(of_rings, inner->ellipse.b_px / circle.b_px - blur) : of_rings;
}

struct Surface {
  Colour ground, paint;
  double clear;  ///< see clear_radius

  Surface(const Patch& patch, double clear_of_paint) : clear(clear_of_paint) {
    Colours grounds, paints;
    for (int v = 0; v < patch_px; v += sampled_each_px) {
      for (int u = 0; u < patch_px; u += sampled_each_px) {
        const double square = square_off_middle(v, u);
        if (square > 1.12 * 1.12 && square < 1.4 * 1.4) grounds.add(patch, v, u);  // clear of the edge's blur
        if (square > 0.85 * 0.85 && square < 0.95 * 0.95)
          paints.add(patch, v, u);  // of the thinnest ring too
      }
    }
    ground = grounds.median();
    paint = paints.median();
  }

  /// Of a colour from the nearest mixture of the two: worn paint, blurred lines.
  [[nodiscard]] double off_mixtures(const Colour& c) const {
    const Colour apart = paint - ground;
    const double share = ((c - ground) * apart).sum() / std::max(1.0, apart.square().sum());
    return difference(c, ground + std::clamp(share, 0.0, 1.0) * apart);
  }
};

/// What is inside a round edge.
struct Inside {
  double off_surround = 0;    ///< levels, between its core and the rest of the circle's inside
  double off_mixtures = 0;    ///< levels
  double two_sided = 0;       ///< share of its directions in which inside and outside differ
  double like_surround = 0;   ///< share of its core that looks like the rest of the circle's inside
  bool goes_through = false;  ///< a stripe of its core's colour goes on beyond it on both sides
};

/// Whether what has a core's colour goes on beyond a round edge on two opposite sides, as a stripe does. The
/// wall of a cargo is seen on one side.
bool goes_through(const Patch& patch, const RoundFit& fit, const Colour& own, const Colour& around,
                  double clear) {
  constexpr std::array radii{1.40F, 1.50F, 1.60F};
  constexpr double least_levels =
      24;  // of the two apart: half of it is three sigma of the mean of three pixels
  if (difference(own, around) < least_levels) return false;
  std::array<bool, directions> is_own{};
  for (std::size_t k = 0; k < directions; ++k) {
    const Direction& d = all_directions()[k];
    Colour sum = Colour::Zero();
    int count = 0;
    for (const float radius : radii) {
      const float off = radius * static_cast<float>(fit.circle_px.z());
      const auto [u, v] = pixel_at(static_cast<float>(fit.circle_px.x()) + off * d.u,
                                   static_cast<float>(fit.circle_px.y()) + off * d.v);
      if (!patch.sees(v, u) || square_off_middle(v, u) > clear * clear) continue;
      for (int c = 0; c < patch.pixels.channels(); ++c) sum[c] += patch.pixels.ptr(v, u)[c];
      ++count;
    }
    is_own[k] = count > 0 && difference(sum / count, own) < difference(sum / count, around);
  }
  constexpr std::size_t half = directions / 2;
  for (std::size_t k = 0; k < half; ++k)
    if (is_own[k] && (is_own[k + half - 1] || is_own[k + half] || is_own[(k + half + 1) % directions]))
      return true;
  return false;
}

/// Between the means just inside and just outside; nothing where either is out of view.
std::optional<double> difference_towards(const Patch& patch, const RoundFit& fit, const Direction& d) {
  constexpr std::array inner{0.60F, 0.68F, 0.76F, 0.84F, 0.92F};
  constexpr std::array outer{1.10F, 1.18F, 1.26F, 1.34F};
  const auto mean = [&](const auto& radii) -> std::optional<Colour> {
    Colour sum = Colour::Zero();
    int count = 0;
    for (const float radius : radii) {
      const float off = radius * static_cast<float>(fit.circle_px.z());
      const auto [u, v] = pixel_at(static_cast<float>(fit.circle_px.x()) + off * d.u,
                                   static_cast<float>(fit.circle_px.y()) + off * d.v);
      if (!patch.sees(v, u)) continue;
      for (int k = 0; k < patch.pixels.channels(); ++k) sum[k] += patch.pixels.ptr(v, u)[k];
      ++count;
    }
    if (count == 0) return std::nullopt;
    return Colour(sum / count);
  };
  const auto in = mean(inner), out = mean(outer);
  if (!in || !out) return std::nullopt;
  return difference(*in, *out);
}

/// Medians of some thousand pixels have next to no noise: 8 levels are a difference that paint and ground of
/// one colour do not have in uneven light, and 12 are what blur and camera add to a mixture of two.
bool has_own_colour(const Inside& inside) {
  constexpr double least_off_surround = 8, least_off_mixtures = 12;
  return inside.off_surround >= least_off_surround && inside.off_mixtures >= least_off_mixtures;
}

/// Where rings are painted: a circle's middle is seen to a twentieth of its radius, and a tenth off that of
/// what is smaller around the same one, seen obliquely from near by.
bool is_in_the_middle(const RoundFit& fit) {
  constexpr double middle = 0.12;
  return std::hypot(fit.circle_px.x() - middle_px, fit.circle_px.y() - middle_px) < middle * unit_px;
}

/// Than worn paint ever is, and not in the middle, where rings are painted.
bool is_rounder(const RoundFit& fit) {
  return fit.coverage >= 0.85 && fit.error < 0.12 && !is_in_the_middle(fit);
}

Inside inside_of(const Patch& patch, const Surface& surface, const RoundFit& fit) {
  constexpr double least_levels = 8;  // three sigma of a noisy camera's pixel, of which several are averaged
  Colours core, surround;
  const Eigen::Vector3d& circle = fit.circle_px;
  for (int v = 0; v < patch_px; v += sampled_each_px) {
    for (int u = 0; u < patch_px; u += sampled_each_px) {
      const double du = (u - circle.x()) / circle.z(), dv = (v - circle.y()) / circle.z();
      const double square = du * du + dv * dv;
      if (square < 0.7 * 0.7) core.add(patch, v, u);
      // beyond the stroke of a painted ring, and inside the circle's own
      if (square > 1.35 * 1.35 && square_off_middle(v, u) < surface.clear * surface.clear)
        surround.add(patch, v, u);
    }
  }
  Inside inside;
  if (core.empty() || surround.empty()) return inside;
  const Colour own = core.median();
  const Colour around = surround.median();
  inside.off_surround = difference(own, around);
  inside.like_surround = core.share_near(around, least_levels);
  if (is_in_the_middle(fit)) inside.goes_through = goes_through(patch, fit, own, around, surface.clear);
  inside.off_mixtures = surface.off_mixtures(own);
  if (!has_own_colour(inside) && !is_rounder(fit)) return inside;  // nothing would be made of the rest
  int differ = 0, looked = 0;
  for (const Direction& direction : all_directions()) {
    const auto levels = difference_towards(patch, fit, direction);
    looked += levels ? 1 : 0;
    differ += levels && *levels > least_levels ? 1 : 0;
  }
  inside.two_sided = static_cast<double>(differ) / std::max(looked, 1);
  return inside;
}

/// A cargo that stands there and is as grey as the paint or the ground is given up for it. Of a stripe across
/// a ring the ground beside it is seen within the ring; of a cargo none.
bool may_be_paint(const RoundFit& fit, const Inside& inside) {
  constexpr double most_like_surround = 0.25;
  const bool is_stripe = inside.like_surround > most_like_surround || inside.goes_through;
  return is_in_the_middle(fit) && (is_stripe || !has_own_colour(inside));
}

constexpr double half_coverage = 0.5;

enum class Sign { cargo, perhaps, none };

/// Whether a cargo makes this round edge, be it its rim, its foot or its shadow.
Sign sign_of_cargo(const RoundFit& fit, const Inside& inside) {
  constexpr double least_coverage = 0.75;  // rope, handle and a side as bright as the ground hide a quarter
  constexpr double least_two_sided = 0.85;
  constexpr double most_error = 0.2;  // a pixel of the patch
  const bool other_colour = has_own_colour(inside);
  const bool is_round =
      fit.coverage >= least_coverage && fit.error < most_error && inside.two_sided >= least_two_sided;
  if (is_round && other_colour) return Sign::cargo;
  // a cargo as grey as a mixture of the two: if rounder than paint, and clear of what surrounds it
  const bool rounder = is_round && is_rounder(fit);
  if (rounder && inside.off_surround >= 12) return Sign::cargo;
  const bool half_round = fit.coverage >= half_coverage && inside.two_sided >= 0.7;
  return rounder || (other_colour && half_round) ? Sign::perhaps : Sign::none;
}

/// Whether a round edge is a rim. Of several round edges of a cargo (rim, foot, shadow) the rim is the
/// roundest and furthest out: away from the point under the camera it leans over its foot by its height times
/// the tangent of the line of sight.
class Evidence {
 public:
  Evidence(const Ellipse& circle, cv::Size image) {
    const double out_u = circle.u_px - image.width / 2.0, out_v = circle.v_px - image.height / 2.0;
    const double c = std::cos(circle.alpha_rad), s = std::sin(circle.alpha_rad);
    const Eigen::Vector2d out((c * out_u + s * out_v) / circle.a_px, (-s * out_u + c * out_v) / circle.b_px);
    // of the image's width: only how much to lean on leaning depends on it
    constexpr double focal_length = 0.6;
    lean_ = std::hypot(out_u, out_v) / (focal_length * image.width) * out / std::max(out.norm(), 1e-9);
  }
  /// Coefficients by logistic regression on round edges, true and false ones, in 500 rendered scenes.
  [[nodiscard]] double log_odds(const RoundFit& fit, double off_mixtures_levels) const {
    const Eigen::Vector2d off_middle =
        (fit.circle_px.head<2>() - Eigen::Vector2d(middle_px, middle_px)) / static_cast<double>(unit_px);
    return 15.8 * fit.coverage - 28.7 * fit.error + 0.59 * std::log(3 + off_mixtures_levels) +
           10.2 * lean_.dot(off_middle) - 14.2;
  }

 private:
  Eigen::Vector2d lean_;
};

/// What fits best where a rim is cut by the border is another edge as often as not (35 of 68 in 600 rendered
/// scenes): off by half of its radius, and by a tenth in size.
void doubt(EllipseFit& rim) {
  const double off_px2 = 0.25 * rim.ellipse.b_px * rim.ellipse.b_px,
               size_px2 = 0.01 * rim.ellipse.b_px * rim.ellipse.b_px;
  rim.covariance(0, 0) += off_px2 / 2;
  rim.covariance(1, 1) += off_px2 / 2;
  rim.covariance.block<2, 2>(2, 2).array() += size_px2;
}

/// A quarter of a rim's edge lies where there is nothing in an empty circle.
constexpr int fewest_edge_pixels = 17;

int edge_pixels_within(const Edges& edges, double radius) {
  const double radius_px = radius * unit_px;
  int count = 0;
  for (int v = 1; v < patch_px - 1; ++v) {
    const double y = v - static_cast<double>(middle_px), square = radius_px * radius_px - y * y;
    if (square <= 0) continue;
    const double half_px = std::sqrt(square);
    const int first = std::max(1, cvCeil(static_cast<double>(middle_px) - half_px)),
              last = std::min(patch_px - 2, cvFloor(static_cast<double>(middle_px) + half_px));
    const float* row = edges.magnitude[v];
    for (int u = first; u <= last; ++u) count += row[u] >= edges.threshold ? 1 : 0;
  }
  return count;
}

}  // namespace

RimSearch look_for_rim(const cv::Mat& image, const Ellipse& circle, const std::optional<EllipseFit>& inner,
                       const RimRadii& radii) {
  const double smallest = radii.smallest * unit_px, largest = radii.largest * unit_px;
  // as good as fixed: of a rim's two edges the wrong one would pull at it from everywhere
  const double radius_weight = radii.known ? 300 : 0;
  const std::array bands_px = radii.known ? std::array{2.5F, 1.F, 1.F} : std::array{3.F, 2.F, 1.5F};
  // a cargo stands within 0.4 radii of the middle: of a circle cut at a quarter of its area half of a rim is
  // seen
  constexpr double least_in_view = 0.75;
  RimSearch out;
  const bool out_of_view = share_in_view(circle, image.size()) < least_in_view;
  const Patch patch = round_patch(image, circle);
  if (patch.pixels.empty()) return out;
  const Edges edges = edges_of(patch);
  const double clear = clear_radius(circle, inner);
  if (edge_pixels_within(edges, clear) < fewest_edge_pixels) {
    if (!out_of_view) out.occupied = false;
    return out;
  }
  const Surface surface(patch, clear);
  constexpr double least_log_odds =
      -0.5;  // a rim that is there is missed at more cost than a foot is taken for it
  const Evidence evidence(circle, image.size());
  std::optional<RoundFit> best;
  double most = least_log_odds;
  bool cargo = false, perhaps = out_of_view;
  for (const Place& place : voted_places(edges, radii_tried_px(radii))) {
    const auto fit = fitted(patch, edges, place, bands_px, radius_weight);
    if (!fit || fit->circle_px.z() < smallest || fit->circle_px.z() > largest) continue;
    // of half an edge no colour makes a sign, and hardly any a rim
    const bool may_be_rim = radii.known && evidence.log_odds(*fit, 255) > most;
    if (fit->coverage < half_coverage && !may_be_rim) continue;
    const Inside inside = inside_of(patch, surface, *fit);
    if (may_be_paint(*fit, inside)) continue;
    const Sign sign = sign_of_cargo(*fit, inside);
    cargo = cargo || sign == Sign::cargo;
    perhaps = perhaps || sign == Sign::perhaps;
    // one of any size needs colour's word as well
    const double log_odds = evidence.log_odds(*fit, inside.off_mixtures);
    if ((radii.known || sign == Sign::cargo) && log_odds > most) most = log_odds, best = *fit;
  }
  if (best) {
    if (!radii.known) best = outermost(patch, edges, *best);
    out.rim = Rim{in_image(*best, circle), best->coverage, best->error};
    if (share_in_view(out.rim->fit.ellipse, image.size()) < least_in_view) doubt(out.rim->fit);
  }
  if (best || cargo) out.occupied = true;
  if (!out.occupied && !perhaps) out.occupied = false;
  return out;
}

bool is_painted(const cv::Mat& image, const Ellipse& circle, const std::optional<EllipseFit>& inner,
                const Ellipse& edge) {
  const Patch patch = round_patch(image, circle);
  if (patch.pixels.empty()) return false;
  RoundFit fit{};
  fit.circle_px = in_patch(edge, circle);
  return may_be_paint(fit, inside_of(patch, Surface(patch, clear_radius(circle, inner)), fit));
}

}  // namespace stevedore
