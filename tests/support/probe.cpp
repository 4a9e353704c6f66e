// What system tests need to see and do on the bus.
//   probe kill NAME...             kill -9 each process in turn; prints how long until its next output, ms
//   probe wait CHANNEL [N] [S]     until N messages (1) came, S seconds (20) at most
//   probe state NAME STATE [S]     until the process says ok, degraded, failed or finished in HEALTH
//   probe targets LOG PATTERN      the target of each TRACKS as locate --track prints it; PATTERN: an image's
//   name, e.g.
//                                  mire-2/image.0000.pgm, counted from 1
//   probe world LOG                of a flight in the world: how level the camera was, ellipses against TRUTH
//   probe garbage SECONDS          random bytes on every channel
#include <signal.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <lcm/lcm-cpp.hpp>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "runtime/event_log.hpp"
#include "runtime/lcm_bus.hpp"
#include "runtime/time.hpp"

namespace {

using stevedore::LcmBus;
using stevedore::monotonic_utime;

constexpr int64_t patience_us = 20'000'000;

const std::map<std::string, std::string> outputs = {
    {"camera_proc", "FRAME"},      {"sim_proc", "FRAME"},      {"gimbal_proc", "GIMBAL_LEVEL"},
    {"detector_proc", "ELLIPSES"}, {"tracker_proc", "TRACKS"}, {"pose_proc", "POSES"},
    {"mission_proc", "MISSION"},   {"record", "HEALTH"}};

/// Newest HEALTH of each process, and the newest message of every output channel.
struct Watcher {
  explicit Watcher(LcmBus& bus) {
    bus.subscribe<stevedore::health_t>(stevedore::channels::health, [this](const stevedore::health_t& m) {
      health[m.process] = m;
      if (m.process == "record") heard("HEALTH", m.header);
    });
    const auto follow = [this, &bus]<class M>(const stevedore::Channel<M>& channel) {
      bus.subscribe<M>(channel, [this, name = channel.name](const M& m) { heard(name, m.header); });
    };
    follow(stevedore::channels::frame);
    follow(stevedore::channels::ellipses);
    follow(stevedore::channels::tracks);
    follow(stevedore::channels::poses);
    follow(stevedore::channels::mission);
    follow(stevedore::channels::gimbal_level);
  }
  void heard(const std::string& channel, const stevedore::header_t& header) {
    run_id[channel] = header.trace.run_id;
    ++count[channel];
  }
  std::map<std::string, stevedore::health_t> health;
  std::map<std::string, int64_t> run_id;
  std::map<std::string, int64_t> count;
};

template <class Condition>
bool wait_for(LcmBus& bus, Condition condition, int64_t patience = patience_us) {
  const int64_t until = monotonic_utime() + patience;
  while (!condition() && monotonic_utime() < until) bus.handle(1);
  return condition();
}

int kill_each(const std::vector<std::string>& names) {
  LcmBus bus(stevedore::default_lcm_url);
  Watcher watcher(bus);
  for (const std::string& name : names) {
    const std::string channel = outputs.at(name);
    if (!wait_for(bus, [&] { return watcher.health.contains(name) && watcher.run_id.contains(channel); })) {
      std::fprintf(stderr, "%s is not running\n", name.c_str());
      return 1;
    }
    const int64_t old_run = watcher.run_id[channel];
    const int64_t killed_utime = monotonic_utime();
    kill(watcher.health[name].pid, SIGKILL);
    if (!wait_for(bus, [&] { return watcher.run_id[channel] != old_run; })) {
      std::fprintf(stderr, "%s did not come back\n", name.c_str());
      return 1;
    }
    std::printf("%-14s %7.0f ms\n", name.c_str(),
                static_cast<double>(monotonic_utime() - killed_utime) * 1e-3);
    std::fflush(stdout);
    const int64_t missions = watcher.count["MISSION"];
    if (!wait_for(bus,
                  [&] { return watcher.count["MISSION"] >= missions + 10; })) {  // the line is whole again
      std::fprintf(stderr, "no MISSION after %s came back\n", name.c_str());
      return 1;
    }
  }
  return 0;
}

int wait_for_channel(const std::string& channel, int64_t count, double seconds) {
  lcm::LCM lcm(stevedore::default_lcm_url);
  if (!lcm.good()) return 1;
  int64_t seen = 0;
  lcm.subscribeFunction(
      channel, +[](const lcm::ReceiveBuffer*, const std::string&, int64_t* n) { ++*n; }, &seen);
  const int64_t until = monotonic_utime() + static_cast<int64_t>(seconds * 1e6);
  while (seen < count && monotonic_utime() < until) lcm.handleTimeout(50);
  std::printf("%lld messages on %s\n", static_cast<long long>(seen), channel.c_str());
  return seen >= count ? 0 : 1;
}

int wait_for_state(const std::string& name, const std::string& state, double seconds) {
  static const std::map<std::string, int8_t> states = {{"ok", stevedore::health_t::STATE_OK},
                                                       {"degraded", stevedore::health_t::STATE_DEGRADED},
                                                       {"failed", stevedore::health_t::STATE_FAILED},
                                                       {"finished", stevedore::health_t::STATE_FINISHED}};
  LcmBus bus(stevedore::default_lcm_url);
  Watcher watcher(bus);
  const bool said = wait_for(
      bus, [&] { return watcher.health.contains(name) && watcher.health[name].state == states.at(state); },
      static_cast<int64_t>(seconds * 1e6));
  std::printf("%s: %s\n", name.c_str(), watcher.health[name].message.c_str());
  return said ? 0 : 1;
}

int send_garbage(double seconds) {
  lcm::LCM lcm(stevedore::default_lcm_url);
  if (!lcm.good()) return 1;
  std::mt19937 random(1);
  const int64_t until = monotonic_utime() + static_cast<int64_t>(seconds * 1e6);
  // half of it with a good type, so that it gets past the fingerprint
  std::map<std::string, std::vector<uint8_t>> good;
  std::apply(
      [&](const auto&... c) {
        ((good[c.name] = stevedore::encode(typename std::decay_t<decltype(c)>::Message{})), ...);
      },
      stevedore::channels::all);
  while (monotonic_utime() < until) {
    for (const auto& [channel, bytes] : good) {
      std::vector<uint8_t> message(bytes);
      const size_t keep = random() % 2 == 0 ? 8 : 0;
      for (size_t i = keep; i < message.size(); ++i) {
        if (random() % 4 == 0) message[i] = static_cast<uint8_t>(random());
      }
      lcm.publish(channel, message.data(), static_cast<unsigned>(message.size()));
    }
    lcm.handleTimeout(2);
  }
  return 0;
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return -1;
  std::sort(values.begin(), values.end());
  return values[static_cast<size_t>(share * static_cast<double>(values.size() - 1))];
}

/// Of a flight in the world: how level the camera was, and how far from TRUTH's outlines the ellipses found
/// are. Status 1 when the camera was not level, or outlines and frames are not in the same pixels.
int judge_world(const std::string& log) {
  std::map<int64_t, stevedore::truth_t> truths;  // by the frame's utime
  std::map<int64_t, stevedore::ellipses_t> found;
  std::vector<double> off_level_deg, off_px;
  int circles = 0;
  stevedore::LogReader reader(log);
  while (const auto event = reader.next()) {
    if (const auto truth = stevedore::decode(*event, stevedore::channels::truth))
      truths[truth->header.utime] = *truth;
    if (const auto ellipses = stevedore::decode(*event, stevedore::channels::ellipses))
      found[ellipses->header.utime] = *ellipses;
    const auto level = stevedore::decode(*event, stevedore::channels::gimbal_level);
    const bool started = level && level->header.seq >= 50;  // a second, in which it finds its level
    if (started && level->off_level_rad >= 0) off_level_deg.push_back(level->off_level_rad * 180 / M_PI);
  }
  for (const auto& [utime, truth] : truths) {
    for (const auto& circle : truth.circles) {
      const auto& t = circle.outline;
      const bool clear = circle.in_view && circle.visible_share > 0.98 && t.b_px > 8;
      if (!clear || !found.contains(utime)) continue;
      ++circles;
      for (const auto& ellipse : found[utime].ellipses) {
        const auto& e = ellipse.outer;
        const double away_px = std::hypot(e.u_px - t.u_px, e.v_px - t.v_px);
        if (away_px > 0.2 * t.a_px || std::abs(e.a_px - t.a_px) > 0.1 * t.a_px) continue;
        off_px.push_back(away_px);
        break;
      }
    }
  }
  const double level_deg = percentile(off_level_deg, 0.99), median_px = percentile(off_px, 0.5);
  std::printf(
      "camera off level: %.2f deg p50, %.2f deg p99, of %zu; %zu of %d circles in full view "
      "found, centres %.2f px p50, %.2f px p99 from truth\n",
      percentile(off_level_deg, 0.5), level_deg, off_level_deg.size(), off_px.size(), circles, median_px,
      percentile(off_px, 0.99));
  // half a pixel: a detector that is led astray by what crosses a ring errs by 2; a frame that was not
  // rectified by 14
  const bool level = level_deg >= 0 && level_deg < 3, same_pixels = median_px >= 0 && median_px < 0.5;
  return level && same_pixels ? 0 : 1;
}

int print_targets(const std::string& log, const std::string& pattern) {
  static const std::map<int8_t, const char*> names = {{stevedore::track_t::STATUS_SEARCHING, "searching"},
                                                      {stevedore::track_t::STATUS_TRACKING, "tracking"},
                                                      {stevedore::track_t::STATUS_PREDICTED, "predicted"},
                                                      {stevedore::track_t::STATUS_LOST, "lost"}};
  const auto at = pattern.find("0000");
  if (at == std::string::npos) return 2;
  stevedore::LogReader reader(log);
  while (const auto event = reader.next()) {
    const auto tracks = stevedore::decode(*event, stevedore::channels::tracks);
    if (!tracks) continue;
    const std::string number = std::to_string(tracks->header.frame_seq + 1);
    std::string image = pattern;
    image.replace(at + 4 - number.size(), number.size(), number);
    std::printf(R"({"image":"%s","target":{"status":"%s","id":%lld)", image.c_str(),
                names.at(tracks->target_status), static_cast<long long>(tracks->target_id));
    for (const auto& track : tracks->tracks) {
      const auto& e = track.ellipse.outer;
      if (track.id != tracks->target_id) continue;
      std::printf(R"(,"u":%.4f,"v":%.4f,"a":%.4f,"b":%.4f,"alpha":%.6f)", e.u_px, e.v_px, e.a_px, e.b_px,
                  e.alpha_rad);
    }
    std::printf("}}\n");
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> arguments(argv + 1, argv + argc);
  const auto argument = [&](size_t i, double otherwise) {
    return arguments.size() > i ? std::atof(arguments[i].c_str()) : otherwise;
  };
  if (arguments.size() >= 2 && arguments[0] == "kill")
    return kill_each({arguments.begin() + 1, arguments.end()});
  if (arguments.size() >= 2 && arguments[0] == "wait") {
    return wait_for_channel(arguments[1], static_cast<int64_t>(argument(2, 1)), argument(3, 20));
  }
  if (arguments.size() >= 3 && arguments[0] == "state")
    return wait_for_state(arguments[1], arguments[2], argument(3, 20));
  if (arguments.size() == 3 && arguments[0] == "targets") return print_targets(arguments[1], arguments[2]);
  if (arguments.size() == 2 && arguments[0] == "world") return judge_world(arguments[1]);
  if (arguments.size() == 2 && arguments[0] == "garbage") return send_garbage(argument(1, 1));
  std::fprintf(stderr,
               "usage: probe kill NAME... | wait CHANNEL [N] [SECONDS] | state NAME STATE [SECONDS] | "
               "targets LOG PATTERN | world LOG | garbage SECONDS\n");
  return 2;
}
