// Settings of the detector. Pixels and grey levels of the image as the detector is given it.
#pragma once

#include <string>
#include <vector>

namespace stevedore {

/// Colours that count as paint: hue, saturation and value as of cv::COLOR_BGR2HSV. A grey frame is a colour
/// frame of hue 0 and saturation 0, so that a range from saturation 0 acts on the grey level alone.
struct ColorRange {
  double hue_low_deg = 0;  ///< low > high: the range goes through 360 degrees (red)
  double hue_high_deg = 360;
  int saturation_low = 0;
  int saturation_high = 255;
  int value_low = 0;
  int value_high = 255;
};

template <class Visitor>
void describe(ColorRange& c, Visitor& visit) {
  visit("hue_low_deg", c.hue_low_deg, 0.0, 360.0, "deg", "raise: fewer hues at the lower end");
  visit("hue_high_deg", c.hue_high_deg, 0.0, 360.0, "deg", "raise: more hues at the upper end");
  visit("saturation_low", c.saturation_low, 0, 255, "of 255", "raise: pale paint is no longer accepted");
  visit("saturation_high", c.saturation_high, 0, 255, "of 255", "raise: more vivid paint is accepted");
  visit("value_low", c.value_low, 0, 255, "of 255", "raise: paint in shadow is no longer accepted");
  visit("value_high", c.value_high, 0, 255, "of 255", "raise: brighter paint is accepted");
}

struct DetectorSettings {
  std::string method = "arcs";

  // Method arcs. Frames are reduced by a whole factor until their longer side is below twice the working
  // size; sizes there are relative to the image.
  int working_size_px = 640;
  double min_semi_minor_px = 7;  ///< at working size: nearer than 14 px the two sides of an ellipse, or of
                                 ///< the ring that it bounds, blur into each other under the 5x5 derivative
  double min_log_odds = 0;       ///< of an ellipse against texture: as likely as not
  double max_open_ratio = 0.07;  ///< deviation of the least certain part of the edge over the semi-minor
                                 ///< axis: two deviations there cost 0.2 of overlap at most

  std::string search =
      "full";                 ///< region: where the tracker expects marks, the whole frame on a schedule and
                              ///< whenever one is not found there. Whoever is new waits for the schedule
  int full_every_frames = 6;  ///< 0.2 s at 30 Hz
  double rim_ratio = 0.32;    ///< a cargo's rim over a painted circle, radii: 0.16 m and 0.5 m
  double cargo_height_ratio = 0.6;  ///< its height over the circle's radius: 0.3 m
  /// Rows and columns of pixels that the sub-pixel fit looks at, of each edge, four times as many in its last
  /// round, where a mark is expected as many; 0: all in the last round.
  int subpixel_strips = 64;

  // Method paper, from here on.

  // Contours. Gradients as cv::Canny counts them (3x3 Sobel, |du| + |dv|): a sharp step of n grey levels
  // reads 2.5 n after the 5x5 blur. 150 starts edges of 60 levels and more, 50 follows them down to 20, four
  // times the noise of a small camera (5 levels).
  double canny_low = 50;
  double canny_high = 150;
  std::vector<ColorRange> colors;

  // Eq. (5). The moments are those of the area within the contour, scaled: see affine_moments.hpp.
  double ami_i1_tolerance = 3e-4;
  double ami_i2_tolerance = 1e-7;
  double ami_i3_tolerance = 1e-6;

  // Post-processing.
  double max_error = 0.1;      ///< eq. (4), the paper's value
  double max_error_px = 0.25;  ///< mean distance that passes in any case. Rounding to the pixel grid alone is
                               ///< 0.25 px, and eq. (4) makes 2 * 0.25 / b of it: above 0.1 for b < 5 px
  bool use_hull = true;        ///< the convex-hull path, section 3.2
  int min_contour_points = 16;  ///< perimeter of the smallest ellipse below: 2 pi 3 = 19, less a gap
  double min_semi_axis_px = 3;  ///< below, a pixel's quantisation is a tenth of the axis and anything fits
  double min_semi_axis_partial_px = 12;
  double max_aspect = 5;             ///< a / b of a circle seen 78 degrees from its normal
  double max_relative_size = 1;      ///< semi-major axis over the image's diagonal
  double support_distance_px = 1.5;  ///< an edge pixel is within 0.7 px of its edge; as much again for noise
  double min_coverage_whole = 0.7;
  double min_coverage_partial = 0.4;

  // Several contours of one mark.
  double same_distance_px = 2.5;      ///< the two sides of an edge as Canny sees it are at most 2 px apart
  double same_distance_ratio = 0.05;  ///< of the semi-minor axis: hulls and contours of one big blurred edge
  double min_ring_ratio = 0.5;        ///< inner over outer edge; a 0.16 m rim in a 0.5 m circle is 0.32, from
                                      ///< a metre above it 0.46
  double max_ring_spread = 0.15;      ///< of that ratio round the ring: perspective shifts the centres
};

template <class Visitor>
void describe(DetectorSettings& s, Visitor& visit) {
  visit.choice("method", s.method, {"arcs", "paper"}, "how ellipses are found");
  visit("working_size_px", s.working_size_px, 64, 10000, "px",
        "arcs; raise: smaller marks are found in large frames, at more cost");
  visit("min_semi_minor_px", s.min_semi_minor_px, 3.0, 1000.0, "px",
        "arcs; at working size; raise: small ellipses are left out");
  visit("min_log_odds", s.min_log_odds, -20.0, 20.0, "1",
        "arcs; raise: fewer false ellipses, more missed that are small or hidden");
  visit("max_open_ratio", s.max_open_ratio, 0.001, 1.0, "1",
        "arcs; raise: ellipses of which little is seen are accepted");
  visit.choice("search", s.search, {"full", "region"},
               "arcs; region: look where the tracker expects marks, the whole frame now and then");
  visit("full_every_frames", s.full_every_frames, 1, 1000, "frames",
        "region search; raise: new marks are noticed later, at less cost");
  visit("rim_ratio", s.rim_ratio, 0.1, 0.6, "1", "radius of a cargo's rim over a painted circle's");
  visit("cargo_height_ratio", s.cargo_height_ratio, 0.0, 1.5, "1",
        "height of a cargo's rim over a painted circle's radius");
  visit("subpixel_strips", s.subpixel_strips, 0, 100000, "rows and columns",
        "arcs; raise: less noise of the sub-pixel edge, at more cost; 0: all there are");
  visit("canny_low", s.canny_low, 1.0, 2000.0, "grey levels", "raise: edges break where they are faint");
  visit("canny_high", s.canny_high, 1.0, 2000.0, "grey levels", "raise: fewer faint circles, less clutter");
  visit.list("colors", s.colors, "colours that count as paint, besides edges");
  visit("ami_i1_tolerance", s.ami_i1_tolerance, 0.0, 1.0, "1",
        "raise: rounder polygons pass as whole ellipses");
  visit("ami_i2_tolerance", s.ami_i2_tolerance, 0.0, 1.0, "1",
        "raise: lopsided contours pass as whole ellipses");
  visit("ami_i3_tolerance", s.ami_i3_tolerance, 0.0, 1.0, "1",
        "raise: lopsided contours pass as whole ellipses");
  visit("max_error", s.max_error, 0.0, 1.0, "1", "raise: contours further from their ellipse are accepted");
  visit("max_error_px", s.max_error_px, 0.0, 10.0, "px",
        "raise: small ellipses may fit their contours worse");
  visit("use_hull", s.use_hull, "fit the convex hull of contours that fail the gate: partial ellipses");
  visit("min_contour_points", s.min_contour_points, 5, 10000, "px", "raise: short contours are left out");
  visit("min_semi_axis_px", s.min_semi_axis_px, 1.0, 1000.0, "px", "raise: small ellipses are left out");
  visit("min_semi_axis_partial_px", s.min_semi_axis_partial_px, 1.0, 1000.0, "px",
        "raise: fewer false ellipses from texture, small cut ones are left out");
  visit("max_aspect", s.max_aspect, 1.0, 100.0, "1", "raise: flatter ellipses are accepted");
  visit("max_relative_size", s.max_relative_size, 0.01, 100.0, "1",
        "raise: ellipses beyond the image are accepted");
  visit("support_distance_px", s.support_distance_px, 0.1, 20.0, "px",
        "raise: coverage counts points further away");
  visit("min_coverage_whole", s.min_coverage_whole, 0.0, 1.0, "1",
        "raise: whole ellipses need more of their edge");
  visit("min_coverage_partial", s.min_coverage_partial, 0.0, 1.0, "1",
        "raise: fewer false ellipses, more missed that are cut or hidden");
  visit("same_distance_px", s.same_distance_px, 0.0, 100.0, "px", "raise: close ellipses merge into one");
  visit("same_distance_ratio", s.same_distance_ratio, 0.0, 1.0, "1",
        "raise: close big ellipses merge into one");
  visit("min_ring_ratio", s.min_ring_ratio, 0.05, 1.0, "1",
        "raise: wide rings count as a circle and a cargo");
  visit("max_ring_spread", s.max_ring_spread, 0.0, 1.0, "1",
        "raise: edges off centre are taken for one ring");
}

}  // namespace stevedore
