#include "tools/evaluate_platforms.hpp"

#include <Eigen/Core>
#include <Eigen/LU>

#include <cmath>
#include <limits>
#include <map>

namespace stevedore {
namespace {

// Three frames at 15 Hz: over twice that a swinging deck, 0.3 m/s2, is at most 6 mm off the straight line.
constexpr std::int64_t gap_us = 200'000;

/// The mean of a platform's circles, which is its deck's middle.
std::optional<Eigen::Vector3d> middle_of(const truth_t& truth, int platform) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int count = 0;
  for (const truth_circle_t& circle : truth.circles) {
    if (circle.platform != platform) continue;
    sum += Eigen::Vector3d(circle.center_ned_m);
    ++count;
  }
  if (count < 2) return std::nullopt;
  return sum / count;
}

std::optional<Eigen::Vector3d> middle_at(const std::vector<truth_t>& truth, int platform,
                                         std::int64_t utime) {
  const auto between = around(truth, utime, gap_us);
  if (!between) return std::nullopt;
  const auto before = middle_of(*between->before, platform), after = middle_of(*between->after, platform);
  if (!before || !after) return std::nullopt;
  return *before + between->share * (*after - *before);
}

/// Over 0.2 s about the moment: shorter than any swing of a deck by far, and TRUTH has no noise.
std::optional<Eigen::Vector3d> velocity_at(const std::vector<truth_t>& truth, int platform,
                                           std::int64_t utime) {
  constexpr std::int64_t half_us = 100'000;
  const auto before = middle_at(truth, platform, utime - half_us),
             after = middle_at(truth, platform, utime + half_us);
  if (!before || !after) return std::nullopt;
  return (*after - *before) / (2e-6 * static_cast<double>(half_us));
}

/// What the autopilot says of its position, less where it is.
std::optional<Eigen::Vector3d> told_less_true(const FlightLog& flight, const truth_t& truth) {
  const auto between = around(flight.vehicle, truth.header.utime, gap_us);
  if (!between) return std::nullopt;
  const Eigen::Vector3d before(between->before->position_ned_m), after(between->after->position_ned_m);
  return before + between->share * (after - before) - Eigen::Vector3d(truth.position_ned_m);
}

double nees6_of(const platform_estimate_t& estimate, const Eigen::Vector3d& position_m,
                const Eigen::Vector3d& velocity_mps) {
  const Eigen::Matrix<double, 6, 6> covariance =
      Eigen::Map<const Eigen::Matrix<double, 6, 6>>(estimate.covariance);
  Eigen::Matrix<double, 6, 1> error;
  error << position_m, velocity_mps;
  const Eigen::FullPivLU<Eigen::Matrix<double, 6, 6>> lu(covariance);
  return lu.isInvertible() ? error.dot(lu.solve(error)) / 6 : std::numeric_limits<double>::quiet_NaN();
}

const deck_prediction_t* one_second_ahead(const platform_estimate_t& estimate) {
  for (const deck_prediction_t& prediction : estimate.predictions)
    if (std::abs(prediction.ahead_s - 1) < 1e-6) return &prediction;
  return nullptr;
}

bool cargo_lies_beside(const truth_t& truth, const truth_circle_t& circle) {
  for (const truth_cargo_t& cargo : truth.cargoes) {
    const double off_m = (Eigen::Vector3d(cargo.center_ned_m) - Eigen::Vector3d(circle.center_ned_m)).norm();
    if (cargo.platform == circle.platform && cargo.slot < 0 && off_m < 2 * circle.radius_m) return true;
  }
  return false;
}

/// On the hook, and as low over the circle as if it stood there: to the camera it does.
bool cargo_is_handled(const truth_t& truth, const truth_circle_t& circle) {
  constexpr double lifted_m = 0.6;  // of the rim over the deck: twice a bucket's height
  for (const truth_cargo_t& cargo : truth.cargoes) {
    if (!cargo.on_hook) continue;
    const Eigen::Vector3d off_m = Eigen::Vector3d(cargo.center_ned_m) - Eigen::Vector3d(circle.center_ned_m);
    if (off_m.head<2>().norm() < circle.radius_m && std::abs(off_m.z()) < lifted_m) return true;
  }
  return false;
}

void judge(const slot_t& slot, const truth_t& truth, const truth_circle_t& circle, SlotCounts& counts) {
  if (circle.slot != slot.index) ++counts.misnumbered;
  if (slot.state == slot_t::STATE_UNKNOWN) {
    ++counts.unknown;
    return;
  }
  if (cargo_is_handled(truth, circle)) {
    ++counts.handled;
    return;
  }
  const bool is_right = slot.state == slot_t::STATE_MISPLACED
                            ? !circle.occupied && cargo_lies_beside(truth, circle)
                            : circle.occupied == (slot.state == slot_t::STATE_OCCUPIED);
  ++(is_right ? counts.right : counts.wrong);
}

/// By where slots are on the deck, so that a deck out of view, whose place is no longer known to a slot's
/// size, has the right slots for as long as its heading is known.
void judge_slots(const platform_estimate_t& estimate, const truth_t& truth, const Eigen::Vector3d& middle_m,
                 SlotCounts& counts) {
  for (const slot_t& slot : estimate.slots) {
    const Eigen::Vector3d on_deck_m =
        Eigen::Vector3d(slot.center_ned_m) - Eigen::Vector3d(estimate.center_ned_m);
    const Eigen::Vector3d place_m = middle_m + on_deck_m;
    const truth_circle_t* closest = nullptr;
    double closest_m = std::numeric_limits<double>::infinity();
    for (const truth_circle_t& circle : truth.circles) {
      const double off_m = (Eigen::Vector3d(circle.center_ned_m) - place_m).norm();
      if (circle.platform != estimate.platform || off_m >= closest_m) continue;
      closest_m = off_m;
      closest = &circle;
    }
    if (closest) judge(slot, truth, *closest, counts);
  }
}

/// For how long each platform has been in view.
class Views {
 public:
  std::optional<double> in_view_s(const platform_estimate_t& estimate) {
    constexpr std::int64_t in_view_us = 500'000;
    const std::int64_t now = estimate.header.utime;
    const bool is_seen = estimate.seen_utime >= 0 && now - estimate.seen_utime < in_view_us;
    if (!is_seen) {
      since_.erase(estimate.platform);
      return std::nullopt;
    }
    const std::int64_t since = since_.try_emplace(estimate.platform, estimate.seen_utime).first->second;
    return static_cast<double>(now - since) * 1e-6;
  }

 private:
  std::map<int, std::int64_t> since_;
};

void sum_up(PlatformComparison& result) {
  constexpr double low_m = 6, settled_s = 3;
  std::vector<double> position_m, velocity_mps, predicted_m, held_m, nees6;
  for (const PlatformSample& sample : result.samples) {
    if (sample.height_m > low_m || sample.in_view_s.value_or(0) < settled_s) continue;
    position_m.push_back(sample.position_error_m);
    velocity_mps.push_back(sample.velocity_error_mps);
    if (std::isfinite(sample.nees6)) nees6.push_back(sample.nees6);
    if (!sample.predicted_error_m || !sample.held_error_m) continue;
    predicted_m.push_back(*sample.predicted_error_m);
    held_m.push_back(*sample.held_error_m);
  }
  result.position_m = spread_of(position_m);
  result.velocity_mps = spread_of(velocity_mps);
  result.predicted_m = spread_of(predicted_m);
  result.held_m = spread_of(held_m);
  if (!nees6.empty()) result.nees6 = spread_of(nees6).mean;
}

}  // namespace

PlatformComparison compare_platforms(const FlightLog& flight) {
  constexpr std::int64_t same_frame_us = 0;
  PlatformComparison result;
  Views views;
  for (const platform_estimate_t& estimate : flight.estimates) {
    const std::int64_t now = estimate.header.utime;
    const auto in_view_s = views.in_view_s(estimate);
    const truth_t* truth = nearest(flight.truth, now, same_frame_us);
    const auto middle = truth ? middle_of(*truth, estimate.platform) : std::nullopt;
    const auto offset_m = truth ? told_less_true(flight, *truth) : std::nullopt;
    const auto velocity = velocity_at(flight.truth, estimate.platform, now);
    if (!middle || !offset_m) {
      ++result.without_truth;
      continue;
    }
    judge_slots(estimate, *truth, *middle, estimate.identity_certain ? result.certain : result.uncertain);
    if (in_view_s) {
      ++result.in_view;
      result.in_view_certain += estimate.identity_certain;
    }
    if (!velocity) continue;  // at the ends of the log
    const Eigen::Vector3d place_m = Eigen::Vector3d(estimate.center_ned_m) - *offset_m;
    const Eigen::Vector3d position_error_m = place_m - *middle;
    const Eigen::Vector3d velocity_error_mps = Eigen::Vector3d(estimate.velocity_ned_mps) - *velocity;
    PlatformSample sample;
    sample.utime = now;
    sample.platform = estimate.platform;
    sample.is_certain = estimate.identity_certain;
    sample.in_view_s = in_view_s;
    sample.height_m = middle->z() - truth->camera_ned_m[2];
    sample.position_error_m = position_error_m.norm();
    sample.velocity_error_mps = velocity_error_mps.norm();
    sample.nees6 = nees6_of(estimate, position_error_m, velocity_error_mps);
    const deck_prediction_t* prediction = one_second_ahead(estimate);
    if (const auto then = middle_at(flight.truth, estimate.platform, now + 1'000'000); then && prediction) {
      sample.predicted_error_m = (Eigen::Vector3d(prediction->center_ned_m) - *offset_m - *then).norm();
      sample.held_error_m = (place_m - *then).norm();
    }
    result.samples.push_back(sample);
  }
  sum_up(result);
  return result;
}

}  // namespace stevedore
