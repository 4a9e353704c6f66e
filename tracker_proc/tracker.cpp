#include "tracker_proc/tracker.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

namespace stevedore {
namespace {

// Farther out nothing is in any image, and fixed-point drawing would overflow.
constexpr double kLargestCoordinatePx = 20000;

// A click or a position some frames old: within two semi-axes, as the offline command promises.
constexpr double kTakeUpSemiAxes = 2.0;

bool is_usable(const Ellipse& e) {
  return is_valid(e) && std::abs(e.u_px) < kLargestCoordinatePx && std::abs(e.v_px) < kLargestCoordinatePx &&
         e.a_px < kLargestCoordinatePx;
}

Eigen::Vector2d centre_of(const Ellipse& e) {
  return {e.u_px, e.v_px};
}

void move_by(Ellipse& e, const Eigen::Vector2d& shift_px) {
  e.u_px += shift_px.x();
  e.v_px += shift_px.y();
}

void move_by(Detection& d, const Eigen::Vector2d& shift_px) {
  move_by(d.outer.ellipse, shift_px);
  if (d.inner) move_by(d.inner->ellipse, shift_px);
}

constexpr const char* kAtWindow = "the CAMShift window";
constexpr const char* kByMotion = "the place its motion leads to";

std::string number(double value, int decimals = 0) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

/// The ellipses that can be followed, and where they stand in the list of detections.
struct Found {
  std::vector<Ellipse> ellipses;
  std::vector<int> index;
};

Found usable(const std::vector<Detection>& detections) {
  Found found;
  for (std::size_t i = 0; i < detections.size(); ++i) {
    const Ellipse e = normalized(detections[i].outer.ellipse);
    if (!is_usable(e)) continue;
    found.ellipses.push_back(e);
    found.index.push_back(static_cast<int>(i));
  }
  return found;
}

/// Step 5 in words: how the ellipse nearest to `around` fails to be the target, or that somebody else has it.
std::string why_not(const Expected& around, const std::string& place, const std::vector<Ellipse>& ellipses,
                    const AssociationGates& gates) {
  if (ellipses.empty()) return "no ellipse in this frame";
  const Eigen::Vector2d centre = centre_of(around.ellipse);
  const auto distance = [&](const Ellipse& e) { return (centre_of(e) - centre).norm(); };
  const Ellipse& nearest = *std::min_element(ellipses.begin(), ellipses.end(),
                                             [&](auto& x, auto& y) { return distance(x) < distance(y); });
  const double gate = gate_px(around, centre_of(nearest), gates);
  if (distance(nearest) > gate)
    return "nearest ellipse to " + place + " is " + number(distance(nearest)) + " px away, gate " +
           number(gate) + " px";
  if (!may_be(around, nearest, gates)) {
    const double ratio = std::sqrt(nearest.a_px * nearest.b_px / (around.ellipse.a_px * around.ellipse.b_px));
    return "nearest ellipse to " + place + " is " + number(ratio, 2) + " times as large as the target";
  }
  return "nearest ellipse to " + place + " is another one that is followed";
}

}  // namespace

/// Where the target is looked for among this frame's ellipses: where its motion leads to and, if CAMShift's
/// window is usable, there.
struct Tracker::TargetSearch {
  std::optional<Ellipse> window;
  Expected by_motion;
  std::optional<Expected> by_window;
  std::string fault;    ///< why the window is of no use; empty: it is, or there was no search
  std::string failure;  ///< why no ellipse is the target, should none be

  /// How the ellipse that is the target was found, in words.
  [[nodiscard]] std::string found_by(const Ellipse& ellipse) const {
    const auto away = [&](const Expected& e) { return (centre_of(ellipse) - centre_of(e.ellipse)).norm(); };
    if (by_window && away(*by_window) <= away(by_motion))
      return number(away(*by_window)) + " px from " + kAtWindow;
    const std::string why = by_window ? number(away(*by_window)) + " px from " + kAtWindow : fault;
    return number(away(by_motion)) + " px from " + kByMotion + "; " + why;
  }
};

Tracker::Tracker(const TrackerSettings& settings, std::int64_t first_id)
    : settings_(settings), next_id_(first_id), appearance_(settings.histogram_weight) {}

void Tracker::follow_id(std::int64_t id, std::optional<Eigen::Vector2d> last_seen_px) {
  follow(Wish::id, id, last_seen_px);
}

void Tracker::follow_pixel(const Eigen::Vector2d& pixel) {
  follow(Wish::pixel, 0, pixel);
}

void Tracker::follow_first_circle() {
  follow(Wish::first_circle, 0, std::nullopt);
}

void Tracker::release() {
  wish_ = Wish::nothing;
  wished_pixel_.reset();
  target_id_.reset();
  appearance_.forget();
}

void Tracker::follow(Wish wish, std::int64_t id, std::optional<Eigen::Vector2d> pixel) {
  const bool same = wish == wish_ && (wish == Wish::id ? id == wished_id_ : pixel == wished_pixel_);
  wish_ = wish;
  wished_id_ = id;
  wished_pixel_ = pixel;  // the newest place of a wished id, too
  if (same || (wish == Wish::id && target_id_ == id)) return;
  target_id_.reset();
  appearance_.forget();
}

TrackerResult Tracker::step(double time_s, const cv::Mat& image, const std::vector<Detection>& detections) {
  const double dt_s = advance_clock(time_s);
  predict(dt_s);
  TrackerResult result;
  result.tracks = forget_unseen();
  const auto search = search_target(image, detections);
  continue_tracks(search, detections, dt_s);
  if (!target_id_) take_up_target();
  if (const Track* target = find(target_id_); target && target->detection_index >= 0)
    appearance_.learn(image, target->detection.outer.ellipse);
  for (const Followed& followed : followed_) result.tracks.push_back(followed.track);
  std::sort(result.tracks.begin(), result.tracks.end(), [](auto& x, auto& y) { return x.id < y.id; });
  result.target = target_state(search);
  return result;
}

double Tracker::advance_clock(double time_s) {
  assert(std::isfinite(time_s));
  const double dt_s = time_s_ ? time_s - *time_s_ : 0;
  time_s_ = time_s;
  if (dt_s >= 0) return dt_s;
  for (Followed& followed : followed_) {
    followed.track.velocity_pxps.setZero();
    followed.has_velocity = false;
  }
  return 0;
}

void Tracker::predict(double dt_s) {
  for (auto& [track, has_velocity] : followed_) {
    move_by(track.detection, track.velocity_pxps * dt_s);
    track.detection_index = -1;
    track.unseen_s += dt_s;
    track.age_frames += 1;
    track.status = TrackStatus::predicted;
  }
}

/// Drops the tracks that were not seen for too long and returns them.
std::vector<Track> Tracker::forget_unseen() {
  constexpr double kRounding_s = 1e-6;  // sums of frame times
  std::vector<Track> lost;
  std::erase_if(followed_, [&](Followed& followed) {
    if (followed.track.unseen_s <= settings_.memory_s + kRounding_s) return false;
    followed.track.status = TrackStatus::lost;
    lost.push_back(followed.track);
    return true;
  });
  return lost;
}

/// Algorithm 2 up to its step 5, which is the association.
std::optional<Tracker::TargetSearch> Tracker::search_target(const cv::Mat& image,
                                                            const std::vector<Detection>& detections) const {
  const Track* target = find(target_id_);
  if (!target) return std::nullopt;
  TargetSearch search;
  search.by_motion.ellipse = target->detection.outer.ellipse;
  search.by_motion.unseen_s = target->unseen_s;
  auto [window, fault] = appearance_.find(image, search.by_motion.ellipse);
  search.window = window;
  search.fault = fault;
  if (fault.empty()) {
    search.by_window = search.by_motion;
    move_by(search.by_window->ellipse, centre_of(*window) - centre_of(search.by_motion.ellipse));
  }
  const std::vector<Ellipse> ellipses = usable(detections).ellipses;
  search.failure = fault.empty() ? why_not(*search.by_window, kAtWindow, ellipses, gates())
                                 : why_not(search.by_motion, kByMotion, ellipses, gates()) + "; " + fault;
  return search;
}

void Tracker::measure(Followed& followed, const Detection& detection, int index, double dt_s) const {
  auto& [track, has_velocity] = followed;
  const Eigen::Vector2d surprise =
      centre_of(detection.outer.ellipse) - centre_of(track.detection.outer.ellipse);
  if (dt_s > 0) {
    // The first velocity is taken as it is, later ones with the gain of a first-order low pass.
    const double gain = has_velocity ? 1 - std::exp(-track.unseen_s / settings_.velocity_time_s) : 1;
    track.velocity_pxps += gain * surprise / track.unseen_s;
    has_velocity = true;
  }
  track.detection = detection;
  track.detection.outer.ellipse = normalized(detection.outer.ellipse);
  track.detection_index = index;
  track.unseen_s = 0;
  track.status = TrackStatus::tracking;
}

/// Each track gets at most one ellipse and the rest become new tracks.
void Tracker::continue_tracks(const std::optional<TargetSearch>& search,
                              const std::vector<Detection>& detections, double dt_s) {
  std::vector<Expected> expected;
  for (std::size_t i = 0; i < followed_.size(); ++i) {
    const Track& track = followed_[i].track;
    expected.push_back({i, track.detection.outer.ellipse, track.unseen_s});
    if (search && search->by_window && track.id == target_id_)
      expected.push_back({i, search->by_window->ellipse, track.unseen_s});
  }
  const Found found = usable(detections);
  const auto match = associate(followed_.size(), expected, found.ellipses, gates());

  std::vector<bool> taken(found.index.size(), false);
  for (std::size_t i = 0; i < match.size(); ++i) {
    if (!match[i]) continue;
    const int index = found.index[*match[i]];
    measure(followed_[i], detections[static_cast<std::size_t>(index)], index, dt_s);
    taken[*match[i]] = true;
  }
  for (std::size_t k = 0; k < taken.size(); ++k) {
    if (taken[k]) continue;
    Followed& added = followed_.emplace_back();
    added.track.id = next_id_++;
    measure(added, detections[static_cast<std::size_t>(found.index[k])], found.index[k], 0);
  }
}

void Tracker::take_up_target() {
  const Track* taken = nullptr;
  if (wish_ == Wish::id) taken = find(wished_id_);
  if (!taken && wished_pixel_) taken = nearest_to(*wished_pixel_);
  if (wish_ == Wish::first_circle) taken = first_circle();
  if (taken) target_id_ = taken->id;
}

const Track* Tracker::find(std::optional<std::int64_t> id) const {
  const auto found = std::find_if(followed_.begin(), followed_.end(),
                                  [&](const Followed& followed) { return followed.track.id == id; });
  return found == followed_.end() ? nullptr : &found->track;
}

/// Of the ellipses of this frame within two semi-axes of a pixel the one that has it farthest inside.
const Track* Tracker::nearest_to(const Eigen::Vector2d& pixel) const {
  const Track* best = nullptr;
  double least = std::numeric_limits<double>::infinity();
  for (const auto& [track, has_velocity] : followed_) {
    const Ellipse& e = track.detection.outer.ellipse;
    if (track.detection_index < 0 || !((pixel - centre_of(e)).norm() <= kTakeUpSemiAxes * e.a_px)) continue;
    const double radius_squared = normalized_radius_squared(e, pixel);
    if (radius_squared < least) best = &track, least = radius_squared;
  }
  return best;
}

const Track* Tracker::first_circle() const {
  const Track* first = nullptr;
  for (const auto& [track, has_velocity] : followed_)
    if (track.detection_index >= 0 && track.detection.label == Label::circle &&
        (!first || track.detection_index < first->detection_index))
      first = &track;
  return first;
}

std::string Tracker::searching_reason() const {
  switch (wish_) {
    case Wish::nothing:
      return "no target is wanted";
    case Wish::first_circle:
      return "no circle in this frame";
    case Wish::id:
      if (!wished_pixel_) return "track " + std::to_string(wished_id_) + " is not known";
      [[fallthrough]];
    case Wish::pixel:
      return "no ellipse within two semi-axes of (" + number(wished_pixel_->x()) + ", " +
             number(wished_pixel_->y()) + ")";
  }
  return {};
}

Target Tracker::target_state(const std::optional<TargetSearch>& search) const {
  Target target;
  target.id = target_id_;
  if (search) target.window = search->window;
  const Track* track = find(target_id_);
  if (!target_id_) {
    target.reason = searching_reason();
  } else if (!track) {
    target.status = TrackStatus::lost;
    target.reason = "not seen for " + number(settings_.memory_s, 1) + " s";
  } else if (track->detection_index < 0) {
    target.status = TrackStatus::predicted;
    target.reason = search ? search->failure : "not seen in this frame";
  } else {
    target.status = TrackStatus::tracking;
    target.reason = search ? search->found_by(track->detection.outer.ellipse) : "taken up in this frame";
  }
  return target;
}

AssociationGates Tracker::gates() const {
  AssociationGates gates;
  gates.radii = settings_.gate_radii;
  gates.size_ratio = settings_.size_ratio_gate;
  return gates;
}

}  // namespace stevedore
