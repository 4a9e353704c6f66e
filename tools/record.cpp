// Records everything on the bus, with the pixels themselves, into an LCM event log.
#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <filesystem>

#include "runtime/event_log.hpp"
#include "runtime/frame_loss.hpp"
#include "runtime/process.hpp"
#include "runtime/time.hpp"

namespace stevedore {
namespace {

struct Options {
  std::string file = "flight.lcmlog";
  std::string frames = "raw";
  int jpeg_quality = 95;
  double free_floor_mb = 500;
};

/// The name itself, or the first free one with a number: a recorder that was restarted overwrites nothing.
std::string free_name(const std::filesystem::path& wanted) {
  std::filesystem::path name = wanted;
  for (int i = 1; std::filesystem::exists(name); ++i) {
    name =
        wanted.parent_path() / fmt::format("{}.{}{}", wanted.stem().string(), i, wanted.extension().string());
  }
  return name.string();
}

class Recorder {
 public:
  Recorder(const Options& options, LcmBus& bus, FrameReader& frames)
      : options_(options), file_(free_name(options.file)), log_(file_), bus_(bus), frames_(frames) {
    std::apply([this](const auto&... channel) { (subscribe(channel), ...); }, channels::all);
    spdlog::info("recording into {}, frames as {}", file_, options_.frames);
  }

  /// Waits for messages, writes them, and says how it goes.
  Condition work() {
    bus_.handle(50);
    const int64_t now = monotonic_utime();
    if (now - told_utime_ >= tell_period_us && !failure_) tell(now);
    if (failure_) return {health_t::STATE_FAILED, *failure_};
    return {health_t::STATE_OK, fmt::format("{:.1f} MB in {}", megabytes(), file_)};
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
      LogEvent event{clock_utime(CLOCK_REALTIME), channel, encode(message)};
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
      if (image && options_.frames == "raw") encode_raw(image.pixels, frame);
      if (image && options_.frames == "png") encode_png(image.pixels, frame);
      if (image && options_.frames == "jpeg") encode_jpeg(image.pixels, frame, options_.jpeg_quality);
    }
    write<frame_t>(channel, frame);
  }

  [[nodiscard]] double megabytes() const { return static_cast<double>(bytes_) / 1e6; }

  void tell(int64_t now) {
    log_.flush();
    std::error_code error;
    const auto space = std::filesystem::space(std::filesystem::absolute(file_).parent_path(), error);
    const double free_mb = error ? 0 : static_cast<double>(space.available) / 1e6;
    if (told_utime_ != 0) {
      const double minutes = static_cast<double>(now - told_utime_) * 1e-6 / 60;
      spdlog::info("{:.1f} MB, {:.0f} MB/min, {:.1f} GB free", megabytes(),
                   (megabytes() - told_mb_) / minutes, free_mb / 1e3);
    }
    told_utime_ = now;
    told_mb_ = megabytes();
    if (free_mb < options_.free_floor_mb) {
      fail(fmt::format("stopped: {:.0f} MB free, the floor is {:.0f} MB (--free-floor-mb)", free_mb,
                       options_.free_floor_mb));
    }
  }

  void fail(const std::string& why) {
    failure_ = why;
    spdlog::error("{}", why);
  }

  const Options options_;
  const std::string file_;
  LogWriter log_;
  LcmBus& bus_;
  FrameReader& frames_;
  int64_t bytes_ = 0;
  int64_t told_utime_ = 0;
  double told_mb_ = 0;
  std::optional<std::string> failure_;
};

}  // namespace
}  // namespace stevedore

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] {
    stevedore::Options options;
    stevedore::Process process(
        argc, argv, "record", "Records everything on the bus into an LCM event log.",
        [&options](CLI::App& app) {
          app.add_option("--out", options.file, "log to write; an existing one is kept and a number added")
              ->capture_default_str();
          app.add_option("--frames", options.frames, "how ring frames are stored: raw and png are lossless")
              ->check(CLI::IsMember({"raw", "png", "jpeg"}))
              ->capture_default_str();
          app.add_option("--jpeg-quality", options.jpeg_quality)
              ->check(CLI::Range(1, 100))
              ->capture_default_str();
          app.add_option("--free-floor-mb", options.free_floor_mb, "stop recording below this free space")
              ->capture_default_str();
        });
    stevedore::Recorder recorder(options, process.bus(), process.frames());
    return process.run([&recorder] { return recorder.work(); });
  });
}
