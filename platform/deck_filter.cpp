#include "platform/deck_filter.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace stevedore {
namespace {

constexpr std::int64_t kept_us = 1'000'000;  // older than any frame or radio message on its way

double seconds(std::int64_t us) {
  return static_cast<double>(us) * 1e-6;
}

/// Kalman update, if the innovation passes its gate.
Nis update(DeckState& state, const Innovation& innovation) {
  const Eigen::Matrix<double, at::size, Eigen::Dynamic> cross =
      state.covariance * innovation.by_state.transpose();
  const Eigen::LLT<Eigen::MatrixXd> expected(innovation.by_state * cross + innovation.noise);
  Nis nis;
  nis.numbers = innovation.value.size();
  const Eigen::VectorXd whitened = expected.matrixL().solve(innovation.value);
  nis.value = whitened.squaredNorm();
  nis.passed = expected.info() == Eigen::Success && nis.value < gate_of(nis.numbers);
  if (!nis.passed) return nis;
  // with S = L L^T: gain * innovation = cross L^-T whitened, and the covariance loses (cross L^-T)(...)^T
  const Eigen::Matrix<double, Eigen::Dynamic, at::size> root = expected.matrixL().solve(cross.transpose());
  state.mean += root.transpose() * whitened;
  state.covariance -= root.transpose() * root;
  state.mean[at::heading] = wrapped(state.mean[at::heading]);
  return nis;
}

}  // namespace

double gate_of(Eigen::Index n) {
  constexpr double normal_quantile = 3.719;  // of 1 - 1e-4
  const double k = static_cast<double>(n), spread = 2 / (9 * k);
  return k * std::pow(1 - spread + normal_quantile * std::sqrt(spread), 3);
}

DeckFilter::DeckFilter(const DeckMotion& motion, std::int64_t utime, const DeckState& start)
    : motion_(motion) {
  restart(utime, start);
}

void DeckFilter::restart(std::int64_t utime, const DeckState& state) {
  history_.clear();
  history_.push_back({utime, std::monostate{}, state});
}

Verdict DeckFilter::add(const DeckSight& sight) {
  return insert(sight.utime, sight);
}

Verdict DeckFilter::add(const DeckReport& report) {
  return insert(report.utime, report);
}

DeckState DeckFilter::at_time(std::int64_t utime) const {
  const auto after = std::upper_bound(history_.begin(), history_.end(), utime,
                                      [](std::int64_t t, const Event& e) { return t < e.utime; });
  if (after == history_.begin()) return history_.front().after;
  const Event& before = *std::prev(after);
  return motion_.predicted(before.after, seconds(utime - before.utime), odometry_rate_m2ps_);
}

bool DeckFilter::run(const Event& before, Event& event) {
  event.after = motion_.predicted(before.after, seconds(event.utime - before.utime), odometry_rate_m2ps_);
  if (const auto* sight = std::get_if<DeckSight>(&event.measurement))
    last_nis_ = update(event.after, innovation_of(event.after.mean, *sight));
  else if (const auto* report = std::get_if<DeckReport>(&event.measurement))
    last_nis_ = update(event.after, innovation_of(event.after.mean, *report));
  return last_nis_.passed;
}

Verdict DeckFilter::insert(std::int64_t utime, Measurement measurement) {
  if (utime < history_.front().utime) return Verdict::too_late;
  const auto place = std::upper_bound(history_.begin(), history_.end(), utime,
                                      [](std::int64_t t, const Event& e) { return t < e.utime; });
  for (auto same = place; same != history_.begin() && std::prev(same)->utime == utime; --same)
    if (std::prev(same)->measurement.index() == measurement.index()) return Verdict::duplicate;

  auto event = history_.insert(place, {utime, std::move(measurement), {}});
  const bool passed = run(*std::prev(event), *event);
  if (!passed) {
    history_.erase(event);
    return Verdict::gated;
  }
  const Nis nis = last_nis_;
  for (auto later = std::next(event); later != history_.end(); ++later) run(*std::prev(later), *later);
  last_nis_ = nis;
  while (history_.size() > 1 && history_[1].utime < history_.back().utime - kept_us) history_.pop_front();
  return Verdict::used;
}

}  // namespace stevedore
