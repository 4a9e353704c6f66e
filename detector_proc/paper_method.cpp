#include "detector_proc/paper_method.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "detector_proc/affine_moments.hpp"
#include "detector_proc/contours.hpp"
#include "detector_proc/ellipse_fit.hpp"
#include "detector_proc/marks.hpp"

namespace stevedore {
namespace {

using Points = std::vector<cv::Point>;

/// Step 2, eq. (5).
bool passes_gate(const Points& points, const DetectorSettings& s) {
  const auto ami = affine_moments(cv::moments(points));
  return ami && std::abs(ami->i1 - ellipse_i1) < s.ami_i1_tolerance &&
         std::abs(ami->i2) < s.ami_i2_tolerance && std::abs(ami->i3) < s.ami_i3_tolerance;
}

Points convex_hull(const Points& points) {
  Points hull;
  cv::convexHull(points, hull);
  return hull;
}

bool plausible(const Ellipse& e, double min_semi_axis_px, cv::Size image, const DetectorSettings& s) {
  const double diagonal_px = std::hypot(image.width, image.height);
  return e.b_px >= min_semi_axis_px && e.a_px <= s.max_aspect * e.b_px &&
         e.a_px <= s.max_relative_size * diagonal_px && e.u_px > -diagonal_px && e.v_px > -diagonal_px &&
         e.u_px < image.width + diagonal_px && e.v_px < image.height + diagonal_px;
}

/// How much larger than the true edge the ellipse of a contour comes out: means over clean renders, constant
/// within 0.1 px from semi-minor axes of 6 px up (at 3 px it is up to 0.15 px smaller). Canny's pixels
/// themselves are unbiased; a region's outermost pixels are half a pixel within it. The hull leaves out all
/// but the pixels that lie furthest outside.
double size_bias_px(Trace trace, bool hull) {
  constexpr double hull_bias_px = 0.35;
  const double contour_bias_px = trace == Trace::edge_outside  ? 0.10
                                 : trace == Trace::edge_inside ? -0.15
                                 : trace == Trace::region      ? -0.47
                                                               : 0.48;
  return contour_bias_px + (hull ? hull_bias_px : 0);
}

/// The fit to a contour's points, its size set right.
EllipseFit fit_of_edge(Ellipse e, const Points& points, Trace trace, bool hull) {
  // Edge errors of a contour's neighbouring pixels go together over the width of the blur and Sobel kernels;
  // the few corners of a hull are far apart. Measured on renders of 4 to 110 px: squared errors over these
  // variances, 3 to 10 where 5 would be exact.
  const double correlation_length_px = hull ? 1 : 3;
  EllipseFit fit{e, fit_covariance(e, points, correlation_length_px)};
  const double bias_px = size_bias_px(trace, hull);
  fit.ellipse.a_px -= bias_px;
  fit.ellipse.b_px -= bias_px;
  // What the mean bias leaves: it differs with the slope of the edge on the pixel grid, so from axis to axis.
  constexpr double size_sigma_px = 0.1;
  fit.covariance.diagonal().segment<2>(2).array() += size_sigma_px * size_sigma_px;
  return fit;
}

/// The contour is too small for the covered part of the smallest partial ellipse, whose ends are at least
/// this far apart. Saves the hull and the fit on most contours of textured ground.
bool too_small_for_partial(const Points& points, const DetectorSettings& s) {
  const double arc_rad = 2 * std::numbers::pi * std::min(s.min_coverage_partial, 0.5);
  const cv::Size2d size = cv::boundingRect(points).size();
  return std::hypot(size.width, size.height) < 2 * s.min_semi_axis_partial_px * std::sin(arc_rad / 2);
}

/// Steps 2 to 4 for one contour.
std::optional<Detection> examine(const Contour& contour, cv::Size image, const DetectorSettings& s) {
  const bool whole = passes_gate(contour.points, s);
  if (!whole && (!s.use_hull || too_small_for_partial(contour.points, s))) return std::nullopt;
  const Points hull = whole ? Points{} : convex_hull(contour.points);
  const Points& points = whole ? contour.points : hull;

  const auto ellipse = fit_ellipse(points);
  const double min_semi_axis_px = whole ? s.min_semi_axis_px : s.min_semi_axis_partial_px;
  if (!ellipse || !plausible(*ellipse, min_semi_axis_px, image, s)) return std::nullopt;

  Detection d;
  d.kind = whole ? Kind::whole : Kind::partial;
  d.error = algebraic_error(*ellipse, points);
  if (!(d.error < std::max(s.max_error, 2 * s.max_error_px / ellipse->b_px))) return std::nullopt;
  d.coverage = coverage(*ellipse, contour.points, s.support_distance_px);
  if (d.coverage < (whole ? s.min_coverage_whole : s.min_coverage_partial)) return std::nullopt;
  d.outer = fit_of_edge(*ellipse, points, contour.trace, !whole);
  return d;
}

}  // namespace

std::vector<Detection> detect_by_paper(const cv::Mat& image, const DetectorSettings& settings) {
  const cv::Mat grey = blurred_grey(image);
  const cv::Mat edges = edge_map(grey, settings);
  std::vector<Detection> found;
  for (const auto& contours : {edge_contours(edges, settings), color_contours(image, settings)}) {
    for (const Contour& contour : contours) {
      if (auto detection = examine(contour, image.size(), settings)) found.push_back(*detection);
    }
  }
  found = merge_rings(merge_duplicates(std::move(found), settings), grey, settings);
  label_marks(found, edges, settings);
  return found;
}

}  // namespace stevedore
