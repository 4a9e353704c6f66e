#include "platform/platform_track.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <utility>

#include "platform/deck_outlook.hpp"

namespace stevedore {
namespace {

constexpr double rad_per_deg = std::numbers::pi / 180;

constexpr int frames_to_be_found = 3;  // clutter of the right size seldom makes a layout even once

/// A deck at 1.5 m/s is that much further in the fifth of a second between slow frames, and a match from 12 m
/// is good to some 0.1 m.
constexpr double same_candidate_m = 0.5;
constexpr std::int64_t candidate_kept_us = 500'000;

/// A match from 12 m is good to 0.2 m and some degrees, attitude included. With these every slot's place
/// counts as known, see located(), and the next frames tell the rest.
constexpr double match_sigma_of_spacing = 0.12, match_heading_sigma_rad = 0.04;

/// Autopilots send velocity with an error that changes from one message to the next, at 50 Hz.
constexpr double velocity_error_lasts_s = 0.02;

constexpr double cargo_base_radius_m = 0.13;                 // a ten-litre bucket
constexpr double lowest_rim_m = -0.15, highest_rim_m = 0.6;  // over the deck: fallen over, and upright
constexpr double cargo_beside_m = 0.4;                       // farther from the paint it belongs to no slot

double chi_square(const Eigen::Vector2d& off, const Eigen::Matrix2d& covariance) {
  return off.dot(covariance.ldlt().solve(off));
}

/// Cuts the ties of some numbers of the state to all others and gives them new values.
void reset(DeckState& state, Eigen::Index place, double mean, double sigma) {
  state.mean[place] = mean;
  state.covariance.row(place).setZero();
  state.covariance.col(place).setZero();
  state.covariance(place, place) = sigma * sigma;
}

}  // namespace

PlatformTrack::PlatformTrack(int number, const PlatformSettings& settings, std::int64_t utime)
    : settings_(settings),
      motion_(settings),
      filter_(motion_, settings.acceleration_sigma_mps2, utime, motion_.unknown()),
      number_(number) {
  if (const auto allowed = allowed_layouts(settings); allowed.size() == 1) {
    layout_ = allowed.front();
    identity_ = SlotIdentity(layout_->period_rad, layout_->periods());
    beliefs_.resize(layout_->size());
  }
}

// ---- what is told ----

void PlatformTrack::hear(const PlatformReport& report, const VehicleMoment& vehicle) {
  const Eigen::Vector3d position_m = report.position_ned_m - vehicle.ned_from_odometry_m;
  const double heading_rad = report.heading_rad - identity_.turns() * (layout_ ? layout_->period_rad : 0);
  if (reports_heard_ == 0 && seen_utime_ < 0) {  // before all else: where to look, and the height
    DeckState state = motion_.unknown();
    state.mean[at::north] = position_m.x();
    state.mean[at::east] = position_m.y();
    state.mean[at::heading] = heading_rad;
    constexpr double report_height_sigma_m = 5;  // satellite heights are twice as wrong as positions
    reset(state, at::down, position_m.z(), report_height_sigma_m);
    filter_.restart(report.utime, state);
  }
  ++reports_heard_;
  const DeckState before = filter_.at_time(report.utime);
  const Verdict verdict = filter_.add(
      DeckReport{report.utime, position_m.head<2>(), report.velocity_ned_mps.head<2>(), heading_rad});
  if (verdict == Verdict::used) measured_utime_ = std::max(measured_utime_, report.utime);
  reports_refused_ = verdict == Verdict::gated ? reports_refused_ + 1 : 0;
  const bool is_new = verdict == Verdict::used || verdict == Verdict::gated;
  if (is_new && layout_ && seen_utime_ >= 0 && report.utime - seen_utime_ < 1'000'000)
    identity_.told(wrapped(report.heading_rad - before.mean[at::heading]),
                   std::hypot(settings_.reported_heading_sigma_deg * rad_per_deg,
                              std::sqrt(before.covariance(at::heading, at::heading))));
  // ten seconds of reports that all lie elsewhere, and nothing seen: it is the filter that went astray
  constexpr int refused_for_good = 20;
  if (reports_refused_ >= refused_for_good && report.utime - seen_utime_ > 10'000'000) {
    reports_heard_ = reports_refused_ = 0;
    seen_utime_ = -1;
  }
}

// ---- what is seen ----

bool PlatformTrack::located(std::int64_t utime) const {
  return layout_ && seen_utime_ >= 0 &&
         6 * worst_slot_sigma_m(filter_.at_time(utime), *layout_) < layout_->spacing_m();
}

Eigen::Vector2d PlatformTrack::position_odometry_m(std::int64_t utime) const {
  return filter_.at_time(utime).mean.segment<2>(at::north);
}

void PlatformTrack::see(FrameInNed& frame, const FrameSighting& sighting) {
  filter_.set_odometry_rate(frame.vehicle.velocity_variance_m2ps2 * velocity_error_lasts_s);
  if (!located(frame.utime)) return;
  std::vector<SlotMatch> matches =
      assign_slots(filter_.at_time(frame.utime), *layout_, frame.vehicle.position_odometry_m,
                   frame.vehicle.attitude_variance_rad2, frame.circles);
  const bool again =
      seen_at(frame.utime);  // the same frame twice: its circles are taken, and nothing is learnt
  if (matches.empty() || (!again && !measure(frame, matches))) return;
  for (const SlotMatch& match : matches) frame.taken[match.circle] = true;
  if (again) return;
  seen_utime_ = std::max(seen_utime_, frame.utime);
  measured_utime_ = std::max(measured_utime_, frame.utime);
  judge_slots(frame, sighting, matches);
}

/// Averages of attitude over windows that overlap share their noise: as much as if each weighed less.
double PlatformTrack::attitude_overlap(std::int64_t utime) const {
  const auto window_us = static_cast<double>(2 * VehicleHistory::attitude_window_us);
  const auto since_us = static_cast<double>(std::abs(utime - seen_utime_));
  return std::max(1.0, window_us / std::max(since_us, window_us / 4));
}

bool PlatformTrack::measure(const FrameInNed& frame, std::vector<SlotMatch>& matches) {
  for (int attempt = 0; attempt < 2 && !matches.empty(); ++attempt) {
    DeckSight sight{
        frame.utime, frame.vehicle.position_odometry_m, frame.vehicle.attitude_variance_rad2, {}, {}};
    for (const SlotMatch& match : matches) {
      sight.places_m.push_back(layout_->slots_m[match.slot]);
      sight.circles.push_back(frame.circles[match.circle].views[match.view]);
    }
    sight.attitude_variance_rad2 *= attitude_overlap(frame.utime);
    const Verdict verdict = filter_.add(sight);
    if (verdict != Verdict::gated) return verdict == Verdict::used;
    const Innovation innovation = innovation_of(filter_.at_time(frame.utime).mean, sight);
    std::size_t worst = 0;
    double most = -1;
    for (std::size_t i = 0; i < matches.size(); ++i) {
      const auto row = static_cast<Eigen::Index>(i) * numbers_per_circle;
      const double size = innovation.value.segment<3>(row).squaredNorm();
      if (size > most) {
        most = size;
        worst = i;
      }
    }
    matches.erase(matches.begin() + static_cast<std::ptrdiff_t>(worst));
  }
  return false;
}

void PlatformTrack::judge_slots(const FrameInNed& frame, const FrameSighting& sighting,
                                const std::vector<SlotMatch>& matches) {
  const double circle_radius_m = sighting.circles[matches.front().circle].radius_m;
  std::vector<bool> judged(beliefs_.size(), false);
  for (const FrameInNed::Cargo& cargo : frame.cargoes)
    if (const auto slot = judge_cargo(frame, cargo, circle_radius_m)) judged[*slot] = true;
  // where a cargo is seen, it is what the circle's word is about
  for (const SlotMatch& match : matches)
    beliefs_[match.slot].saw_circle(
        frame.utime, judged[match.slot] ? std::nullopt : sighting.circles[match.circle].occupied);
}

/// The slot that it tells something about.
std::optional<std::size_t> PlatformTrack::judge_cargo(const FrameInNed& frame, const FrameInNed::Cargo& cargo,
                                                      double circle_radius_m) {
  const DeckVector mean = filter_.at_time(frame.utime).mean;
  const Eigen::Vector3d from_center_m =
      cargo.from_aircraft_ned_m + frame.vehicle.position_odometry_m - deck_center_odometry_m(mean);
  const Eigen::Vector3d on_deck_m = ned_from_deck(mean).transpose() * from_center_m;
  if (-on_deck_m.z() < lowest_rim_m || -on_deck_m.z() > highest_rim_m)
    return std::nullopt;  // in the air, or below
  std::size_t nearest = 0;
  double offset_m = 1e9;
  for (std::size_t s = 0; s < layout_->size(); ++s) {
    const double away_m = (on_deck_m.head<2>() - layout_->slots_m[s]).norm();
    if (away_m >= offset_m) continue;
    offset_m = away_m;
    nearest = s;
  }
  if (offset_m > circle_radius_m + cargo_beside_m) return std::nullopt;
  constexpr double place_sigma_m = 0.05;  // the deck's own tilt moves the rim by 3 cm at 6 degrees
  const double sigma_m =
      std::hypot(place_sigma_m, std::sqrt(cargo.covariance_m2.topLeftCorner<2, 2>().trace() / 2));
  beliefs_[nearest].saw_cargo(frame.utime, offset_m, sigma_m, circle_radius_m - cargo_base_radius_m);
  return nearest;
}

// ---- finding it ----

std::optional<double> PlatformTrack::log_likelihood(const LayoutMatch& match, std::int64_t utime) const {
  const DeckState state = filter_.at_time(utime);
  Eigen::Matrix2d covariance = state.covariance.block<2, 2>(at::north, at::north);
  // a deck that should be seen and is not has gone astray, nobody knows how; 2 m are more than a deck strays
  // in sight, and far less than two decks are apart
  constexpr double astray_mps = 0.5, farthest_astray_m = 2;
  const double unseen_s = seen_utime_ < 0 ? 0 : static_cast<double>(utime - seen_utime_) * 1e-6;
  covariance.diagonal().array() += std::pow(match_sigma_of_spacing * match.layout.spacing_m(), 2) +
                                   std::pow(std::min(astray_mps * unseen_s, farthest_astray_m), 2);
  const double off = chi_square(match.center_m.head<2>() - state.mean.segment<2>(at::north), covariance);
  if (off > gate_of(2)) return std::nullopt;
  return -off / 2 - std::log(2 * std::numbers::pi * std::sqrt(covariance.determinant()));
}

bool PlatformTrack::found(const LayoutMatch& match, std::int64_t utime) {
  const bool again = candidate_.times > 0 && utime - candidate_.utime < candidate_kept_us &&
                     (match.center_m - candidate_.center_m).norm() < same_candidate_m;
  candidate_ = {match.center_m, utime, again ? candidate_.times + 1 : 1};
  if (candidate_.times < frames_to_be_found) return false;
  candidate_.times = 0;
  restart_at(match, utime);
  return true;
}

void PlatformTrack::restart_at(const LayoutMatch& match, std::int64_t utime) {
  if (!layout_) {
    layout_ = match.layout;
    identity_ = SlotIdentity(layout_->period_rad, layout_->periods());
    beliefs_.assign(layout_->size(), SlotBelief());
  }
  DeckState state = filter_.at_time(utime);
  const double sigma_rad = std::sqrt(state.covariance(at::heading, at::heading));
  const double residual_rad =
      std::remainder(match.heading_rad - state.mean[at::heading], layout_->period_rad);
  // one report alone is no evidence: with fewer than three, any way of turning is as good
  const bool heading_known = seen_utime_ >= 0 || reports_heard_ >= 3;
  const std::vector<double> slipped = identity_.found(residual_rad, heading_known ? sigma_rad : 10);
  std::vector<SlotBelief> beliefs(beliefs_.size());
  for (std::size_t i = 0; i < beliefs.size() && seen_utime_ >= 0; ++i) {
    Eigen::Array3d mixed = Eigen::Array3d::Zero();
    for (std::size_t k = 0; k < slipped.size(); ++k)
      mixed += slipped[k] * beliefs_[layout_->turned(i, -static_cast<int>(k))].probabilities(utime);
    beliefs[i] = beliefs_[i];
    beliefs[i].set(utime, mixed);
  }
  beliefs_ = std::move(beliefs);

  const double match_sigma_m = match_sigma_of_spacing * layout_->spacing_m();
  reset(state, at::north, match.center_m.x(), match_sigma_m);
  reset(state, at::east, match.center_m.y(), match_sigma_m);
  reset(state, at::down, match.center_m.z(), 2 * match_sigma_m);
  reset(state, at::heading, state.mean[at::heading] + residual_rad, match_heading_sigma_rad);
  forget_impossible_velocity(state);
  filter_.restart(utime, state);
  seen_utime_ = measured_utime_ = utime;
}

/// A velocity not told for long may be anything by the filter, but no platform's is beyond what platforms do.
void PlatformTrack::forget_impossible_velocity(DeckState& state) const {
  const DeckState unknown = motion_.unknown();
  for (const Eigen::Index axis : {at::velocity_north, at::velocity_east}) {
    const double most = std::sqrt(unknown.covariance(axis, axis));
    if (state.covariance(axis, axis) > most * most)
      reset(state, axis, std::clamp(state.mean[axis], -most, most), most);
  }
}

// ---- what is known ----

PlatformEstimate PlatformTrack::estimate(std::int64_t utime, const VehicleMoment& vehicle) const {
  const DeckState state = filter_.at_time(utime);
  const DeckCourse course = course_of(state);
  const int turns = identity_.turns();
  const double turned_rad = layout_ ? turns * layout_->period_rad : 0;
  PlatformEstimate out;
  out.utime = utime;
  out.platform = number_;
  out.center_ned_m = course.center_odometry_m + vehicle.ned_from_odometry_m;
  out.velocity_ned_mps = course.velocity_ned_mps;
  out.covariance = course.covariance;
  out.heading_rad = wrapped(state.mean[at::heading] + turned_rad);
  out.heading_variance_rad2 = state.covariance(at::heading, at::heading) + identity_.spread_rad2();
  out.turn_rate_radps = state.mean[at::turn_rate];
  out.heave_m = -swing(state.mean, at::heave);
  const Eigen::Vector2d tilt = Eigen::Rotation2Dd(-turned_rad) *
                               Eigen::Vector2d(swing(state.mean, at::roll), swing(state.mean, at::pitch));
  out.roll_rad = tilt.x();
  out.pitch_rad = tilt.y();
  const bool heading_known =
      layout_ && 3 * std::sqrt(state.covariance(at::heading, at::heading)) < layout_->period_rad / 2;
  out.identity_certain = seen_utime_ >= 0 && number_certain_ && heading_known && identity_.certain();
  out.measured_utime = measured_utime_;
  out.seen_utime = seen_utime_;
  out.predictions = outlook(state, motion_, filter_.disturbance(utime), settings_);
  for (DeckPrediction& p : out.predictions) p.center_ned_m += vehicle.ned_from_odometry_m;
  if (!layout_) return out;
  for (std::size_t j = 0; j < layout_->size(); ++j) {
    const std::size_t i = layout_->turned(j, turns);  // as the filter counts
    const Dependent place = place_on_deck(state.mean, layout_->slots_m[i]);
    out.slots.push_back({place.value + vehicle.ned_from_odometry_m,
                         place.by_state * state.covariance * place.by_state.transpose(),
                         beliefs_[i].state(utime), beliefs_[i].confidence(utime), beliefs_[i].seen_utime()});
  }
  return out;
}

}  // namespace stevedore
