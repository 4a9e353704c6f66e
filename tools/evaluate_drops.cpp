#include "tools/evaluate_drops.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace stevedore {
namespace {

const truth_cargo_t* cargo_in(const truth_t& truth, std::int16_t index) {
  const auto found = std::find_if(truth.cargoes.begin(), truth.cargoes.end(),
                                  [&](const truth_cargo_t& cargo) { return cargo.index == index; });
  return found == truth.cargoes.end() ? nullptr : &*found;
}

double apart_m(const truth_cargo_t& cargo, const truth_circle_t& circle) {
  return std::hypot(cargo.center_ned_m[0] - circle.center_ned_m[0],
                    cargo.center_ned_m[1] - circle.center_ned_m[1]);
}

std::optional<double> unseen_s(const PoseComparison& poses, const std::string& circle, std::int64_t utime) {
  std::optional<std::int64_t> last;
  for (const PoseSample& sample : poses.samples)
    if (sample.mark == circle && sample.utime <= utime) last = std::max(last.value_or(0), sample.utime);
  if (!last) return std::nullopt;
  return static_cast<double>(utime - *last) * 1e-6;
}

/// Where it stands when it has come to rest; nothing where TRUTH ends before, or it hangs again.
std::optional<Drop> drop_at(const std::vector<truth_t>& truth, std::size_t let_go, std::int16_t index,
                            const PoseComparison& poses) {
  constexpr std::int64_t rests_after_us = 3'000'000;
  const std::int64_t utime = truth[let_go].header.utime;
  for (std::size_t i = let_go; i < truth.size(); ++i) {
    const truth_cargo_t* cargo = cargo_in(truth[i], index);
    if (!cargo || cargo->on_hook) return std::nullopt;
    if (truth[i].header.utime < utime + rests_after_us || truth[i].circles.empty()) continue;
    const auto& circles = truth[i].circles;
    const truth_circle_t& circle = *std::min_element(
        circles.begin(), circles.end(),
        [&](const auto& a, const auto& b) { return apart_m(*cargo, a) < apart_m(*cargo, b); });
    return Drop{utime,
                index,
                circle.platform,
                circle.slot,
                apart_m(*cargo, circle),
                cargo->tipped != 0,
                unseen_s(poses, name_of_circle(circle.platform, circle.slot), utime)};
  }
  return std::nullopt;
}

}  // namespace

std::vector<Drop> find_drops(const std::vector<truth_t>& truth, const PoseComparison& poses) {
  std::vector<Drop> drops;
  std::map<std::int16_t, int> stood_on;  ///< platform, by cargo
  std::map<std::int16_t, bool> hung;
  for (std::size_t i = 0; i < truth.size(); ++i) {
    for (const truth_cargo_t& cargo : truth[i].cargoes) {
      const bool let_go = hung[cargo.index] && !cargo.on_hook;
      hung[cargo.index] = cargo.on_hook != 0;
      if (let_go) {
        const auto drop = drop_at(truth, i, cargo.index, poses);
        if (drop && drop->platform != stood_on[cargo.index]) drops.push_back(*drop);
      }
      if (!cargo.on_hook && cargo.platform >= 0) stood_on[cargo.index] = cargo.platform;
    }
  }
  return drops;
}

}  // namespace stevedore
