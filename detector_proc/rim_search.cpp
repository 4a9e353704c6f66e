#include "detector_proc/rim_search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "detector_proc/rim_colours.hpp"
#include "detector_proc/round_fit.hpp"

namespace stevedore {
namespace {

/// Steps of an eighth: two edge pixels of a rim.
std::vector<float> radii_tried_px(const RimRadii& radii) {
  if (radii.known) return {static_cast<float>((radii.smallest + radii.largest) / 2 * unit_px)};
  std::vector<float> tried;
  for (double r = radii.smallest; r < radii.largest * 1.06; r *= 1.125)
    tried.push_back(static_cast<float>(r * unit_px));
  return tried;
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

int edge_pixels_within(const PatchEdges& edges, double radius) {
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
  const RoundPatch patch = round_patch(image, circle);
  if (patch.pixels.empty()) return out;
  const PatchEdges edges = edges_of(patch);
  const double clear = clear_radius(circle, inner);
  if (edge_pixels_within(edges, clear) < fewest_edge_pixels) {
    if (!out_of_view) out.occupied = false;
    return out;
  }
  const CircleColours surface(patch, clear);
  constexpr double least_log_odds =
      -0.5;  // a rim that is there is missed at more cost than a foot is taken for it
  const Evidence evidence(circle, image.size());
  std::optional<RoundFit> best;
  double most = least_log_odds;
  bool cargo = false, perhaps = out_of_view;
  for (const RoundPlace& place : voted_places(edges, radii_tried_px(radii))) {
    const auto fit = fitted(patch, edges, place, bands_px, radius_weight);
    if (!fit || fit->circle_px.z() < smallest || fit->circle_px.z() > largest) continue;
    // of half an edge no colour makes a sign, and hardly any a rim
    const bool may_be_rim = radii.known && evidence.log_odds(*fit, 255) > most;
    if (fit->coverage < half_coverage && !may_be_rim) continue;
    const RimInside inside = inside_of(patch, surface, *fit);
    if (may_be_paint(*fit, inside)) continue;
    const CargoSign sign = sign_of_cargo(*fit, inside);
    cargo = cargo || sign == CargoSign::cargo;
    perhaps = perhaps || sign == CargoSign::perhaps;
    // one of any size needs colour's word as well
    const double log_odds = evidence.log_odds(*fit, inside.off_mixtures);
    if ((radii.known || sign == CargoSign::cargo) && log_odds > most) most = log_odds, best = *fit;
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
  const RoundPatch patch = round_patch(image, circle);
  if (patch.pixels.empty()) return false;
  RoundFit fit{};
  fit.circle_px = in_patch(edge, circle);
  return may_be_paint(fit, inside_of(patch, CircleColours(patch, clear_radius(circle, inner)), fit));
}

}  // namespace stevedore
