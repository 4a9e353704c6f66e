#include "detector_proc/rim_search.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
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
  for (int v = 0; v < patch_px; ++v) {
    for (int u = 0; u < patch_px; ++u) {
      const double x = m(0, 0) * u + m(0, 1) * v + m(0, 2), y = m(1, 0) * u + m(1, 1) * v + m(1, 2);
      patch.seen(v, u) = x >= 0 && y >= 0 && x <= source.cols - 1 && y <= source.rows - 1 ? 1 : 0;
    }
  }
  return patch;
}

/// Gradient of the channel that changes most, pixel by pixel.
struct Edges {
  cv::Mat_<cv::Vec2f> gradient;
  cv::Mat_<float> magnitude;
  float threshold = 0;
};

Edges edges_of(const Patch& patch) {
  cv::Mat smooth;
  cv::GaussianBlur(patch.pixels, smooth, {5, 5}, 1.0);
  std::vector<cv::Mat> planes;
  cv::split(smooth, planes);
  cv::Mat_<int> squares(patch_px, patch_px, 0);
  cv::Mat_<cv::Vec2s> strongest(patch_px, patch_px, cv::Vec2s());
  cv::Mat_<short> du, dv;
  for (const cv::Mat& plane : planes) {
    cv::spatialGradient(plane, du, dv);
    for (int v = 1; v < patch_px - 1; ++v) {
      const short *along = du[v], *down = dv[v];
      int* square = squares[v];
      cv::Vec2s* out = strongest[v];
      for (int u = 1; u < patch_px - 1; ++u) {
        const int s = along[u] * along[u] + down[u] * down[u];
        if (s > square[u]) square[u] = s, out[u] = {along[u], down[u]};
      }
    }
  }
  squares.setTo(0, patch.seen == 0);
  constexpr float per_level = 8;  // the 3x3 derivative of a slope of one level a pixel
  Edges edges;
  strongest.convertTo(edges.gradient, CV_32F, 1 / per_level);
  squares.convertTo(edges.magnitude, CV_32F, 1 / (per_level * per_level));
  cv::sqrt(edges.magnitude, edges.magnitude);
  // noise and texture have the median (to a sixteenth of a level); an edge of less than two grey levels a
  // pixel is none that could be trusted
  std::array<int, 4096> histogram{};
  for (const float m : edges.magnitude) ++histogram[static_cast<std::size_t>(std::min(16 * m, 4095.F))];
  std::size_t median = 0;
  for (int below = histogram[0]; 2 * below < patch_px * patch_px; below += histogram[median]) ++median;
  edges.threshold = std::max(2.F, 2 * static_cast<float>(median) / 16);
  return edges;
}

// ---- votes ----

/// Centres of rims: the cargo stands up to 0.4 radii off the middle, and a rim that is 0.6 radii over the
/// deck is seen that times the tangent of the line of sight further out.
constexpr float farthest_centre_px = 0.9F * unit_px;
constexpr int cell_px = 2;
constexpr int cells = patch_px / cell_px;
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

std::vector<Place> voted_places(const Edges& edges, const std::vector<float>& radii_px) {
  std::vector<int> votes(radii_px.size() * cells * cells);
  const auto at = [](std::size_t r, int j, int i) {
    return (r * cells + static_cast<std::size_t>(j)) * cells + static_cast<std::size_t>(i);
  };
  for (int v = 2; v < patch_px - 2; ++v) {
    for (int u = 2; u < patch_px - 2; ++u) {
      const float m = edges.magnitude(v, u);
      if (m < edges.threshold) continue;
      const float x = static_cast<float>(u) - middle_px, y = static_cast<float>(v) - middle_px;
      const float off_px = std::hypot(x, y);
      if (std::abs(off_px - unit_px) < 2.5F) continue;  // the circle's own edge
      const cv::Vec2f n = edges.gradient(v, u) / m;
      const int su = static_cast<int>(std::lround(n[0])), sv = static_cast<int>(std::lround(n[1]));
      if (m < edges.magnitude(v + sv, u + su) || m < edges.magnitude(v - sv, u - su)) continue;
      for (std::size_t r = 0; r < radii_px.size(); ++r) {
        for (const float side : {1.F, -1.F}) {
          const float cu = static_cast<float>(u) + side * radii_px[r] * n[0],
                      cv = static_cast<float>(v) + side * radii_px[r] * n[1];
          if (std::hypot(cu - middle_px, cv - middle_px) > farthest_centre_px) continue;
          ++votes[at(r, static_cast<int>(cv) / cell_px, static_cast<int>(cu) / cell_px)];
        }
      }
    }
  }
  struct Sum {
    float share;
    Place place;
  };
  std::vector<Sum> sums;
  for (std::size_t r = 0; r < radii_px.size(); ++r) {
    for (int j = 1; j < cells - 1; ++j) {
      for (int i = 1; i < cells - 1; ++i) {
        int sum = 0;
        for (int dj = -1; dj <= 1; ++dj)
          for (int di = -1; di <= 1; ++di) sum += votes[at(r, j + dj, i + di)];
        const float share = static_cast<float>(sum) / (2 * std::numbers::pi_v<float> * radii_px[r]);
        if (share > 0.25F)  // a rim of which half is seen, and half of that is where it should be
          sums.push_back({share,
                          {(static_cast<float>(i) + 0.5F) * cell_px, (static_cast<float>(j) + 0.5F) * cell_px,
                           radii_px[r]}});
      }
    }
  }
  std::sort(sums.begin(), sums.end(), [](const Sum& a, const Sum& b) { return a.share > b.share; });
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
    for (int k = 0; k < directions; ++k) {
      const float t = 2 * std::numbers::pi_v<float> * static_cast<float>(k) / directions;
      const float nu = std::cos(t), nv = std::sin(t);
      const auto along_ray = [&](float radius) {
        return cv::Point(static_cast<int>(std::lround(static_cast<float>(circle.x()) + radius * nu)),
                         static_cast<int>(std::lround(static_cast<float>(circle.y()) + radius * nv)));
      };
      const cv::Point expected = along_ray(static_cast<float>(circle.z()));
      if (!patch.sees(expected.y, expected.x)) continue;
      ++looked;
      float best = 0, best_off = 0;
      for (float off = -band_px; off <= band_px; off += 0.5F) {
        const auto [u, v] = along_ray(static_cast<float>(circle.z()) + off);
        if (!patch.sees(v, u)) continue;
        const float m = edges.magnitude(v, u);
        if (m < edges.threshold) continue;
        const cv::Vec2f& g = edges.gradient(v, u);
        const float along = std::abs(g[0] * nu + g[1] * nv);
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
    for (int k = 0; k < patch.pixels.channels(); ++k)
      levels_[static_cast<std::size_t>(k)].push_back(pixel[k]);
  }
  [[nodiscard]] bool empty() const { return levels_[0].empty(); }
  [[nodiscard]] Colour median() {
    Colour out = Colour::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      if (levels_[k].empty()) continue;
      const auto middle = levels_[k].begin() + static_cast<std::ptrdiff_t>(levels_[k].size() / 2);
      std::nth_element(levels_[k].begin(), middle, levels_[k].end());
      out[static_cast<Eigen::Index>(k)] = *middle;
    }
    return out;
  }

 private:
  std::array<std::vector<std::uint8_t>, 3> levels_;
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

struct Surface {
  Colour ground, paint;
  double clear = 0.72;  ///< radius within which there is no paint of the circle's own: few rings are wider

  Surface(const Patch& patch, const Ellipse& circle, const std::optional<EllipseFit>& inner) {
    if (inner) clear = std::min(clear, inner->ellipse.b_px / circle.b_px - 0.06);  // two pixels of blur
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
  double off_surround = 0;  ///< levels, between its core and the rest of the circle's inside
  double off_mixtures = 0;  ///< levels
  double two_sided = 0;     ///< share of its directions in which inside and outside differ
};

/// Between the means just inside and just outside; nothing where either is out of view.
std::optional<double> difference_towards(const Patch& patch, const RoundFit& fit, float t) {
  constexpr std::array inner{0.60F, 0.68F, 0.76F, 0.84F, 0.92F};
  constexpr std::array outer{1.10F, 1.18F, 1.26F, 1.34F};
  const auto mean = [&](const auto& radii) -> std::optional<Colour> {
    Colour sum = Colour::Zero();
    int count = 0;
    for (const float radius : radii) {
      const float off = radius * static_cast<float>(fit.circle_px.z());
      const int u = static_cast<int>(std::lround(static_cast<float>(fit.circle_px.x()) + off * std::cos(t))),
                v = static_cast<int>(std::lround(static_cast<float>(fit.circle_px.y()) + off * std::sin(t)));
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
  inside.off_surround = difference(own, surround.median());
  inside.off_mixtures = surface.off_mixtures(own);
  int differ = 0, looked = 0;
  for (int k = 0; k < directions; ++k) {
    const auto levels =
        difference_towards(patch, fit, 2 * std::numbers::pi_v<float> * static_cast<float>(k) / directions);
    looked += levels ? 1 : 0;
    differ += levels && *levels > least_levels ? 1 : 0;
  }
  inside.two_sided = static_cast<double>(differ) / std::max(looked, 1);
  return inside;
}

constexpr double half_coverage = 0.5;

enum class Sign { cargo, perhaps, none };

/// Whether a cargo makes this round edge, be it its rim, its foot or its shadow. Medians of some thousand
/// pixels have next to no noise: 8 levels are a difference that paint and ground of one colour do not have in
/// uneven light, and 12 are what blur and camera add to a mixture of two.
Sign sign_of_cargo(const RoundFit& fit, const Inside& inside) {
  constexpr double least_off_surround = 8, least_off_mixtures = 12;
  constexpr double least_coverage = 0.75;  // rope, handle and a side as bright as the ground hide a quarter
  constexpr double least_two_sided = 0.85;
  constexpr double most_error = 0.2;  // a pixel of the patch
  const bool other_colour =
      inside.off_surround >= least_off_surround && inside.off_mixtures >= least_off_mixtures;
  const bool is_round =
      fit.coverage >= least_coverage && fit.error < most_error && inside.two_sided >= least_two_sided;
  if (is_round && other_colour) return Sign::cargo;
  // a cargo as grey as a mixture of the two: if rounder than worn paint ever is, clear of what surrounds it,
  // and not in the middle, where rings are painted
  const double off = std::hypot(fit.circle_px.x() - middle_px, fit.circle_px.y() - middle_px) / unit_px;
  const bool rounder = is_round && fit.coverage >= 0.85 && fit.error < 0.12 && off > 0.08;
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

/// A quarter of a rim's edge lies where there is nothing in an empty circle.
constexpr int fewest_edge_pixels = 17;

int edge_pixels_within(const Edges& edges, double radius) {
  int count = 0;
  for (int v = 1; v < patch_px - 1; ++v)
    for (int u = 1; u < patch_px - 1; ++u)
      count += edges.magnitude(v, u) >= edges.threshold && square_off_middle(v, u) < radius * radius ? 1 : 0;
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
  const Surface surface(patch, circle, inner);
  if (edge_pixels_within(edges, surface.clear) < fewest_edge_pixels) {
    if (!out_of_view) out.occupied = false;
    return out;
  }
  constexpr double least_log_odds =
      -0.5;  // a rim that is there is missed at more cost than a foot is taken for it
  const Evidence evidence(circle, image.size());
  std::optional<RoundFit> best;
  double most = least_log_odds;
  bool cargo = false, perhaps = out_of_view;
  for (const Place& place : voted_places(edges, radii_tried_px(radii))) {
    const auto fit = fitted(patch, edges, place, bands_px, radius_weight);
    if (!fit || fit->circle_px.z() < smallest || fit->circle_px.z() > largest) continue;
    const Inside inside = inside_of(patch, surface, *fit);
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
  }
  if (best || cargo) out.occupied = true;
  if (!out.occupied && !perhaps) out.occupied = false;
  return out;
}

}  // namespace stevedore
