#include "detector_proc/ellipse_search.hpp"

#include <algorithm>
#include <cmath>

#include "detector_proc/ellipse_covariance.hpp"
#include "detector_proc/ellipse_distance.hpp"
#include "detector_proc/evidence.hpp"

namespace stevedore {
#ifdef DUMP
std::vector<EllipseEdge> dump_edges;
#endif
namespace {

Bright bright_of(const Arc& arc) {
  return arc.turn_rad > 0 ? Bright::within : Bright::without;
}

/// Share of an arc's points within `distance_px` of the ellipse.
double share_on(const Ellipse& e, const std::vector<EdgePoint>& points, const Arc& arc, double distance_px) {
  const EllipseDistance distance(e);
  int on = 0, looked_at = 0;
  const int step = std::max(1, (arc.end - arc.begin) / 12);
  for (int k = arc.begin; k < arc.end; k += step, ++looked_at) {
    const EdgePoint& p = points[static_cast<std::size_t>(k)];
    if (std::abs(distance(p.u_px, p.v_px)) < distance_px) ++on;
  }
  return static_cast<double>(on) / looked_at;
}

/// An ellipse through an arc lies on the inner side of the arc's tangents, and beyond its chord.
class InnerSide {
 public:
  InnerSide(const std::vector<EdgePoint>& points, const Arc& arc)
      : first_(points[static_cast<std::size_t>(arc.begin)]),
        last_(points[static_cast<std::size_t>(arc.end - 1)]),
        sign_(arc.turn_rad > 0 ? 1.F : -1.F) {
    chord_u_ = last_.u_px - first_.u_px;
    chord_v_ = last_.v_px - first_.v_px;
    const float length = std::hypot(chord_u_, chord_v_);
    if (length > 0) chord_u_ /= length, chord_v_ /= length;
  }

  [[nodiscard]] bool holds(const EdgePoint& p) const {
    constexpr float slack_px = 3;  // of sub-pixel places and of tangents that err by 3 degrees over 60 px
    return inner(first_, first_.tangent_u, first_.tangent_v, p) > -slack_px &&
           inner(last_, last_.tangent_u, last_.tangent_v, p) > -slack_px &&
           inner(first_, chord_u_, chord_v_, p) > -slack_px;
  }

 private:
  [[nodiscard]] float inner(const EdgePoint& from, float tu, float tv, const EdgePoint& p) const {
    return sign_ * (tu * (p.v_px - from.v_px) - tv * (p.u_px - from.u_px));
  }

  EdgePoint first_, last_;
  float sign_;
  float chord_u_, chord_v_;
};

bool mutually_inner(const std::vector<EdgePoint>& points, const Arc& a, const Arc& b) {
  const auto holds_arc = [&](const InnerSide& side, const Arc& arc) {
    return side.holds(points[static_cast<std::size_t>(arc.begin)]) &&
           side.holds(points[static_cast<std::size_t>(arc.end - 1)]) &&
           side.holds(points[static_cast<std::size_t>((arc.begin + arc.end) / 2)]);
  };
  return holds_arc(InnerSide(points, a), b) && holds_arc(InnerSide(points, b), a);
}

}  // namespace

std::vector<EllipseEdge> EllipseSearch::search(const Arcs& arcs) {
  arcs_ = &arcs;
  found_.clear();
  free_.resize(arcs.arcs.size());
  for (std::size_t k = 0; k < free_.size(); ++k) free_[k] = static_cast<int>(k);
  const auto length = [&](int k) {
    const Arc& arc = arcs.arcs[static_cast<std::size_t>(k)];
    return arc.end - arc.begin;
  };
  std::stable_sort(free_.begin(), free_.end(), [&](int a, int b) { return length(a) > length(b); });
  from_single_arcs();
  from_pairs();
  std::stable_sort(found_.begin(), found_.end(),
                   [](const EllipseEdge& a, const EllipseEdge& b) { return a.evidence > b.evidence; });
  return std::move(found_);
}

void EllipseSearch::from_single_arcs() {
  // An arc of less than 60 degrees leaves the ellipse open; pairs will do.
  constexpr float min_turn_rad = 1.05F;
  const std::vector<int> order = free_;
  for (const int k : order) {
    if (std::find(free_.begin(), free_.end(), k) == free_.end()) continue;
    const Arc& arc = arcs_->arcs[static_cast<std::size_t>(k)];
    if (std::abs(arc.turn_rad) < min_turn_rad) continue;
    if (try_sums(arc.sums, bright_of(arc))) continue;
    const int middle = (arc.begin + arc.end) / 2;
    try_sums(sums_of(arcs_->points, arc.begin, middle, frame_), bright_of(arc)) ||
        try_sums(sums_of(arcs_->points, middle, arc.end, frame_), bright_of(arc));
  }
}

void EllipseSearch::from_pairs() {
  // The longest arcs; texture may leave hundreds, and a mark's are among its longest.
  constexpr std::size_t most_arcs = 160;
  std::vector<int> order(free_.begin(),
                         free_.begin() + static_cast<std::ptrdiff_t>(std::min(free_.size(), most_arcs)));
  const auto is_free = [&](int k) { return std::find(free_.begin(), free_.end(), k) != free_.end(); };
  for (std::size_t i = 0; i < order.size(); ++i) {
    for (std::size_t j = i + 1; j < order.size() && is_free(order[i]); ++j) {
      const Arc& a = arcs_->arcs[static_cast<std::size_t>(order[i])];
      const Arc& b = arcs_->arcs[static_cast<std::size_t>(order[j])];
      if (bright_of(a) != bright_of(b) || !is_free(order[j]) || !mutually_inner(arcs_->points, a, b))
        continue;
      ConicSums sums = a.sums;
      sums.add(b.sums);
      const auto ellipse = sums.solve(frame_);
      if (!ellipse || !plausible(*ellipse)) continue;
      const double near_px = std::max(2.0, 0.06 * ellipse->b_px);
      if (share_on(*ellipse, arcs_->points, a, near_px) < 0.7 ||
          share_on(*ellipse, arcs_->points, b, near_px) < 0.7)
        continue;
      if (auto edge = settle(*ellipse, bright_of(a), settings_.min_log_odds)) keep(std::move(*edge));
    }
  }
}

bool EllipseSearch::try_sums(const ConicSums& sums, Bright bright) {
  const auto ellipse = sums.solve(frame_);
  if (!ellipse) return false;
  auto edge = settle(*ellipse, bright, settings_.min_log_odds);
  if (!edge) return false;
  keep(std::move(*edge));
  return true;
}

bool EllipseSearch::plausible(const Ellipse& e) const {
  const double width = field_.magnitude.cols, height = field_.magnitude.rows;
  const double diagonal_px = std::hypot(width, height);
  return e.b_px >= settings_.min_semi_minor_px && e.a_px <= settings_.max_aspect * e.b_px &&
         e.a_px <= settings_.max_relative_size * diagonal_px && e.u_px > -e.a_px && e.v_px > -e.a_px &&
         e.u_px < width + e.a_px && e.v_px < height + e.a_px;
}

bool EllipseSearch::at_first_sight(const Ellipse& e, Bright bright) const {
  const EdgeSupport support =
      look_along(field_, e, bright, std::max(2.0, 0.1 * e.b_px), thresholds_.follow, 16);
  return support.supported_px > 0.3 * support.perimeter_px;
}

std::optional<EllipseEdge> EllipseSearch::settle(const Ellipse& guess, Bright bright,
                                                 double min_log_odds) const {
  if (!plausible(guess) || !at_first_sight(guess, bright)) return std::nullopt;
  Ellipse e = guess;
  for (const double band : {0.1, 0.03}) {
    const EdgeSupport support = look_along(field_, e, bright, std::clamp(band * e.b_px, 2.0, 8.0),
                                           thresholds_.follow, sample_count(e));
    const auto better = refit(support, e);
    if (!better || !plausible(*better)) return std::nullopt;
    e = *better;
  }
  EllipseEdge edge{e, bright, look_along(field_, e, bright, 1.0, thresholds_.follow, sample_count(e)), 0};
  drop_outliers(edge.support);
  edge.open_px = worst_deviation_px(e, covariance_of(e, edge.support, std::max(edge.support.rms_px, 0.1)));
  edge.evidence = log_odds(edge.support);
#ifdef DUMP
  dump_edges.push_back(edge);
#endif
  if (edge.evidence < min_log_odds || edge.open_px > settings_.max_open_ratio * e.b_px) return std::nullopt;
  return edge;
}

void EllipseSearch::keep(EllipseEdge edge) {
  std::erase_if(free_, [&](int k) {
    const Arc& arc = arcs_->arcs[static_cast<std::size_t>(k)];
    return bright_of(arc) == edge.bright && share_on(edge.ellipse, arcs_->points, arc, 2) > 0.6;
  });
  found_.push_back(std::move(edge));
}

}  // namespace stevedore
