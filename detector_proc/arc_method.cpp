#include "detector_proc/arc_method.hpp"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "detector_proc/edge_owners.hpp"
#include "detector_proc/edge_thresholds.hpp"
#include "detector_proc/ellipse_search.hpp"
#include "detector_proc/expected_mark.hpp"
#include "detector_proc/mark_fit.hpp"
#include "detector_proc/mark_meaning.hpp"
#include "detector_proc/rim_search.hpp"
#include "detector_proc/ring_search.hpp"

namespace stevedore {
namespace {

constexpr int min_chain_length = 10;

int reduction_of(cv::Size size, int working_size_px) {
  return std::max(1, std::max(size.width, size.height) / working_size_px);
}

FitFrame fit_frame(cv::Size size) {
  return {size.width / 2.0, size.height / 2.0, std::max(size.width, size.height) / 2.0};
}

EllipseEdge moved(EllipseEdge edge, cv::Point by) {
  edge.ellipse.u_px += by.x;
  edge.ellipse.v_px += by.y;
  for (int k = 0; k < edge.support.count; ++k) {
    EdgePoint& p = edge.support.samples[static_cast<std::size_t>(k)].point;
    p.u_px += static_cast<float>(by.x), p.v_px += static_cast<float>(by.y);
  }
  return edge;
}

/// Looks outwards from every edge that is not the outer one of a ring already.
void add_outer_edges(std::vector<EllipseEdge>& edges, const GradientField& field,
                     const EdgeThresholds& thresholds, const EllipseSearch& search, double min_ring_ratio) {
  const std::size_t count = edges.size();
  for (std::size_t k = 0; k < count; ++k) {
    const bool known = std::any_of(edges.begin(), edges.end(), [&](const EllipseEdge& outer) {
      return outer.ellipse.b_px > edges[k].ellipse.b_px + 2 && one_ring(edges[k], outer, min_ring_ratio);
    });
    if (known) continue;
    if (auto outer = look_outwards(edges[k], field, thresholds, search, min_ring_ratio)) {
      edges.push_back(std::move(*outer));
    }
  }
}

/// What is looked at for an expected ellipse: its box, and 0.4 semi-axes around for motion and for the ground
/// that its outer edge needs.
cv::Rect neighbourhood(const Ellipse& e, cv::Size image) {
  const double c = std::cos(e.alpha_rad), s = std::sin(e.alpha_rad);
  const double half_u = std::hypot(e.a_px * c, e.b_px * s), half_v = std::hypot(e.a_px * s, e.b_px * c);
  const double margin_px = 0.4 * e.b_px + 6;
  const auto box =
      cv::Rect(cv::Point(cvFloor(e.u_px - half_u - margin_px), cvFloor(e.v_px - half_v - margin_px)),
               cv::Point(cvCeil(e.u_px + half_u + margin_px), cvCeil(e.v_px + half_v + margin_px)));
  return box & cv::Rect({0, 0}, image);
}

bool about_the_same(const Ellipse& a, const Ellipse& b) {
  return std::hypot(a.u_px - b.u_px, a.v_px - b.v_px) < 0.3 * b.b_px && a.b_px < 1.4 * b.b_px &&
         b.b_px < 1.4 * a.b_px;
}

bool is_within(const Ellipse& inner, const Ellipse& outer) {
  return normalized_radius_squared(outer, {inner.u_px, inner.v_px}) < 1 && inner.b_px < 0.6 * outer.b_px;
}

/// The rim is nearer than the circle by the cargo's height: at a depth of focal length over the semi-major
/// axis, in circle radii, and larger by as much. Both are seen to a hundredth, and a cargo stands on paint, a
/// lid or another platform's slope: give or take a twentieth.
RimRadii rim_radii(const Ellipse& circle, const DetectorSettings& settings, double focal_px) {
  constexpr double nearest_depth = 2;  // in circle radii; 1 m
  const double nearer_at_most = nearest_depth / (nearest_depth - settings.cargo_height_ratio);
  if (focal_px <= 0) return {0.875 * settings.rim_ratio, nearer_at_most * settings.rim_ratio, false};
  const double depth = std::max(nearest_depth, focal_px / circle.a_px);
  const double radius = settings.rim_ratio * depth / (depth - settings.cargo_height_ratio);
  return {0.94 * radius, 1.06 * radius, true};
}

/// The ellipse seen best that is parallel to the circle, stands in it and has a rim's size; null: none.
Detection* rim_among(std::vector<Detection>& found, const Ellipse& circle, const RimRadii& radii) {
  constexpr double least_coverage = 0.6;  // handle and rope hide part of a rim
  constexpr double alike = 0.12;          // of aspects: perspective, and the fit of a small ellipse
  Detection* best = nullptr;
  for (Detection& d : found) {
    const Ellipse& e = d.outer.ellipse;
    const double radius = std::sqrt(e.a_px * e.b_px / (circle.a_px * circle.b_px));
    if (radius < radii.smallest || radius > radii.largest || !is_within(e, circle)) continue;
    if (std::abs(std::log(e.a_px * circle.b_px / (e.b_px * circle.a_px))) > alike) continue;
    if (d.coverage >= least_coverage && (!best || d.coverage > best->coverage)) best = &d;
  }
  return best;
}

/// A rim's other edge, a wall and a foot seen around the same place are the cargo's, which is one mark: what
/// lies there is hidden by it.
void drop_other_edges_of_cargoes(std::vector<Detection>& found) {
  constexpr double most_ratio = 1.5;  // a wall seen from the side is as high as the rim is wide
  std::vector<Ellipse> rims;
  for (const Detection& d : found)
    if (d.label == Label::cargo) rims.push_back(d.outer.ellipse);
  std::erase_if(found, [&](const Detection& d) {
    const Ellipse& e = d.outer.ellipse;
    return d.label == Label::unknown && std::any_of(rims.begin(), rims.end(), [&](const Ellipse& rim) {
             return normalized_radius_squared(rim, {e.u_px, e.v_px}) < 1 &&
                    e.a_px * e.b_px < most_ratio * most_ratio * rim.a_px * rim.b_px;
           });
  });
}

/// Circles whose rims are large enough to be told from letters are searched for one, but for those that have
/// nothing in them at all. What was taken for a rim in them, and is not, has no meaning.
template <class NothingIn>
void add_rims(const cv::Mat& image, const DetectorSettings& settings, double focal_px, NothingIn nothing_in,
              std::vector<Detection>& found) {
  constexpr double least_semi_minor_px = 15;  // a rim of 5 px
  const std::size_t count = found.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Ellipse circle = found[i].outer.ellipse;
    if (found[i].label != Label::circle || circle.b_px < least_semi_minor_px) continue;
    if (nothing_in(found[i])) {
      found[i].occupied = false;
      continue;
    }
    const RimRadii radii = rim_radii(circle, settings, focal_px);
    for (Detection& d : found)
      if (d.label == Label::cargo && is_within(d.outer.ellipse, circle)) d.label = Label::unknown;
    Detection* standing = radii.known ? rim_among(found, circle, radii) : nullptr;
    if (standing && !is_painted(image, circle, found[i].inner, standing->outer.ellipse)) {
      standing->label = Label::cargo;
      standing->occupied.reset();
      found[i].occupied = true;
      continue;
    }
    const RimSearch search = look_for_rim(image, circle, found[i].inner, radii);
    found[i].occupied = search.occupied;
    if (!search.rim) continue;
    const auto same = std::find_if(found.begin(), found.end(), [&](const Detection& d) {
      const Ellipse& e = d.outer.ellipse;
      const double radius = std::sqrt(e.a_px * e.b_px / (circle.a_px * circle.b_px));
      return about_the_same(e, search.rim->fit.ellipse) &&
             (!radii.known || (radius > radii.smallest && radius < radii.largest));
    });
    if (same != found.end()) {
      same->label = Label::cargo;
      same->occupied.reset();
      continue;
    }
    Detection rim;
    rim.outer = search.rim->fit;
    rim.coverage = search.rim->coverage;
    rim.error = search.rim->error;
    rim.kind = Kind::partial;
    rim.label = Label::cargo;
    found.push_back(std::move(rim));
  }
  drop_other_edges_of_cargoes(found);
  std::stable_sort(found.begin(), found.end(), [](const Detection& a, const Detection& b) {
    return a.outer.ellipse.a_px * a.outer.ellipse.b_px > b.outer.ellipse.a_px * b.outer.ellipse.b_px;
  });
}

/// And enough pixels to be halved.
bool has_colour(const cv::Mat& image) {
  return image.channels() == 3 && image.cols > 1 && image.rows > 1;
}

/// Of the marks that are seen well, one of each size. What stands within another mark has no siblings.
std::vector<Ellipse> shapes_of(const std::vector<MarkEdges>& marks) {
  constexpr double most_open_ratio = 0.03, alike_share = 0.06;
  std::vector<Ellipse> shapes;
  for (const MarkEdges& mark : marks) {
    const Ellipse& e = mark.outer.ellipse;
    if (mark.outer.open_px > most_open_ratio * e.b_px) continue;
    const bool inside = std::any_of(marks.begin(), marks.end(), [&](const MarkEdges& other) {
      return &other != &mark && is_within(e, other.outer.ellipse);
    });
    const bool alike = std::any_of(shapes.begin(), shapes.end(), [&](const Ellipse& s) {
      return std::abs(s.a_px / e.a_px - 1) < alike_share && std::abs(s.b_px / e.b_px - 1) < alike_share;
    });
    if (!inside && !alike) shapes.push_back(e);
  }
  return shapes;
}

}  // namespace

std::vector<EllipseEdge> ArcMethod::Plane::find_edges(const cv::Mat& image, const cv::Rect& part,
                                                      const DetectorSettings& settings) {
  window = part;
  compute_gradient(image, field);
  thresholds = edge_thresholds(field);
  linker.link(field, thresholds, min_chain_length, chains);
  const FitFrame frame = fit_frame(image.size());
  splitter.split(field, chains, frame, arcs);
  search.emplace(field, thresholds, frame, settings);
  std::vector<EllipseEdge> edges = search->search(arcs);
  add_outer_edges(edges, field, thresholds, *search, settings.min_ring_ratio);
  for (EllipseEdge& edge : edges) edge = moved(std::move(edge), part.tl());
  return edges;
}

void ArcMethod::Plane::find_directions() {
  stevedore::find_directions(field, chains, directions);
}

std::vector<EllipseEdge> ArcMethod::Plane::siblings_of(const Ellipse& shape,
                                                       const std::vector<Ellipse>& known) const {
  std::vector<Ellipse> known_here = known;
  for (Ellipse& e : known_here) e.u_px -= window.x, e.v_px -= window.y;
  std::vector<EllipseEdge> siblings =
      look_for_siblings(shape, known_here, window.size(), directions, *search);
  for (EllipseEdge& edge : siblings) edge = moved(std::move(edge), window.tl());
  return siblings;
}

cv::Rect ArcMethod::window_of(const cv::Mat& halved, cv::Size frame) {
  constexpr int min_chain = 6;  // the ends of a thin ring's edges touch at half the size
  compute_gradient(halved, halved_field_);
  halved_linker_.link(halved_field_, edge_thresholds(halved_field_), min_chain, halved_chains_);
  int left = halved.cols, right = -1, top = halved.rows, bottom = -1;
  for (const int pixel : halved_chains_.pixels) {
    const int v = pixel / halved.cols, u = pixel - v * halved.cols;
    left = std::min(left, u), right = std::max(right, u);
    top = std::min(top, v), bottom = std::max(bottom, v);
  }
  if (right < left) return {};
  // a mark's worn or hidden side may have no chain: a quarter more to each side
  constexpr int least_margin_px = 16;
  const int margin_u = std::max(least_margin_px, (right - left) / 2),
            margin_v = std::max(least_margin_px, (bottom - top) / 2);
  return cv::Rect(cv::Point(2 * left - margin_u, 2 * top - margin_v),
                  cv::Point(2 * right + 2 + margin_u, 2 * bottom + 2 + margin_v)) &
         cv::Rect({0, 0}, frame);
}

void ArcMethod::add_colour_edges(const cv::Mat& bgr, const DetectorSettings& settings,
                                 std::vector<EllipseEdge>& edges) {
  compute_halved_opponents(bgr, halved_);
  for (std::size_t k = 0; k < colour_.size(); ++k) {
    const cv::Rect window = window_of(halved_[k], bgr.size());
    colour_[k].window = window;
    if (window.empty()) continue;
    compute_opponent(bgr(window), k, opponent_);
    for (EllipseEdge& edge : colour_[k].find_edges(opponent_, window, settings)) {
      edge.weights = Opponents::weights[k];
      edges.push_back(std::move(edge));
    }
  }
}

std::vector<EllipseEdge> ArcMethod::find_edges(const cv::Mat& working, bool with_colour,
                                               const DetectorSettings& settings) {
  std::vector<EllipseEdge> edges = light_.find_edges(working, {{0, 0}, working.size()}, settings);
  if (with_colour) add_colour_edges(working, settings, edges);
  return settle_owners(std::move(edges));
}

void ArcMethod::add_siblings(const std::vector<MarkEdges>& marks, bool with_colour,
                             std::vector<EllipseEdge>& edges) {
  const std::vector<Ellipse> shapes = shapes_of(marks);
  if (shapes.empty()) return;
  std::vector<Ellipse> known;
  for (const MarkEdges& mark : marks) known.push_back(mark.outer.ellipse);
  const auto add = [&](Plane& plane, const LightWeights& weights) {
    if (plane.window.empty()) return;
    plane.find_directions();
    for (const Ellipse& shape : shapes) {
      for (EllipseEdge& edge : plane.siblings_of(shape, known)) {
        edge.weights = weights;
        edges.push_back(std::move(edge));
      }
    }
  };
  add(light_, LightWeights());
  if (!with_colour) return;
  for (std::size_t k = 0; k < colour_.size(); ++k) add(colour_[k], Opponents::weights[k]);
}

cv::Mat ArcMethod::reduced(const cv::Mat& image, int reduction) {
  const cv::Size size = image.size() / reduction;
  if (reduction == 1 || size.empty()) return image;
  // what is left over at the right and lower border makes no whole pixel
  cv::resize(image(cv::Rect({0, 0}, size * reduction)), small_, size, 0, 0, cv::INTER_AREA);
  return small_;
}

std::vector<Detection> ArcMethod::detections_of(const std::vector<MarkEdges>& marks, const cv::Mat& image,
                                                int reduction, const DetectorSettings& settings,
                                                const Optics& optics) const {
  const std::vector<MarkMeaning> meanings = find_meanings(marks, light_.field, light_.thresholds);
  const LightImage light(image, optics.light);
  std::vector<Detection> found;
  for (std::size_t k = 0; k < marks.size(); ++k) {
    Detection d = detection_of(marks[k], light, reduction, strips_of(settings));
    d.label = meanings[k].label;
    d.occupied = meanings[k].occupied;
    found.push_back(std::move(d));
  }
  return found;
}

std::vector<Detection> ArcMethod::detect(const cv::Mat& image, const DetectorSettings& settings,
                                         const Optics& optics) {
  if (image.empty()) return {};
  const int reduction = reduction_of(image.size(), settings.working_size_px);
  const cv::Mat working = reduced(image, reduction);
  const bool with_colour = has_colour(working);
  std::vector<EllipseEdge> edges = find_edges(working, with_colour, settings);
  std::vector<MarkEdges> marks = group_rings(edges, settings.min_ring_ratio);
  const std::size_t count = edges.size();
  add_siblings(marks, with_colour, edges);
  if (edges.size() > count) marks = group_rings(settle_owners(std::move(edges)), settings.min_ring_ratio);
  std::vector<Detection> found = detections_of(marks, image, reduction, settings, optics);
  const auto nothing_in = [&](const Detection& circle) {
    const Ellipse e = lessened(circle.inner ? circle.inner->ellipse : circle.outer.ellipse, reduction);
    constexpr double least_in_view = 0.75;
    return nothing_inside(e, light_.field, least_in_view) &&
           (!with_colour || std::all_of(colour_.begin(), colour_.end(), [&](const Plane& plane) {
             Ellipse here = e;
             here.u_px -= plane.window.x, here.v_px -= plane.window.y;
             return plane.window.empty() || nothing_inside(here, plane.field, 0);
           }));
  };
  add_rims(image, settings, optics.focal_px_of(image), nothing_in, found);
  return found;
}

std::optional<Detection> ArcMethod::nearest_in(const cv::Mat& image, const cv::Rect& region,
                                               const Detection& expected, Colour colour,
                                               const DetectorSettings& settings, const Optics& optics) {
  const int reduction = reduction_for(expected);
  const cv::Mat working = reduced(image(region), reduction);
  std::vector<EllipseEdge> edges =
      find_edges(working, colour == Colour::used && has_colour(working), settings);
  std::optional<Detection> nearest;
  double least = most_mismatch;
  for (Detection& d : detections_of(group_rings(std::move(edges), settings.min_ring_ratio), image(region),
                                    reduction, settings, optics)) {
    for (EllipseFit* fit : {&d.outer, d.inner ? &*d.inner : nullptr}) {
      if (!fit) continue;
      fit->ellipse.u_px += region.x;
      fit->ellipse.v_px += region.y;
    }
    const double m = mismatch(d.outer.ellipse, expected.outer.ellipse);
    if (m < least) least = m, nearest = std::move(d);
  }
  return nearest;
}

std::optional<Detection> ArcMethod::detect_near(const cv::Mat& image, const Detection& expected,
                                                const DetectorSettings& settings, const Optics& optics) {
  const cv::Rect region = neighbourhood(expected.outer.ellipse, image.size());
  if (region.width < 16 || region.height < 16) return std::nullopt;
  auto nearest = nearest_in(image, region, expected, Colour::unused, settings, optics);
  if (!nearest && image.channels() == 3)
    nearest = nearest_in(image, region, expected, Colour::used, settings, optics);
  return nearest;
}

}  // namespace stevedore
