#include "detector_proc/ellipse_search.hpp"

#include <algorithm>
#include <cmath>

#include "detector_proc/ellipse_distance.hpp"
#include "detector_proc/evidence.hpp"

namespace stevedore {
namespace {

Bright bright_of(const Arc& arc) {
  return arc.turn_rad > 0 ? Bright::within : Bright::without;
}

/// Share of an arc's points within `distance_px` of the ellipse.
double share_on(const Ellipse& e, const std::vector<EdgePoint>& points, const Arc& arc, double distance_px) {
  const EllipseDistance distance(e);
  int on = 0, looked_at = 0;
  const int step = std::max(1, (arc.end - arc.begin) / 8);
  for (int k = arc.begin; k < arc.end; k += step, ++looked_at) {
    const EdgePoint& p = points[static_cast<std::size_t>(k)];
    if (std::abs(distance(p.u_px, p.v_px)) < distance_px) ++on;
  }
  return static_cast<double>(on) / looked_at;
}

bool on_inner_side(const ArcHull& hull, const EdgePoint& p) {
  constexpr float slack_px = 3;  // of places, and of tangents that err by 3 degrees over 60 px
  for (const auto& line : hull.lines) {
    if (line.u * p.u_px + line.v * p.v_px + line.offset < -slack_px) return false;
  }
  return true;
}

bool mutually_inner(const ArcHull& a, const ArcHull& b) {
  const auto holds = [](const ArcHull& hull, const ArcHull& other) {
    return on_inner_side(hull, other.middle) && on_inner_side(hull, other.first) &&
           on_inner_side(hull, other.last);
  };
  return holds(a, b) && holds(b, a);
}

}  // namespace

std::vector<EllipseEdge> EllipseSearch::search(const Arcs& arcs) {
  arcs_ = &arcs;
  found_.clear();
  taken_.assign(arcs.arcs.size(), false);
  free_.resize(arcs.arcs.size());
  for (std::size_t k = 0; k < free_.size(); ++k) free_[k] = static_cast<int>(k);
  const auto length = [&](int k) {
    const Arc& arc = arcs.arcs[static_cast<std::size_t>(k)];
    return arc.end - arc.begin;
  };
  std::stable_sort(free_.begin(), free_.end(), [&](int a, int b) { return length(a) > length(b); });
  from_single_arcs();
  find_hulls();
  from_pairs();
  std::stable_sort(found_.begin(), found_.end(),
                   [](const EllipseEdge& a, const EllipseEdge& b) { return a.evidence > b.evidence; });
  return std::move(found_);
}

void EllipseSearch::from_single_arcs() {
  // An arc of less than 60 degrees leaves the ellipse open; pairs will do.
  constexpr float min_turn_rad = 1.05F;
  const std::vector<int> order = free_;  // keep() takes out of it
  for (const int k : order) {
    if (!is_free(k)) continue;
    const Arc& arc = arcs_->arcs[static_cast<std::size_t>(k)];
    if (std::abs(arc.turn_rad) < min_turn_rad) continue;
    if (try_sums(arc.sums, bright_of(arc))) continue;
    const int middle = (arc.begin + arc.end) / 2;
    try_sums(sums_of(arcs_->points, arc.begin, middle, frame_), bright_of(arc)) ||
        try_sums(sums_of(arcs_->points, middle, arc.end, frame_), bright_of(arc));
  }
}

void EllipseSearch::find_hulls() {
  hulls_.clear();
  for (const int k : free_) {
    const Arc& arc = arcs_->arcs[static_cast<std::size_t>(k)];
    const EdgePoint &first = arcs_->points[static_cast<std::size_t>(arc.begin)],
                    &last = arcs_->points[static_cast<std::size_t>(arc.end - 1)];
    const float sign = arc.turn_rad > 0 ? 1.F : -1.F;
    const auto line = [&](const EdgePoint& through, float tu, float tv) {
      return ArcHull::Line{-sign * tv, sign * tu, sign * (tv * through.u_px - tu * through.v_px)};
    };
    const float du = last.u_px - first.u_px, dv = last.v_px - first.v_px;
    const float chord = std::max(std::hypot(du, dv), 1e-3F);
    hulls_.push_back({k,
                      arc.end - arc.begin,
                      arc.turn_rad,
                      first,
                      arcs_->points[static_cast<std::size_t>((arc.begin + arc.end) / 2)],
                      last,
                      {line(first, du / chord, dv / chord), line(first, first.tangent_u, first.tangent_v),
                       line(last, last.tangent_u, last.tangent_v)}});
  }
}

void EllipseSearch::from_pairs() {
  // The longest arcs; texture may leave hundreds, and a mark's are among its longest.
  constexpr std::size_t most_arcs = 160;
  // The least support that makes a small ellipse believable, less what lies between the arcs.
  constexpr int min_length = 32;
  // Together they are a fifth of the way round, or the ellipse is anyone's.
  constexpr float min_turn_rad = 1.3F;
  if (hulls_.size() > most_arcs) hulls_.resize(most_arcs);
  for (std::size_t i = 0; i < hulls_.size(); ++i) {
    const ArcHull& a = hulls_[i];
    for (std::size_t j = i + 1; j < hulls_.size() && is_free(a.arc); ++j) {
      const ArcHull& b = hulls_[j];
      if (a.length + b.length < min_length) break;  // they come longest first
      if (std::abs(a.turn_rad + b.turn_rad) >= min_turn_rad && a.turn_rad * b.turn_rad > 0 &&
          mutually_inner(a, b) && is_free(b.arc))
        try_pair(a.arc, b.arc);
    }
  }
}

void EllipseSearch::try_pair(int first, int second) {
  const Arc &a = arcs_->arcs[static_cast<std::size_t>(first)],
            &b = arcs_->arcs[static_cast<std::size_t>(second)];
  ConicSums sums = a.sums;
  sums.add(b.sums);
  const auto ellipse = sums.solve(frame_);
  if (!ellipse || !plausible(*ellipse)) return;
  const double near_px = std::max(1.5, 0.04 * ellipse->b_px);
  if (share_on(*ellipse, arcs_->points, a, near_px) < 0.7 ||
      share_on(*ellipse, arcs_->points, b, near_px) < 0.7)
    return;
  if (auto edge = settle(*ellipse, bright_of(a), settings_.min_log_odds)) keep(std::move(*edge));
}

bool EllipseSearch::is_free(int arc) const {
  return !taken_[static_cast<std::size_t>(arc)];
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

std::optional<EllipseEdge> EllipseSearch::settle(const Ellipse& guess, Bright bright,
                                                 double min_log_odds) const {
  static constexpr Looks looks{{{{0.06, 24, 9}, {0.06, 48, 4}, {0.03, 96, 2}}}, 6, 1};
  return settle(guess, bright, min_log_odds, looks, std::nullopt);
}

std::optional<EllipseEdge> EllipseSearch::settle_like(const Ellipse& guess, Bright bright) const {
  // of a hundred ellipses that texture makes one is within a twentieth of given semi-axes, of a set's marks
  // every one
  constexpr double known_shape_log_odds = 4.6;
  // in bands twice as wide and more, since only votes tell the place, edges are further off at first
  static constexpr Looks looks{{{{0.15, 24, 14}, {0.08, 48, 8}, {0.05, 96, 4}}}, 8, 1.5};
  return settle(guess, bright, settings_.min_log_odds - known_shape_log_odds, looks, ShapePrior{guess});
}

std::optional<EllipseEdge> EllipseSearch::settle(const Ellipse& guess, Bright bright, double min_log_odds,
                                                 const Looks& looks,
                                                 const std::optional<ShapePrior>& prior) const {
  constexpr double least_band_px = 2;
  if (!plausible(guess)) return std::nullopt;
  Ellipse e = guess;
  const auto look = [&](double band_px, int count) {
    return look_along(field_, e, bright, band_px, thresholds_.follow, count);
  };
  // as long as the evidence would do if every edge found were in its place
  for (const auto& [share, most_count, slack] : looks.rounds) {
    EdgeSupport support = look(std::clamp(share * e.b_px, least_band_px, looks.widest_band_px),
                               std::min(sample_count(e), most_count));
    if (best_log_odds(support) < min_log_odds) return std::nullopt;
    const auto better = prior ? refit(support, e, *prior) : refit(support, e);
    if (!better || !plausible(*better)) return std::nullopt;
    e = *better;
    drop_outliers(support);
    if (log_odds(support) < min_log_odds - slack) return std::nullopt;
  }
  EllipseEdge edge{e, bright, look(looks.last_band_px, sample_count(e)), 0, 0, {}};
  drop_outliers(edge.support);
  edge.evidence = log_odds(edge.support);
  if (edge.evidence < min_log_odds) return std::nullopt;
  const double deviation_px = std::max(edge.support.rms_px, 0.1);
  edge.open_px = worst_deviation_px(e, prior ? covariance_of(e, edge.support, deviation_px, *prior)
                                             : covariance_of(e, edge.support, deviation_px));
  if (edge.open_px > settings_.max_open_ratio * e.b_px) return std::nullopt;
  return edge;
}

void EllipseSearch::keep(EllipseEdge edge) {
  std::erase_if(free_, [&](int k) {
    const Arc& arc = arcs_->arcs[static_cast<std::size_t>(k)];
    const bool on = bright_of(arc) == edge.bright && share_on(edge.ellipse, arcs_->points, arc, 2) > 0.6;
    if (on) taken_[static_cast<std::size_t>(k)] = true;
    return on;
  });
  found_.push_back(std::move(edge));
}

}  // namespace stevedore
