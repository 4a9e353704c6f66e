#include "detector_proc/marks.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

#include "detector_proc/ellipse_fit.hpp"

namespace stevedore {
namespace {

using std::numbers::pi;
constexpr int samples = 16;  // points round an ellipse; two ellipses meet at four at most

Eigen::Vector2d sample(const Ellipse& e, int i) {
  return point_at(e, 2 * pi * i / samples);
}

/// Largest distance of the one ellipse from the other.
double separation_px(const Ellipse& of, const Ellipse& from) {
  double largest = 0;
  for (int i = 0; i < samples; ++i) largest = std::max(largest, std::abs(distance_px(from, sample(of, i))));
  return largest;
}

bool same_edge(const Ellipse& kept, const Ellipse& other, const DetectorSettings& s) {
  const double limit_px = std::max(s.same_distance_px, s.same_distance_ratio * kept.b_px);
  // Moved ellipses are as far apart as their centres: most pairs are told apart by that alone.
  if (std::hypot(other.u_px - kept.u_px, other.v_px - kept.v_px) > 2 * limit_px) return false;
  return separation_px(other, kept) <= limit_px;
}

/// Smallest and largest size of the inner ellipse, seen from the outer one's centre, relative to the outer
/// one.
struct Scale {
  double smallest, largest;
};

Scale scale_within(const Ellipse& inner, const Ellipse& outer) {
  Scale scale{1e9, 0};
  for (int i = 0; i < samples; ++i) {
    const double radius = std::sqrt(normalized_radius_squared(outer, sample(inner, i)));
    scale = {std::min(scale.smallest, radius), std::max(scale.largest, radius)};
  }
  return scale;
}

bool concentric(const Ellipse& inner, const Ellipse& outer, const DetectorSettings& s) {
  const Scale scale = scale_within(inner, outer);
  return scale.smallest >= s.min_ring_ratio && scale.largest < 1 &&
         scale.largest - scale.smallest <= s.max_ring_spread;
}

/// Grey level, 0 outside the image.
int level(const cv::Mat& grey, double u, double v) {
  const cv::Point p(static_cast<int>(std::lround(u)), static_cast<int>(std::lround(v)));
  return cv::Rect({0, 0}, grey.size()).contains(p) ? grey.at<uchar>(p) : 0;
}

/// Positive for an ellipse brighter inside than outside, summed two pixels to either side of its edge.
double brightness_step(const Ellipse& e, const cv::Mat& grey) {
  double step = 0;
  for (int i = 0; i < samples; ++i) {
    const Eigen::Vector2d edge = sample(e, i);
    const Eigen::Vector2d out = 2 * (edge - Eigen::Vector2d(e.u_px, e.v_px)).normalized();
    step += level(grey, edge.x() - out.x(), edge.y() - out.y()) -
            level(grey, edge.x() + out.x(), edge.y() + out.y());
  }
  return step;
}

void sort_by_size(std::vector<Detection>& found) {
  const auto key = [](const Detection& d) {
    const Ellipse& e = d.outer.ellipse;
    return std::tuple(-e.a_px * e.b_px, e.v_px, e.u_px);
  };
  std::stable_sort(found.begin(), found.end(), [&](const auto& x, const auto& y) { return key(x) < key(y); });
}

/// Enough of its edge is there to call it what its place says: a circle, or a cargo within one.
bool well_supported(const Detection& d, const DetectorSettings& s) {
  return d.inner || d.coverage >= s.min_coverage_whole;
}

bool contains(const Ellipse& circle, const Ellipse& thing) {
  // Its height takes a bucket's rim away from the centre of the circle that it stands in, not out of it.
  return normalized_radius_squared(circle, {thing.u_px, thing.v_px}) < 1 && thing.a_px < circle.a_px &&
         thing.b_px < circle.b_px;
}

/// No edge within: nothing that differs from the ground stands there. Nothing: the circle is too small to
/// say.
std::optional<bool> plain_inside(const Ellipse& circle, const cv::Mat& edges) {
  constexpr double margin_px = 4;  // Canny's edge of the circle itself is within two pixels of the ellipse
  Ellipse e = circle;
  e.a_px -= margin_px;
  e.b_px -= margin_px;
  if (e.b_px < margin_px) return std::nullopt;
  const int reach = static_cast<int>(std::ceil(e.a_px));
  const cv::Point centre(static_cast<int>(std::lround(e.u_px)), static_cast<int>(std::lround(e.v_px)));
  const cv::Rect around = cv::Rect(centre.x - reach, centre.y - reach, 2 * reach + 1, 2 * reach + 1) &
                          cv::Rect({0, 0}, edges.size());
  for (int v = around.y; v < around.y + around.height; ++v) {
    const uchar* row = edges.ptr<uchar>(v);
    for (int u = around.x; u < around.x + around.width; ++u) {
      if (row[u] != 0 && normalized_radius_squared(e, Eigen::Vector2d(u, v)) < 1) return false;
    }
  }
  return true;
}

}  // namespace

std::vector<Detection> merge_duplicates(std::vector<Detection> found, const DetectorSettings& settings) {
  const auto rank = [](const Detection& d) {
    return std::tuple(d.kind == Kind::partial, -d.coverage, d.error);
  };
  std::stable_sort(found.begin(), found.end(),
                   [&](const auto& x, const auto& y) { return rank(x) < rank(y); });
  std::vector<Detection> kept;
  for (const Detection& d : found) {
    const bool known = std::any_of(kept.begin(), kept.end(), [&](const Detection& k) {
      return same_edge(k.outer.ellipse, d.outer.ellipse, settings);
    });
    if (!known) kept.push_back(d);
  }
  return kept;
}

std::vector<Detection> merge_rings(std::vector<Detection> found, const cv::Mat& grey,
                                   const DetectorSettings& settings) {
  sort_by_size(found);
  std::vector<Detection> marks;
  for (const Detection& d : found) {
    // The two edges of paint step the opposite way: out of it at one, into it at the other.
    const double step = brightness_step(d.outer.ellipse, grey);
    const auto ring = std::find_if(marks.begin(), marks.end(), [&](const Detection& outer) {
      return !outer.inner && concentric(d.outer.ellipse, outer.outer.ellipse, settings) &&
             step * brightness_step(outer.outer.ellipse, grey) < 0;
    });
    if (ring == marks.end()) {
      marks.push_back(d);
    } else {
      ring->inner = d.outer;
    }
  }
  return marks;
}

void label_marks(std::vector<Detection>& found, const cv::Mat& edges, const DetectorSettings& settings) {
  sort_by_size(found);
  for (std::size_t i = 0; i < found.size(); ++i) {
    Detection& d = found[i];
    if (!well_supported(d, settings)) continue;
    d.label = Label::circle;
    for (std::size_t j = 0; j < i; ++j) {
      if (found[j].label != Label::circle || !contains(found[j].outer.ellipse, d.outer.ellipse)) continue;
      found[j].occupied = true;
      d.label = Label::cargo;
    }
  }
  for (Detection& d : found) {
    if (d.label != Label::circle || d.occupied || d.kind != Kind::whole) continue;
    // Edges that make no ellipse may be a cross, a shadow or a cargo seen badly: can't tell.
    if (plain_inside(d.inner ? d.inner->ellipse : d.outer.ellipse, edges) == true) d.occupied = false;
  }
}

}  // namespace stevedore
