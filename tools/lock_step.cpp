#include "tools/lock_step.hpp"

#include <set>
#include <stdexcept>
#include <utility>

#include "detector_proc/detector_stage.hpp"
#include "gimbal_proc/gimbal_stage.hpp"
#include "mission_proc/mission_stage.hpp"
#include "pose_proc/pose_stage.hpp"
#include "runtime/camera_file.hpp"
#include "tracker_proc/tracker_stage.hpp"

namespace stevedore {
namespace {

constexpr std::int64_t start_utime = 1'000'000'000;
constexpr std::int64_t step_us = 5'000;

}  // namespace

class LockStep::StageBus final : public Bus {
 public:
  StageBus(std::int64_t run_id, LockStep& flight) : Bus(run_id), flight_(flight) {}
  void deliver(const LogEvent& event) {
    if (heard_.contains(event.channel)) receive(event.channel, event.bytes.data(), event.bytes.size());
  }

 private:
  [[nodiscard]] std::int64_t now_utime() const override { return flight_.now_utime_; }
  void transmit(const std::string& channel, const std::vector<std::uint8_t>& bytes) override {
    flight_.queue_.push_back({flight_.now_utime_, channel, bytes});
  }
  void listen(const std::string& channel) override { heard_.insert(channel); }

  LockStep& flight_;
  std::set<std::string> heard_;
};

struct LockStep::Stage {
  Stage(std::int64_t run_id, LockStep& flight) : bus(run_id, flight) {}
  StageBus bus;
  FrameReader frames;
  std::shared_ptr<void> code;
};

LockStep::LockStep(const Config& config, const std::string& ring_name, Sink sink)
    : config_(config), sink_(std::move(sink)), now_utime_(start_utime) {
  const auto camera = camera_of(config);
  if (!camera) throw ConfigError("the world needs a camera: camera_file, as in config/world.yaml");
  for (std::int64_t run_id = 1; run_id <= 5; ++run_id)
    stages_.push_back(std::make_unique<Stage>(run_id, *this));
  Stage &gimbal = *stages_[0], &detector = *stages_[1], &tracker = *stages_[2], &pose = *stages_[3];
  gimbal.code =
      std::make_shared<GimbalStage>(config.section<GimbalSettings>("gimbal"), camera->mount, gimbal.bus);
  detector.code = std::make_shared<DetectorStage>(config.section<DetectorSettings>("detector"), camera,
                                                  detector.bus, detector.frames, Delivery::every);
  tracker.code = std::make_shared<TrackerStage>(config.section<TrackerSettings>("tracker"), camera,
                                                tracker.bus, tracker.frames);
  pose.code = std::make_shared<PoseStage>(config.section<PoseSettings>("pose"), camera, pose.bus,
                                          config.section<PlatformSettings>("platform"));
  make_mission();
  sim_bus_ = std::make_unique<StageBus>(6, *this);
  sim_ = std::make_unique<SimStage>(config.section<SimSettings>("sim"), *camera, ring_name, *sim_bus_);
}

LockStep::~LockStep() = default;

void LockStep::make_mission() {
  Stage& stage = *stages_[4];
  stage.code =
      std::make_shared<MissionStage>(config_.section<MissionSettings>("mission"), stage.bus, journal_,
                                     [this](const mission_journal_t& line) { journal_ = line; });
}

void LockStep::kill_mission(double away_s) {
  stages_[4] = std::make_unique<Stage>(now_utime_, *this);
  mission_back_utime_ = now_utime_ + static_cast<std::int64_t>(away_s * 1e6);
}

double LockStep::time_s() const {
  return static_cast<double>(now_utime_ - start_utime) * 1e-6;
}

void LockStep::fly(double seconds) {
  for (const std::int64_t until = now_utime_ + static_cast<std::int64_t>(seconds * 1e6); now_utime_ < until;)
    step();
}

void LockStep::step() {
  now_utime_ += step_us;
  if (!stages_[4]->code && now_utime_ >= mission_back_utime_) make_mission();
  sim_->work(now_utime_);
  const Condition condition = sim_->finish_drawing();
  if (condition.state == health_t::STATE_FAILED) throw std::runtime_error("the world: " + condition.message);
  exchange();
}

void LockStep::exchange() {
  while (!delayed_.empty() && delayed_.front().utime + frame_latency_us <= now_utime_) {
    hand_out(delayed_.front());
    delayed_.pop_front();
  }
  while (!queue_.empty()) {
    LogEvent event = std::move(queue_.front());
    queue_.pop_front();
    if (passes && !passes(event)) continue;
    if (event.channel == channels::frame.name)
      delayed_.push_back(std::move(event));
    else
      hand_out(event);
  }
}

void LockStep::hand_out(const LogEvent& event) {
  if (sink_) sink_(event);
  if (const auto mission = decode(event, channels::mission)) mission_ = *mission;
  if (const auto truth = decode(event, channels::truth)) truth_ = *truth;
  for (const auto& stage : stages_) stage->bus.deliver(event);
  sim_bus_->deliver(event);
}

}  // namespace stevedore
