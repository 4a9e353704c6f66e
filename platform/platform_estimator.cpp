#include "platform/platform_estimator.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>

namespace stevedore {
namespace {

/// A stream that went back this far is another one: a log played again.
constexpr std::int64_t another_stream_us = 3'000'000;

/// Platforms are 15 m apart or more; half of that is beyond what both positions are off together.
constexpr double mistaken_m = 7.5;

/// A platform of which nothing is known is as likely anywhere on a field of 60 m: log of one over its area.
const double anywhere_log_likelihood = -std::log(60.0 * 60.0);

/// Between two explanations: one is 20 times likelier.
constexpr double clear_margin = 3;

constexpr int votes_to_renumber = 3;  // messages in a row: 1.5 s
constexpr std::size_t most_free_circles = 12;

/// What assignment can handle.
void check(const SlotLayout& layout) {
  if (layout.size() > most_slots)
    throw std::invalid_argument("platform.slots: more than " + std::to_string(most_slots) + " slots");
  if (layout.size() < fewest_slots)
    throw std::invalid_argument("platform.slots: fewer than " + std::to_string(fewest_slots) +
                                " slots: no deck can be told by them");
  if (layout.spacing_m() < 0.1) throw std::invalid_argument("platform.slots: two slots in one place");
}

}  // namespace

PlatformEstimator::PlatformEstimator(const PlatformSettings& settings)
    : settings_(settings), layouts_(allowed_layouts(settings)) {
  for (const SlotLayout& layout : layouts_) check(layout);
}

void PlatformEstimator::add_vehicle(const VehicleSample& sample) {
  if (sample.utime < vehicle_.newest_utime() - another_stream_us) {
    vehicle_ = VehicleHistory();
    tracks_.clear();
    votes_.clear();
  }
  vehicle_.add(sample);
}

const PlatformTrack* PlatformEstimator::track(int number) const {
  for (const PlatformTrack& track : tracks_)
    if (track.number() == number) return &track;
  return nullptr;
}

// ---- what platforms say ----

void PlatformEstimator::add_report(const PlatformReport& report) {
  const auto vehicle = vehicle_.at(report.utime);
  if (!vehicle) return;
  settle_numbers(report, *vehicle);
  const auto of_it = [&](const PlatformTrack& track) { return track.number() == report.platform; };
  auto track = std::find_if(tracks_.begin(), tracks_.end(), of_it);
  if (track == tracks_.end()) {
    if (!make_room(report.utime)) return;
    tracks_.emplace_back(report.platform, settings_, report.utime);
    track = std::prev(tracks_.end());
    track->set_number_certain(true);
  }
  track->hear(report, *vehicle);
}

/// A platform that speaks is real; a deck that never spoke and is out of sight may have been a false one.
bool PlatformEstimator::make_room(std::int64_t utime) {
  if (static_cast<int>(tracks_.size()) < settings_.count) return true;
  const auto doubtful = std::find_if(tracks_.begin(), tracks_.end(), [&](const PlatformTrack& track) {
    return !track.has_spoken() && !track.located(utime);
  });
  if (doubtful == tracks_.end()) return false;
  tracks_.erase(doubtful);
  return true;
}

PlatformTrack* PlatformEstimator::track_near(const Eigen::Vector2d& position_odometry_m, std::int64_t utime) {
  for (PlatformTrack& track : tracks_)
    if (track.located(utime) && (track.position_odometry_m(utime) - position_odometry_m).norm() < mistaken_m)
      return &track;
  return nullptr;
}

/// A deck that was found before its platform had spoken was given any number; where the platform says it is
/// tells the right one.
void PlatformEstimator::settle_numbers(const PlatformReport& report, const VehicleMoment& vehicle) {
  PlatformTrack* near =
      track_near((report.position_ned_m - vehicle.ned_from_odometry_m).head<2>(), report.utime);
  Votes votes = std::exchange(votes_[report.platform], {});
  if (!near) return;
  const int given = near->number();
  if (given == report.platform) {
    near->set_number_certain(true);
    return;
  }
  if (votes.given != given) votes = {given, 0};
  if (++votes.in_a_row < votes_to_renumber) {
    votes_[report.platform] = votes;
    return;
  }
  for (PlatformTrack& other : tracks_)
    if (other.number() == report.platform) other.renumber(given);
  near->renumber(report.platform);
  near->set_number_certain(true);
}

// ---- what is seen ----

FrameInNed PlatformEstimator::turned_to_ned(const FrameSighting& sighting,
                                            const VehicleMoment& vehicle) const {
  FrameInNed frame{sighting.utime, vehicle, {}, std::vector<bool>(sighting.circles.size(), false), {}};
  const Eigen::Matrix3d ned_from_body = vehicle.ned_from_body.toRotationMatrix();
  const Eigen::Matrix3d ned_from_camera = ned_from_body * sighting.body_from_camera;
  const Eigen::Vector3d camera_ned_m =
      ned_from_body *
      Eigen::Vector3d(settings_.camera_forward_m, settings_.camera_right_m, settings_.camera_down_m);
  for (const CircleSighting& circle : sighting.circles) {
    CircleCandidates& candidates = frame.circles.emplace_back();
    for (const SeenCircle& seen : circle.solutions) {
      candidates.views.push_back({camera_ned_m + ned_from_camera * seen.center_camera_m,
                                  ned_from_camera * seen.covariance_m2 * ned_from_camera.transpose(),
                                  ned_from_camera * seen.normal_camera, seen.normal_variance_rad2});
      candidates.probability.push_back(seen.probability);
    }
  }
  for (const CargoSighting& cargo : sighting.cargoes)
    frame.cargoes.push_back({camera_ned_m + ned_from_camera * cargo.center_camera_m,
                             ned_from_camera * cargo.covariance_m2 * ned_from_camera.transpose(),
                             cargo.radius_m});
  return frame;
}

std::vector<PlatformEstimate> PlatformEstimator::add_frame(const FrameSighting& sighting) {
  const auto vehicle = vehicle_.at(sighting.utime);
  if (!vehicle) return {};
  FrameInNed frame = turned_to_ned(sighting, *vehicle);
  for (PlatformTrack& track : tracks_) track.see(frame, sighting);
  find_among_free_circles(frame, sighting);
  std::sort(tracks_.begin(), tracks_.end(),
            [](const PlatformTrack& a, const PlatformTrack& b) { return a.number() < b.number(); });
  std::vector<PlatformEstimate> estimates;
  for (const PlatformTrack& track : tracks_)
    if (track.known()) estimates.push_back(track.estimate(sighting.utime, *vehicle));
  return estimates;
}

std::vector<LayoutMatch> PlatformEstimator::matches_for(const std::optional<SlotLayout>& known,
                                                        const std::vector<Eigen::Vector3d>& circles_m) const {
  if (known) return match_layout(*known, false, circles_m);
  std::vector<LayoutMatch> all;
  for (const SlotLayout& layout : layouts_) {
    const auto matches = match_layout(layout, layouts_.size() > 1, circles_m);
    all.insert(all.end(), matches.begin(), matches.end());
  }
  return all;
}

/// Circles that no located deck has taken: a deck that comes into view, or is seen for the first time.
void PlatformEstimator::find_among_free_circles(FrameInNed& frame, const FrameSighting& sighting) {
  std::vector<Eigen::Vector3d> circles_m;
  for (std::size_t i = 0; i < frame.circles.size() && circles_m.size() < most_free_circles; ++i)
    if (!frame.taken[i] && !frame.circles[i].views.empty())
      circles_m.push_back(frame.circles[i].views.front().from_aircraft_ned_m +
                          frame.vehicle.position_odometry_m);
  if (circles_m.size() < 3) return;

  struct Hypothesis {
    std::size_t track;  ///< tracks_.size(): a new one
    LayoutMatch match;
    double log_likelihood;
  };
  std::vector<Hypothesis> hypotheses;
  for (std::size_t t = 0; t < tracks_.size(); ++t) {
    if (tracks_[t].seen_at(frame.utime)) continue;
    for (const LayoutMatch& match : matches_for(tracks_[t].layout(), circles_m))
      if (const auto log_likelihood = tracks_[t].log_likelihood(match, frame.utime))
        hypotheses.push_back({t, match, *log_likelihood});
  }
  if (static_cast<int>(tracks_.size()) < settings_.count)
    for (const LayoutMatch& match : matches_for(std::nullopt, circles_m))
      if (!track_near(match.center_m.head<2>(), frame.utime))
        hypotheses.push_back({tracks_.size(), match, anywhere_log_likelihood});
  if (hypotheses.empty()) return;
  const auto best = std::max_element(
      hypotheses.begin(), hypotheses.end(),
      [](const Hypothesis& a, const Hypothesis& b) { return a.log_likelihood < b.log_likelihood; });
  bool which_is_clear = true;
  for (const Hypothesis& other : hypotheses) {
    if (&other == &*best || other.log_likelihood < best->log_likelihood - clear_margin) continue;
    if ((other.match.center_m - best->match.center_m).norm() > 0.5) return;  // where is not clear: wait
    if (other.track != best->track) which_is_clear = false;
  }
  if (best->track == tracks_.size()) {
    int number = 0;
    while (track(number)) ++number;
    tracks_.emplace_back(number, settings_, frame.utime);
    which_is_clear = false;
  }
  PlatformTrack& found = tracks_[best->track];
  if (!found.found(best->match, frame.utime)) return;
  if (!which_is_clear) found.set_number_certain(false);
  found.see(frame, sighting);
}

}  // namespace stevedore
