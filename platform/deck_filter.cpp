#include "platform/deck_filter.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <type_traits>
#include <utility>

namespace stevedore {
namespace {

constexpr std::int64_t kept_us = 1'000'000;  // older than any frame or radio message on its way

double seconds(std::int64_t us) {
  return static_cast<double>(us) * 1e-6;
}

/// Platforms keep their course for some ten seconds, and change it within about five.
constexpr std::array<double, 2> model_lasts_s = {10, 5};

/// A course that is kept: what its turn rate leaves over, a metre's sway in a minute.
constexpr double kept_acceleration_mps2 = 0.03;

struct Test {
  Nis nis;
  double log_likelihood = 0;
};

/// Kalman update, in which the error of scale is considered but not learnt (Schmidt, 1966): a single frame
/// says nothing of it, and what hundreds seem to say comes from errors that they share. Whether the
/// innovation passes the gate is for the caller to use.
Test update(DeckState& state, const Innovation& innovation) {
  const Eigen::Matrix<double, at::size, Eigen::Dynamic> cross =
      state.covariance * innovation.by_state.transpose();
  const Eigen::LLT<Eigen::MatrixXd> expected(innovation.by_state * cross + innovation.noise);
  const Eigen::VectorXd whitened = expected.matrixL().solve(innovation.value);
  Test test;
  test.nis = {whitened.squaredNorm(), innovation.value.size(), false};
  test.nis.passed = expected.info() == Eigen::Success && test.nis.value < gate_of(test.nis.numbers);
  test.log_likelihood = -test.nis.value / 2 - expected.matrixLLT().diagonal().array().log().sum();
  // with S = L L^T: gain * innovation = cross L^-T whitened, and the covariance loses (cross L^-T)(...)^T
  const Eigen::Matrix<double, Eigen::Dynamic, at::size> root = expected.matrixL().solve(cross.transpose());
  const double scale_error = state.mean[at::scale_error],
               scale_variance = state.covariance(at::scale_error, at::scale_error);
  state.mean += root.transpose() * whitened;
  state.covariance -= root.transpose() * root;
  state.mean[at::scale_error] = scale_error;
  state.covariance(at::scale_error, at::scale_error) = scale_variance;
  state.mean[at::heading] = wrapped(state.mean[at::heading]);
  return test;
}

DeckState mixture(const std::array<DeckState, 2>& states, const std::array<double, 2>& weight) {
  DeckVector apart = states[1].mean - states[0].mean;
  apart[at::heading] = wrapped(apart[at::heading]);
  DeckState out;
  out.mean = states[0].mean + weight[1] * apart;
  out.mean[at::heading] = wrapped(out.mean[at::heading]);
  out.covariance = weight[0] * states[0].covariance + weight[1] * states[1].covariance +
                   weight[0] * weight[1] * apart * apart.transpose();
  return out;
}

/// Each model may have taken over from the other meanwhile.
DeckModels mixed(const DeckModels& before, double dt_s) {
  std::array<double, 2> leaves{};
  for (std::size_t m = 0; m < 2; ++m) leaves[m] = 1 - std::exp(-dt_s / model_lasts_s[m]);
  DeckModels out;
  for (std::size_t m = 0; m < 2; ++m) {
    const std::size_t other = 1 - m;
    const double stayed = before.probability[m] * (1 - leaves[m]);
    const double came = before.probability[other] * leaves[other];
    out.probability[m] = stayed + came;
    std::array<double, 2> weight{};
    weight[m] = stayed / out.probability[m];
    weight[other] = came / out.probability[m];
    out.states[m] = mixture(before.states, weight);
  }
  return out;
}

/// Bayes, in logarithms; neither model is ever ruled out.
void weigh(DeckModels& models, const std::array<Test, 2>& tests) {
  constexpr double least = 1e-3;
  const double log_odds = tests[1].log_likelihood - tests[0].log_likelihood;
  const double odds =
      std::exp(std::clamp(log_odds, -50.0, 50.0)) * models.probability[1] / models.probability[0];
  models.probability[1] = std::clamp(odds / (1 + odds), least, 1 - least);
  models.probability[0] = 1 - models.probability[1];
}

}  // namespace

double gate_of(Eigen::Index n) {
  constexpr double normal_quantile = 3.719;  // of 1 - 1e-4
  const double k = static_cast<double>(n), spread = 2 / (9 * k);
  return k * std::pow(1 - spread + normal_quantile * std::sqrt(spread), 3);
}

DeckState DeckModels::together() const {
  return mixture(states, probability);
}

DeckFilter::DeckFilter(const DeckMotion& motion, double acceleration_sigma_mps2, std::int64_t utime,
                       const DeckState& start)
    : motion_(motion), acceleration_sigma_mps2_(acceleration_sigma_mps2) {
  restart(utime, start);
}

void DeckFilter::restart(std::int64_t utime, const DeckState& state) {
  history_.clear();
  history_.push_back({utime, std::monostate{}, {{state, state}}, state});
}

Verdict DeckFilter::add(const DeckSight& sight) {
  return insert(sight.utime, sight);
}

Verdict DeckFilter::add(const DeckReport& report) {
  return insert(report.utime, report);
}

Disturbance DeckFilter::of_model(std::size_t model) const {
  return {model == 0 ? kept_acceleration_mps2 : acceleration_sigma_mps2_, odometry_rate_m2ps_};
}

const DeckFilter::Event& DeckFilter::event_before(std::int64_t utime) const {
  const auto after = std::upper_bound(history_.begin(), history_.end(), utime,
                                      [](std::int64_t t, const Event& e) { return t < e.utime; });
  return after == history_.begin() ? history_.front() : *std::prev(after);
}

Disturbance DeckFilter::disturbance(std::int64_t utime) const {
  const auto& p = event_before(utime).after.probability;
  return {std::hypot(std::sqrt(p[0]) * kept_acceleration_mps2, std::sqrt(p[1]) * acceleration_sigma_mps2_),
          odometry_rate_m2ps_};
}

DeckState DeckFilter::at_time(std::int64_t utime) const {
  const Event& before = event_before(utime);
  return motion_.predicted(before.together, seconds(utime - before.utime), disturbance(utime));
}

bool DeckFilter::run(const Event& before, Event& event) {
  const double dt_s = seconds(event.utime - before.utime);
  event.after = mixed(before.after, dt_s);
  std::array<Test, 2> tests;
  for (std::size_t m = 0; m < 2; ++m) {
    DeckState& state = event.after.states[m];
    state = motion_.predicted(state, dt_s, of_model(m));
    tests[m] = std::visit(
        [&](const auto& measurement) {
          if constexpr (std::is_same_v<std::decay_t<decltype(measurement)>, std::monostate>)
            return Test{{0, 0, true}, 0};
          else
            return update(state, innovation_of(state.mean, measurement));
        },
        event.measurement);
  }
  last_nis_ = tests[event.after.probability[1] > event.after.probability[0] ? 1 : 0].nis;
  weigh(event.after, tests);
  event.together = event.after.together();
  return tests[0].nis.passed || tests[1].nis.passed;
}

Verdict DeckFilter::insert(std::int64_t utime, Measurement measurement) {
  if (utime < history_.front().utime) return Verdict::too_late;
  const auto place = std::upper_bound(history_.begin(), history_.end(), utime,
                                      [](std::int64_t t, const Event& e) { return t < e.utime; });
  for (auto same = place; same != history_.begin() && std::prev(same)->utime == utime; --same)
    if (std::prev(same)->measurement.index() == measurement.index()) return Verdict::duplicate;

  auto event = history_.insert(place, {utime, std::move(measurement), {}, {}});
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
