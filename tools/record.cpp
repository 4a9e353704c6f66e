// Records everything on the bus, with the pixels themselves, into an LCM event log.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "runtime/event_log.hpp"
#include "runtime/frame_loss.hpp"
#include "runtime/process.hpp"
#include "runtime/time.hpp"
#include "tools/record_settings.hpp"

namespace stevedore {
namespace {

/// The name itself, or the first free one with a number: a recorder that was restarted overwrites nothing.
std::string free_name(const std::filesystem::path& wanted) {
  if (std::filesystem::is_directory(wanted))
    throw UsageError("--out " + wanted.string() + ": is a folder; name a file in it");
  std::filesystem::path name = wanted;
  for (int i = 1; std::filesystem::exists(name); ++i) {
    name =
        wanted.parent_path() / fmt::format("{}.{}{}", wanted.stem().string(), i, wanted.extension().string());
  }
  return name.string();
}

class Recorder {
 public:
  Recorder(const RecordSettings& settings, const std::string& file, LcmBus& bus, FrameReader& frames)
      : settings_(settings), file_(free_name(file)), log_(file_), bus_(bus), frames_(frames) {
    std::apply([this](const auto&... channel) { (subscribe(channel), ...); }, channels::all);
    spdlog::info("recording into {}, frames as {}", file_, settings_.frames);
  }

  /// Waits for messages, writes them, and says how it goes.
  Condition work() {
    bus_.handle(50);
    const int64_t now = monotonic_utime();
    if (now - told_utime_ >= tell_period_us && !failure_) tell(now);
    if (failure_) return {health_t::STATE_FAILED, *failure_};
    return {health_t::STATE_OK, fmt::format("{:.1f} MB in {}", megabytes(), file_)};
  }

  /// Whether everything that was heard is in the log.
  bool finish() {
    if (!failure_) flush();
    return !failure_;
  }

 private:
  static constexpr int64_t tell_period_us = 5'000'000;

  template <class M>
  void subscribe(const Channel<M>& channel) {
    if (!channel.logged) return;
    bus_.subscribe<M>(channel,
                      [this, name = std::string(channel.name)](const M& message) { write(name, message); });
  }

  template <class M>
  void write(const std::string& channel, const M& message) {
    if (failure_) return;
    try {
      LogEvent event{utc_.now(), channel, encode(message)};
      bytes_ += static_cast<int64_t>(event.bytes.size());
      log_.write(event);
    } catch (const std::runtime_error& error) {
      fail(error.what());
    }
  }

  void write(const std::string& channel, const frame_t& notice) {
    frame_t frame = notice;
    if (frame.encoding == frame_t::ENCODING_RING) {
      const FrameImage image = frames_.image(notice);
      count_frame_loss(bus_, image.fault);
      if (image && settings_.frames == "raw") encode_raw(image.pixels, frame);
      if (image && settings_.frames == "png") encode_png(image.pixels, frame);
      if (image && settings_.frames == "jpeg") encode_jpeg(image.pixels, frame, settings_.jpeg_quality);
    }
    write<frame_t>(channel, frame);
  }

  [[nodiscard]] double megabytes() const { return static_cast<double>(bytes_) / 1e6; }

  /// What is still in memory; on a full disk the last there is to say.
  void flush() {
    try {
      log_.flush();
    } catch (const std::runtime_error& error) {
      fail(error.what());
    }
  }

  void tell(int64_t now) {
    flush();
    std::error_code error;
    const auto space = std::filesystem::space(std::filesystem::absolute(file_).parent_path(), error);
    if (error) {  // the folder was moved, or a server is slow: whatever it is, no full disk
      spdlog::warn("how much is free can't be told: {}", error.message());
      return;
    }
    const double free_mb = static_cast<double>(space.available) / 1e6;
    if (told_utime_ != 0) {
      const double minutes = static_cast<double>(now - told_utime_) * 1e-6 / 60;
      spdlog::info("{:.1f} MB, {:.0f} MB/min, {:.1f} GB free", megabytes(),
                   (megabytes() - told_mb_) / minutes, free_mb / 1e3);
    }
    told_utime_ = now;
    told_mb_ = megabytes();
    if (!failure_ && free_mb < settings_.free_floor_mb) {
      fail(fmt::format("stopped: {:.0f} MB free, the floor is {:.0f} MB (record.free_floor_mb)", free_mb,
                       settings_.free_floor_mb));
    }
  }

  void fail(const std::string& why) {
    failure_ = why;
    spdlog::error("{}", why);
  }

  const RecordSettings settings_;
  const std::string file_;
  LogWriter log_;
  LcmBus& bus_;
  FrameReader& frames_;
  const SteadyUtc utc_;
  int64_t bytes_ = 0;
  int64_t told_utime_ = 0;
  double told_mb_ = 0;
  std::optional<std::string> failure_;
};

}  // namespace
}  // namespace stevedore

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] {
    std::string file = "flight.lcmlog";
    std::optional<std::string> frames;
    std::optional<int> jpeg_quality;
    std::optional<double> free_floor_mb;
    stevedore::Process process(
        argc, argv, "record", "Records everything on the bus into an LCM event log.", [&](CLI::App& app) {
          app.add_option("--out", file, "log to write; an existing one is kept and a number added")
              ->capture_default_str();
          app.add_option(
                 "--frames", frames,
                 "how ring frames are stored, over record.frames: raw (the default) and png are lossless, "
                 "for replay to the bit; jpeg for lcm-logplayer, which loses larger frames with the "
                 "kernel's usual receive buffer")
              ->check(CLI::IsMember({"raw", "png", "jpeg"}));
          app.add_option("--jpeg-quality", jpeg_quality, "over record.jpeg_quality [95]")
              ->check(CLI::Range(1, 100));
          app.add_option("--free-floor-mb", free_floor_mb,
                         "stop recording below this free space, over record.free_floor_mb [500]")
              ->check(CLI::Range(0.0, 1e6));
        });
    auto settings = process.settings<stevedore::RecordSettings>("record");
    settings.frames = frames.value_or(settings.frames);
    settings.jpeg_quality = jpeg_quality.value_or(settings.jpeg_quality);
    settings.free_floor_mb = free_floor_mb.value_or(settings.free_floor_mb);
    stevedore::Recorder recorder(settings, file, process.bus(), process.frames());
    const int status = process.run([&recorder] { return recorder.work(); });
    return recorder.finish() ? status : stevedore::exit_failed;
  });
}
