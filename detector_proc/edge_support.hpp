// What the frame says about an ellipse: edges found along its normals.
#pragma once

#include <array>
#include <optional>

#include "detector_proc/conic_sums.hpp"
#include "detector_proc/gradient_field.hpp"

namespace stevedore {

/// Where the bright side of an edge is.
enum class Bright : signed char { within = 1, without = -1 };

/// The edge next to one point of an ellipse.
struct EdgeSample {
  bool in_frame = false;
  bool found = false;
  float offset_px = 0;  ///< from the ellipse outwards, along its normal
  float strength = 0;   ///< gradient along the normal, in the units of GradientField
  float length_px = 0;  ///< of the perimeter that the sample stands for
  EdgePoint point;
};

struct EdgeSupport {
  static constexpr int max_samples = 96;
  std::array<EdgeSample, max_samples> samples;
  int count = 0;

  double perimeter_px = 0;
  double visible_px = 0;    ///< of the perimeter within the frame
  double supported_px = 0;  ///< of it with an edge
  double rms_px = 0;        ///< of the offsets
  double strength = 0;      ///< mean
  double unevenness = 0;    ///< deviation of the strength over its mean

  [[nodiscard]] double coverage() const { return supported_px / perimeter_px; }
};

/// Looks for the strongest edge of this contrast within `band_px` of the ellipse, at `count` points of its
/// perimeter; edges count from `threshold` on and within 25 degrees of the normal.
EdgeSupport look_along(const GradientField& field, const Ellipse& ellipse, Bright bright, double band_px,
                       int threshold, int count);

/// As many samples as tell something new: one every three pixels, the width of the derivative's blur.
int sample_count(const Ellipse& ellipse);

/// Leaves out samples further off than the others scatter: edges of what stands in front.
void drop_outliers(EdgeSupport& support);

/// Where Tukey's weights end: 4.7 deviations of what is not an outlier, taken from the median (Huber 1981);
/// `least_deviation_px`: an edge's own error, never an outlier.
double outlier_limit_px(const EdgeSupport& support, double least_deviation_px);

/// Measures the offsets of the edges found from another ellipse.
void measure_from(EdgeSupport& support, const Ellipse& ellipse);

/// The ellipse through the edges found, weighted so that distances count (Sampson 1982); offsets are measured
/// from it then.
std::optional<Ellipse> refit(EdgeSupport& support, const Ellipse& ellipse);

}  // namespace stevedore
