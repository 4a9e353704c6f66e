#include "tracker_proc/tracker.hpp"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <utility>

#include "tracker_proc/assignment.hpp"

namespace stevedore {
namespace {

using Match = std::vector<std::optional<std::size_t>>;

// A click or a position some frames old: within two semi-axes, as the offline command promises.
constexpr double kTakeUpSemiAxes = 2.0;

// Until something else is told: the paper's camera, 640 x 480 with 87 degrees.
const cv::Size kUsualFrame(640, 480);
constexpr double kUsualFocalPerWidth = 0.527;

// Velocity of a mark that has just been taken up, besides that of all: 1 m/s for a circle of 0.2 m.
constexpr double kFirstVelocity_radiips = 5.0;
// And of the camera when the first frame comes: it hovers, more or less.
constexpr double kFirstTurn_radps = 0.5;

// A mark seen this often is there: the detector's false ellipses last for one or two frames. What was seen
// less is not waited for long.
constexpr int kTimesSeenToBelieve = 3;
constexpr double kDoubtfulMemory_s = 0.2;

// Chance of finding a mark in plain view; and one that was hidden in the frame before (what hid it then may
// hide it still) or is doubtful.
constexpr double kFound = 0.95, kFoundPerhaps = 0.5;
// A mark that was to be found and was not is hidden; one that was not to be found is so no longer.
constexpr double kHidden = 0.9, kNotHidden = 0.1;

// While it can't be told which of several marks an ellipse is, it is none of them; and nothing new for some
// frames: soon more of the marks are in view.
constexpr double kPatience_s = 0.3;

// With the attitude told, what is left of the camera's unrest is translation: 1 m/s^2 at 3 m.
constexpr double kUnrestLeft = 0.3;

// Some frames: as fast as the velocity of a mark follows.
constexpr double kPictureMemory_s = 0.1;

// CAMShift's window of a half covered mark is centred on what remains: up to half a radius off, two sigma.
constexpr double kWindowSigma_radii = 0.25;
// An ellipse farther from it than half a radius and some noise is not what CAMShift sees.
constexpr double kAtWindow_radii = 0.6;

// A target that is not where it was expected has moved to an ellipse whose surroundings correlate at least so
// much with the target's own (the rest: size and form a tenth off, what it drives past) ...
constexpr double kLeastCorrelation = 0.6;
// ... and more than those of its old place (else it is only covered) and of any other candidate by this much.
constexpr double kCorrelationLead = 0.15;
// Its likeness may suffer by what the size may change between two pictures that far apart.
constexpr double kJumpSize = 0.15;
constexpr double kLeastJumpLikeness = -6;  // 3.5 sigma

// A surprise of this many variances (99.9 % of chi-squared with two degrees of freedom) is no noise: a jerk,
// or a false ellipse upon the mark. Beyond two radii the two do not overlap: it is somewhere else now.
constexpr double kLargestSurprise = 13.8;
constexpr double kFarthestJerk_radii = 2.0;

// Edges of one cargo: two cargoes side by side are two radii apart. A foot, a fifth smaller than the rim and
// farther away by the cargo's height (a fifth from 1.5 m), is the smallest.
constexpr double kOneCargo_radii = 0.8;
constexpr double kOneCargo_size = 1.5;

Eigen::Vector2d centre_of(const Ellipse& e) {
  return {e.u_px, e.v_px};
}

constexpr const char* kAtWindow = "the CAMShift window";
constexpr const char* kByMotion = "the place its motion leads to";

std::string number(double value, int decimals = 0) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*f", decimals, value);
  return text;
}

double radius_of(const Ellipse& e) {
  return std::sqrt(e.a_px * e.b_px);
}

/// Rim, its inner edge, wall and foot of a cargo, found by turns, are one mark.
bool is_one_cargo(const Detection& one, const Detection& other) {
  if (one.label == Label::circle || other.label == Label::circle) return false;
  if (one.label == Label::unknown && other.label == Label::unknown) return false;
  const double p = radius_of(one.outer.ellipse), q = radius_of(other.outer.ellipse);
  const double apart_px = (centre_of(one.outer.ellipse) - centre_of(other.outer.ellipse)).norm();
  return apart_px < kOneCargo_radii * std::min(p, q) && std::max(p, q) < kOneCargo_size * std::min(p, q);
}

Ellipse with_size(const Ellipse& e, const Eigen::Vector2d& centre_px, double radius_px) {
  const double k = radius_px / radius_of(e);
  return {centre_px.x(), centre_px.y(), k * e.a_px, k * e.b_px, e.alpha_rad};
}

/// The detection moved to where and how large it is expected; the inner edge goes along.
void move_to(Detection& d, const MarkMotion& motion) {
  const Ellipse before = d.outer.ellipse;
  d.outer.ellipse = with_size(before, motion.centre_px(), motion.radius_px());
  if (!d.inner) return;
  const double k = motion.radius_px() / radius_of(before);
  Ellipse& inner = d.inner->ellipse;
  inner =
      with_size(inner, motion.centre_px() + k * (centre_of(inner) - centre_of(before)), k * radius_of(inner));
}

/// Image of an ellipse under a homography; nothing where it is none any more.
std::optional<Ellipse> image_of(const Ellipse& e, const Eigen::Matrix3d& homography) {
  const Eigen::Matrix3d back = homography.inverse();
  return ellipse_from_conic(back.transpose() * conic_from_ellipse(e) * back);
}

Eigen::Matrix2d jacobian_at(const Eigen::Matrix3d& h, const Eigen::Vector2d& p) {
  const Eigen::Vector3d q = h * p.homogeneous();
  return (h.topLeftCorner<2, 2>() - q.hnormalized() * h.bottomLeftCorner<1, 2>()) / q.z();
}

/// Three sigma of where it may be, and at least the radius that a jerk may take it.
double reach_px(const Expected& around) {
  return std::max(radius_of(around.ellipse), 3 * std::sqrt(around.centre_covariance_px2.trace() / 2));
}

}  // namespace

/// What one step works on: the ellipses that can be followed, and where they stand in the list of detections.
struct Tracker::Frame {
  Frame(double step_s, const cv::Mat& picture, const std::vector<Detection>& all)
      : dt_s(step_s), image(picture), detections(all) {
    for (std::size_t i = 0; i < all.size(); ++i) {
      const auto ellipse = found_in(all[i]);
      if (!ellipse) continue;
      found.push_back(*ellipse);
      index.push_back(static_cast<int>(i));
    }
  }

  [[nodiscard]] bool is_ambiguous(std::size_t k) const { return k < ambiguous.size() && ambiguous[k]; }

  double dt_s;
  const cv::Mat& image;
  const std::vector<Detection>& detections;
  std::vector<Found> found;
  std::vector<int> index;
  std::vector<bool> ambiguous;  ///< of found: could be one mark as well as another; empty: none
};

/// Where the target is looked for among this frame's ellipses: where its motion leads to and, if CAMShift's
/// window is usable, there.
struct Tracker::TargetSearch {
  std::optional<Ellipse> window;
  Expected by_motion;
  std::optional<Expected> by_window;
  std::string fault;    ///< why the window is of no use; empty: it is, or there was no search
  std::string failure;  ///< why no ellipse is the target, should none be
  bool moved = false;   ///< it was found elsewhere, by its surroundings

  /// How the ellipse that is the target was found, in words.
  [[nodiscard]] std::string found_by(const Ellipse& ellipse) const {
    const auto away = [&](const Expected& e) { return (centre_of(ellipse) - centre_of(e.ellipse)).norm(); };
    if (moved) return "moved by " + number(away(by_motion)) + " px, known by what lies around it";
    if (by_window && away(*by_window) <= away(by_motion))
      return number(away(*by_window)) + " px from " + kAtWindow;
    const std::string why = by_window ? number(away(*by_window)) + " px from " + kAtWindow : fault;
    return number(away(by_motion)) + " px from " + kByMotion + "; " + why;
  }

  /// An ellipse in plain view has the window upon it; one that lies half between two has neither.
  [[nodiscard]] bool is_at_window(const Ellipse& ellipse) const {
    const Ellipse& w = by_window->ellipse;
    return (centre_of(ellipse) - centre_of(w)).norm() < kAtWindow_radii * radius_of(w);
  }

  /// Step 5 in words: how the ellipse nearest to where it is looked for fails to be the target, or that
  /// somebody else has it.
  [[nodiscard]] std::string why_not(const std::vector<Found>& all) const {
    const Expected& around = by_window ? *by_window : by_motion;
    const std::string place = by_window ? kAtWindow : kByMotion;
    if (all.empty()) return "no ellipse in this frame";
    const auto distance = [&](const Found& f) {
      return (centre_of(f.ellipse) - centre_of(around.ellipse)).norm();
    };
    const Found& nearest = *std::min_element(all.begin(), all.end(),
                                             [&](auto& x, auto& y) { return distance(x) < distance(y); });
    if (distance(nearest) > reach_px(around))
      return "nearest ellipse to " + place + " is " + number(distance(nearest)) + " px away, reach " +
             number(reach_px(around)) + " px";
    const double ratio = radius_of(nearest.ellipse) / radius_of(around.ellipse);
    if (std::abs(std::log(ratio)) > 3 * std::sqrt(around.log_radius_variance))
      return "nearest ellipse to " + place + " is " + number(ratio, 2) + " times as large as the target";
    return "nearest ellipse to " + place + " is more likely another one";
  }
};

Tracker::Tracker(const TrackerSettings& settings)
    : settings_(settings),
      frame_size_(kUsualFrame),
      focal_px_(kUsualFocalPerWidth * kUsualFrame.width),
      common_(kFirstTurn_radps * focal_px_),
      appearance_(settings.histogram_weight) {}

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
  surroundings_.forget();
}

void Tracker::follow(Wish wish, std::int64_t id, std::optional<Eigen::Vector2d> pixel) {
  const bool same = wish == wish_ && (wish == Wish::id ? id == wished_id_ : pixel == wished_pixel_);
  wish_ = wish;
  wished_id_ = id;
  wished_pixel_ = pixel;  // the newest place of a wished id, too
  if (same || (wish == Wish::id && target_id_ == id)) return;
  target_id_.reset();
  appearance_.forget();
  surroundings_.forget();
}

TrackerResult Tracker::step(double time_s, const cv::Mat& image, const std::vector<Detection>& detections,
                            const FrameView& view) {
  Frame frame(advance_clock(time_s), image, detections);
  look_at(view, image);
  predict(frame.dt_s, view);
  TrackerResult result;
  result.tracks = forget_unseen();
  shift_together(frame, view);
  auto search = search_target(frame);
  Match match = this->match(frame, search);
  if (search && !match[*target_place()]) {
    if (const auto found = moved_target(frame, match)) {
      match[*target_place()] = found;
      search->moved = true;
    }
  }
  continue_tracks(frame, match);
  join_edges_of_cargoes();
  if (frame.ambiguous.empty()) note_hidden();
  if (search) use_window(*search);
  describe_tracks();
  if (!target_id_) take_up_target();
  if (const Track* target = find(target_id_); target && target->detection_index >= 0) {
    appearance_.learn(image, target->detection.outer.ellipse);
    surroundings_.learn(image, target->detection.outer.ellipse);
  }
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
    followed.motion.forget_velocity(kFirstVelocity_radiips * followed.motion.radius_px());
    followed.since_s = std::min(followed.since_s, time_s);
    followed.seen_s = std::min(followed.seen_s, time_s);
  }
  sure_s_ = std::min(sure_s_, time_s);
  common_ = CommonMotion(kFirstTurn_radps * focal_px_);
  picture_pxps_.reset();
  return 0;
}

void Tracker::look_at(const FrameView& view, const cv::Mat& image) {
  const cv::Size size = view.size.empty() ? image.size() : view.size;
  if (!size.empty()) frame_size_ = size;
  focal_px_ = view.focal_px > 0 ? view.focal_px : kUsualFocalPerWidth * frame_size_.width;
}

void Tracker::predict(double dt_s, const FrameView& view) {
  const Unrest unrest{settings_.mark_unrest_radiips, settings_.size_unrest_ps};
  for (Followed& followed : followed_) {
    Track& track = followed.track;
    MarkMotion& motion = followed.motion;
    motion.predict(dt_s, unrest);
    followed.unseen_frames += 1;
    followed.turn_pxps.setZero();
    if (view.turn) {
      const Eigen::Vector2d before = motion.centre_px();
      const Eigen::Vector3d after = *view.turn * before.homogeneous();
      const auto turned = image_of(track.detection.outer.ellipse, *view.turn);
      if (after.z() > 0 && turned) {  // else it is behind the camera now
        motion.carry(after.hnormalized(), jacobian_at(*view.turn, before));
        track.detection.outer.ellipse = *turned;
        if (dt_s > 0) followed.turn_pxps = (motion.centre_px() - before) / dt_s;
      }
    }
    move_to(track.detection, motion);
    track.detection_index = -1;
    track.unseen_s += dt_s;
    track.age_frames += 1;
    track.status = TrackStatus::predicted;
  }
  // a motion in common tells a mark that is yet to come nothing
  if (followed_.empty()) common_ = CommonMotion(kFirstTurn_radps * focal_px_);
  common_.predict(dt_s, settings_.camera_unrest_radps * focal_px_ * (view.turn ? kUnrestLeft : 1));
  if (view.turn) {  // no picture is looked at: the last one is of long before when the attitude falls silent
    picture_ = PictureMotion();
    picture_pxps_.reset();
  }
}

double Tracker::memory_s(const Followed& followed) const {
  if (followed.given_up) return -1;
  const bool doubtful = followed.times_seen < kTimesSeenToBelieve && followed.track.id != target_id_;
  return doubtful ? std::min(kDoubtfulMemory_s, settings_.memory_s) : settings_.memory_s;
}

/// Drops the tracks that were not seen for too long and returns them.
std::vector<Track> Tracker::forget_unseen() {
  constexpr double kRounding_s = 1e-6;  // sums of frame times
  std::vector<Track> lost;
  std::erase_if(followed_, [&](Followed& followed) {
    if (followed.track.unseen_s <= memory_s(followed) + kRounding_s) return false;
    followed.track.status = TrackStatus::lost;
    lost.push_back(followed.track);
    return true;
  });
  return lost;
}

Expected Tracker::expected_of(const Followed& followed) const {
  const Track& track = followed.track;
  Expected e;
  e.ellipse = track.detection.outer.ellipse;
  e.centre_covariance_px2 = followed.motion.centre_covariance_px2();
  e.log_radius_variance = followed.motion.log_radius_variance();
  e.is_doubtful = followed.times_seen < kTimesSeenToBelieve;
  e.found_in_view = e.is_doubtful || followed.hidden ? kFoundPerhaps : kFound;
  e.unseen_s = track.unseen_s;
  e.label = track.detection.label;
  e.inner_edge = inner_edge_of(track.detection);
  return e;
}

std::vector<Expected> Tracker::all_expected() const {
  std::vector<Expected> all;
  for (const Followed& followed : followed_) all.push_back(expected_of(followed));
  return all;
}

void Tracker::shift_together(Frame& frame, const FrameView& view) {
  CommonShift shift = common_.find(all_expected(), frame.found, frame_size_, frame.dt_s);
  if (shift.ambiguous.empty()) sure_s_ = *time_s_;
  frame.ambiguous = shift.ambiguous;
  const auto seen = view.turn ? std::nullopt : picture_.shift_to(frame.image);
  if (seen && frame.dt_s > 0) {
    const Eigen::Vector2d seen_pxps = seen->shift_px / frame.dt_s;
    if (picture_pxps_) {
      const Eigen::Vector2d surprise = seen->shift_px - *picture_pxps_ * frame.dt_s - shift.shift_px;
      const CommonShift rest = common_.observe(surprise, seen->variance_px2);
      shift.shift_px += rest.shift_px;
      shift.faster_by_pxps += rest.faster_by_pxps;
    }
    if (!picture_pxps_)
      picture_pxps_ = seen_pxps;
    else if (shift.marks > 0)
      *picture_pxps_ += (1 - std::exp(-frame.dt_s / kPictureMemory_s)) * (seen_pxps - *picture_pxps_);
    else
      *picture_pxps_ += shift.faster_by_pxps;
  }
  for (Followed& followed : followed_) {
    // the velocity of all is told by marks that have their own unrest: for one that is not seen it adds to
    // its own
    const double walk_pxps = settings_.mark_unrest_radiips * followed.motion.radius_px();
    const bool is_told = shift.marks > 0 && followed.unseen_frames > 1;
    const double variance = is_told ? walk_pxps * walk_pxps / static_cast<double>(shift.marks) : 0;
    followed.motion.shift(shift.shift_px, shift.faster_by_pxps, white_acceleration(frame.dt_s, variance));
    move_to(followed.track.detection, followed.motion);
  }
}

/// Algorithm 2 up to its step 5, which is the association.
std::optional<Tracker::TargetSearch> Tracker::search_target(const Frame& frame) const {
  const auto place = target_place();
  if (!place) return std::nullopt;
  TargetSearch search;
  search.by_motion = expected_of(followed_[*place]);
  const Ellipse& expected = search.by_motion.ellipse;
  auto [window, fault] = appearance_.find(frame.image, expected);
  search.window = window;
  search.fault = fault;
  if (fault.empty()) {
    const double sigma = kWindowSigma_radii * radius_of(expected);
    search.by_window = search.by_motion;
    search.by_window->ellipse = with_size(expected, centre_of(*window), radius_of(expected));
    search.by_window->centre_covariance_px2 = sigma * sigma * Eigen::Matrix2d::Identity();
  }
  search.failure = search.why_not(frame.found) + (search.fault.empty() ? "" : "; " + search.fault);
  return search;
}

Match Tracker::match(const Frame& frame, const std::optional<TargetSearch>& search) const {
  std::vector<Expected> expected = all_expected();
  for (Expected& e : expected)
    e.centre_covariance_px2 += common_.variance_px2() * Eigen::Matrix2d::Identity();
  Eigen::MatrixXd costs = association_costs(expected, frame.found, frame_size_);
  if (search && search->by_window) {
    const auto row = static_cast<Eigen::Index>(*target_place());
    const Eigen::MatrixXd by_window = association_costs({*search->by_window}, frame.found, frame_size_);
    for (std::size_t k = 0; k < frame.found.size(); ++k) {
      const auto column = static_cast<Eigen::Index>(k);
      if (search->is_at_window(frame.found[k].ellipse))
        costs(row, column) = std::min(costs(row, column), by_window(0, column));
    }
  }
  for (std::size_t k = 0; k < frame.found.size(); ++k)
    if (frame.is_ambiguous(k)) costs.col(static_cast<Eigen::Index>(k)).setZero();
  return assign(costs);
}

/// The target is not where it was expected, nor near. If one ellipse, new since then, lies in the same
/// surroundings as the target did, and they are no longer in the old place, then both have moved. A track
/// that took this ellipse up meanwhile is given up for it.
std::optional<std::size_t> Tracker::moved_target(const Frame& frame, Match& match) {
  const std::size_t place = *target_place();
  Expected expected = expected_of(followed_[place]);
  expected.log_radius_variance += kJumpSize * kJumpSize;
  std::vector<std::optional<std::size_t>> owner(frame.found.size());
  for (std::size_t i = 0; i < match.size(); ++i)
    if (match[i]) owner[*match[i]] = i;

  double best = kLeastCorrelation, second = -1;
  std::optional<std::size_t> moved;
  for (std::size_t k = 0; k < frame.found.size(); ++k) {
    const bool is_new = !owner[k] || followed_[*owner[k]].since_s >= followed_[place].seen_s;
    if (!is_new || frame.is_ambiguous(k) || log_likeness(expected, frame.found[k]) < kLeastJumpLikeness)
      continue;
    const auto here = surroundings_.correlation(frame.image, frame.found[k].ellipse);
    if (!here) continue;
    if (*here > best) {
      second = moved ? best : second;
      best = *here;
      moved = k;
    } else {
      second = std::max(second, *here);
    }
  }
  const double old_place = surroundings_.correlation(frame.image, expected.ellipse).value_or(-1);
  if (!moved || best < std::max(second, old_place) + kCorrelationLead) return std::nullopt;
  if (owner[*moved]) {
    match[*owner[*moved]].reset();
    followed_[*owner[*moved]].given_up = true;
  }
  return moved;
}

/// Each track gets the ellipse it is matched with and the rest become new tracks.
void Tracker::continue_tracks(const Frame& frame, const Match& match) {
  std::vector<bool> taken(frame.found.size(), false);
  for (std::size_t i = 0; i < match.size(); ++i) {
    if (!match[i]) continue;
    taken[*match[i]] = true;
    continue_track(followed_[i], frame, *match[i]);
  }
  const Eigen::Vector2d velocity_pxps = mean_velocity_pxps();
  const bool patient = *time_s_ - sure_s_ <= kPatience_s;
  for (std::size_t k = 0; k < taken.size(); ++k)
    if (!taken[k] && !(patient && frame.is_ambiguous(k))) take_up(frame, k, velocity_pxps);
}

void Tracker::continue_track(Followed& followed, const Frame& frame, std::size_t found) {
  const MarkMeasurement& measured = frame.found[found].measurement;
  MarkMotion& motion = followed.motion;
  const Eigen::Vector2d surprise = measured.centre_px - motion.centre_px();
  const Eigen::Matrix2d covariance = motion.centre_covariance_px2() + measured.centre_covariance_px2;
  if (surprise.dot(covariance.inverse() * surprise) < kLargestSurprise)
    motion.update(measured);
  else if (surprise.norm() < kFarthestJerk_radii * motion.radius_px())
    motion.update_jerked(measured, surprise.norm());
  else
    motion.restart(measured, kFirstVelocity_radiips * motion.radius_px());
  followed.times_seen += 1;
  followed.unseen_frames = 0;
  followed.hidden = false;
  followed.seen_s = *time_s_;
  set_measured(followed.track, frame, found);
}

/// Of two tracks that are one cargo the one seen in this frame goes on, under the older id or the target's.
void Tracker::join_edges_of_cargoes() {
  const auto is_seen = [](const Followed& f) { return f.track.detection_index >= 0; };
  for (std::size_t i = 0; i < followed_.size(); ++i) {
    for (std::size_t j = i + 1; j < followed_.size() && !followed_[i].given_up; ++j) {
      Followed *kept = &followed_[i], *dropped = &followed_[j];
      if (dropped->given_up || is_seen(*kept) == is_seen(*dropped) ||
          !is_one_cargo(kept->track.detection, dropped->track.detection))
        continue;
      if (dropped->track.id == target_id_) std::swap(kept, dropped);
      if (is_seen(*dropped)) {
        std::swap(*kept, *dropped);
        std::swap(kept->track.id, dropped->track.id);
        std::swap(kept->track.age_frames, dropped->track.age_frames);
        std::swap(kept->since_s, dropped->since_s);
        kept->times_seen += dropped->times_seen;
      }
      dropped->given_up = true;
    }
  }
}

void Tracker::take_up(const Frame& frame, std::size_t found, const Eigen::Vector2d& velocity_pxps) {
  const Found& mark = frame.found[found];
  const double radius_px = radius_of(mark.ellipse);
  Followed added{{},
                 MarkMotion(mark.measurement, velocity_pxps, kFirstVelocity_radiips * radius_px,
                            settings_.size_unrest_ps)};
  added.since_s = added.seen_s = *time_s_;
  added.track.id = next_id_++;
  set_measured(added.track, frame, found);
  followed_.push_back(std::move(added));
}

void Tracker::set_measured(Track& track, const Frame& frame, std::size_t found) const {
  track.detection = frame.detections[static_cast<std::size_t>(frame.index[found])];
  track.detection.outer.ellipse = frame.found[found].ellipse;
  track.detection_index = frame.index[found];
  track.unseen_s = 0;
  track.status = TrackStatus::tracking;
}

/// Of the marks seen in this frame that are there for certain; what a new one is likely to share.
Eigen::Vector2d Tracker::mean_velocity_pxps() const {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  int count = 0;
  for (const Followed& followed : followed_) {
    if (followed.unseen_frames > 0 || followed.times_seen < kTimesSeenToBelieve) continue;
    sum += followed.motion.velocity_pxps();
    ++count;
  }
  return count > 0 ? Eigen::Vector2d(sum / count) : sum;
}

void Tracker::note_hidden() {
  for (Followed& followed : followed_) {
    if (followed.unseen_frames == 0) continue;
    const double to_be_found = found_probability(expected_of(followed), {0, 0}, frame_size_);
    if (to_be_found >= kHidden) followed.hidden = true;
    if (to_be_found <= kNotHidden) followed.hidden = false;
  }
}

/// While the target has no ellipse the window carries it, if it lay upon the ellipse when there was one last.
void Tracker::use_window(const TargetSearch& search) {
  if (!search.by_window) return;
  Followed& target = followed_[*target_place()];
  if (target.unseen_frames == 0)
    window_is_upon_target_ = search.is_at_window(target.track.detection.outer.ellipse);
  else if (window_is_upon_target_)
    target.motion.update_centre(centre_of(search.by_window->ellipse),
                                search.by_window->centre_covariance_px2);
}

/// What is published of each mark: velocity, and for one that was not seen its place with the doubt about it.
void Tracker::describe_tracks() {
  for (Followed& followed : followed_) {
    Track& track = followed.track;
    track.velocity_pxps = followed.motion.velocity_pxps() + followed.turn_pxps;
    if (track.detection_index >= 0) continue;
    move_to(track.detection, followed.motion);
    const Ellipse& e = track.detection.outer.ellipse;
    EllipseCovariance& covariance = track.detection.outer.covariance;
    const double relative = followed.motion.log_radius_variance();
    covariance.setZero();
    covariance.topLeftCorner<2, 2>() =
        followed.motion.centre_covariance_px2() + common_.variance_px2() * Eigen::Matrix2d::Identity();
    // in common their size; against each other their form: half of a distance squared each
    const double form = std::pow(form_sigma(track.unseen_s), 2) / 2;
    covariance(2, 2) = e.a_px * e.a_px * (relative + form);
    covariance(3, 3) = e.b_px * e.b_px * (relative + form);
    covariance(2, 3) = covariance(3, 2) = e.a_px * e.b_px * (relative - form);
    covariance(4, 4) = std::numbers::pi * std::numbers::pi / 12;  // of an angle that may be any
  }
}

std::optional<std::size_t> Tracker::target_place() const {
  for (std::size_t i = 0; i < followed_.size(); ++i)
    if (followed_[i].track.id == target_id_) return i;
  return std::nullopt;
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
  for (const Followed& followed : followed_) {
    const Track& track = followed.track;
    const Ellipse& e = track.detection.outer.ellipse;
    if (track.detection_index < 0 || !((pixel - centre_of(e)).norm() <= kTakeUpSemiAxes * e.a_px)) continue;
    const double radius_squared = normalized_radius_squared(e, pixel);
    if (radius_squared < least) best = &track, least = radius_squared;
  }
  return best;
}

const Track* Tracker::first_circle() const {
  const Track* first = nullptr;
  for (const auto& followed : followed_)
    if (const Track& track = followed.track; track.detection_index >= 0 &&
                                             track.detection.label == Label::circle &&
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

}  // namespace stevedore
