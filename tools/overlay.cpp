#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "lcmtypes/names.hpp"
#include "runtime/event_log.hpp"
#include "runtime/frame_codec.hpp"
#include "runtime/process.hpp"
#include "tools/draw.hpp"
#include "tools/progress_line.hpp"

namespace {

using namespace stevedore;
namespace fs = std::filesystem;

/// What the messages of one frame say, as far as it is drawn or written.
struct Notes {
  std::vector<Ellipse> ellipses;
  std::optional<Ellipse> target;
  std::optional<Ellipse> window;
  int64_t target_id = -1;
  int8_t target_status = 0;
  std::optional<double> range_m;
  std::optional<int8_t> phase;
  std::string emergencies;
};

/// A log's small messages by the capture time of their frame; the pixels stay in the file.
struct LogIndex {
  std::map<int64_t, Notes> notes;
  std::vector<int64_t> frame_utimes;  ///< of frames whose pixels are in the log
  int64_t references = 0;             ///< frames that point into a ring
  int64_t unreadable = 0;             ///< messages on FRAME that are no frames of this version
};

Ellipse ellipse_of(const ellipse_shape_t& e) {
  return {e.u_px, e.v_px, e.a_px, e.b_px, e.alpha_rad};
}

void note(const ellipses_t& message, Notes& notes) {
  for (const auto& ellipse : message.ellipses) notes.ellipses.push_back(ellipse_of(ellipse.outer));
}

void note(const tracks_t& message, Notes& notes) {
  notes.target_id = message.target_id;
  notes.target_status = message.target_status;
  for (const auto& track : message.tracks) {
    if (track.id == message.target_id) notes.target = ellipse_of(track.ellipse.outer);
  }
  if (message.has_window) {
    notes.window = Ellipse{message.window_u_px, message.window_v_px, message.window_a_px, message.window_b_px,
                           message.window_alpha_rad};
  }
}

void note(const poses_t& message, Notes& notes) {
  for (const auto& pose : message.poses) {
    if (!pose.is_target || pose.solutions.empty()) continue;
    const double* center = pose.solutions.front().center_camera_m;
    notes.range_m = std::hypot(center[0], center[1], center[2]);
  }
}

void note(const mission_t& message, Notes& notes) {
  notes.phase = message.phase;
  for (const auto& emergency : message.emergencies) {
    notes.emergencies +=
        fmt::format("{}{}", notes.emergencies.empty() ? "" : ", ", emergency_name(emergency.kind));
  }
}

template <class M>
void note_event(const LogEvent& event, const Channel<M>& channel, LogIndex& index) {
  const auto message = decode(event, channel);
  if (message && message->header.frame_seq >= 0) note(*message, index.notes[message->header.utime]);
}

LogIndex read_index(const std::string& log) {
  LogIndex index;
  LogReader reader(log);
  while (const auto event = reader.next()) {
    if (const auto frame = decode(*event, channels::frame)) {
      if (frame->encoding == frame_t::ENCODING_RING) {
        ++index.references;
      } else {
        index.frame_utimes.push_back(frame->header.utime);
      }
      continue;
    }
    if (event->channel == channels::frame.name) ++index.unreadable;
    note_event(*event, channels::ellipses, index);
    note_event(*event, channels::tracks, index);
    note_event(*event, channels::poses, index);
    note_event(*event, channels::mission, index);
  }
  return index;
}

/// Of the camera: the median of the times between frames, so that pauses don't count.
double rate_of(const std::vector<int64_t>& frame_utimes) {
  constexpr double unknown_hz = 10, lowest_hz = 1, highest_hz = 240;  // what players play
  std::vector<int64_t> intervals_us;
  for (size_t i = 1; i < frame_utimes.size(); ++i) {
    const int64_t interval_us = frame_utimes[i] - frame_utimes[i - 1];
    if (interval_us > 0) intervals_us.push_back(interval_us);
  }
  if (intervals_us.empty()) return unknown_hz;
  const auto middle = intervals_us.begin() + static_cast<std::ptrdiff_t>(intervals_us.size() / 2);
  std::nth_element(intervals_us.begin(), middle, intervals_us.end());
  return std::clamp(1e6 / static_cast<double>(*middle), lowest_hz, highest_hz);
}

std::vector<std::string> caption_of(int64_t frame_seq, const Notes& notes) {
  std::string first = fmt::format("frame {}   {} ellipses   target ", frame_seq, notes.ellipses.size());
  first += notes.target_status == 0 ? "-" : status_name(notes.target_status);
  if (notes.target_id >= 0) first += fmt::format(" #{}", notes.target_id);
  if (notes.range_m) first += fmt::format(" at {:.2f} m", *notes.range_m);
  std::string second = fmt::format("mission {}", notes.phase ? phase_name(*notes.phase) : "-");
  if (!notes.emergencies.empty()) second += "   ! " + notes.emergencies;
  return {first, second};
}

cv::Mat drawn(const cv::Mat& pixels, int64_t frame_seq, const Notes& notes) {
  Canvas canvas(pixels);
  for (const Ellipse& ellipse : notes.ellipses) canvas.ellipse(ellipse, cyan);
  if (notes.target && notes.target_status == track_t::STATUS_TRACKING)
    canvas.ellipse(*notes.target, green, 3);
  if (notes.target && notes.target_status == track_t::STATUS_PREDICTED) {
    canvas.dashed_ellipse(*notes.target, green, 2);
  }
  if (notes.window) canvas.ellipse(*notes.window, yellow);  // thin, on top: it is often right on the target
  canvas.caption(caption_of(frame_seq, notes));
  return canvas.image();
}

/// A video that is opened when the size of its images is known.
class Video {
 public:
  Video(fs::path path, double rate_hz) : path_(std::move(path)), rate_hz_(rate_hz) {
    const std::string extension = path_.extension().string();
    if (extension != ".mp4" && extension != ".avi") {
      throw std::runtime_error(path_.string() + ": name a file that ends in .mp4 (or .avi)");
    }
    std::error_code ignored;  // the file says whether the folder is there
    if (path_.has_parent_path()) fs::create_directories(path_.parent_path(), ignored);
    if (!std::ofstream(path_)) throw std::runtime_error(path_.string() + ": can't be written");
  }

  void write(const cv::Mat& image) {
    if (!writer_.isOpened()) open(image.size());
    cv::Mat fitted = image;
    if (image.size() != size_) cv::resize(image, fitted, size_);  // the camera changed its mode
    writer_.write(fitted);
  }
  void finish() { writer_.release(); }
  [[nodiscard]] const fs::path& path() const { return path_; }

 private:
  void open(cv::Size size) {
    size_ = size;
    if (path_.extension() == ".mp4") {
      if (writer_.open(path_.string(), cv::VideoWriter::fourcc('m', 'p', '4', 'v'), rate_hz_, size)) return;
      fs::remove(path_);
      path_.replace_extension(".avi");
      fmt::print(stderr, "OpenCV has no MPEG-4 encoder here: writing {} as Motion JPEG instead.\n",
                 path_.string());
    }
    if (!writer_.open(path_.string(), cv::VideoWriter::fourcc('M', 'J', 'P', 'G'), rate_hz_, size)) {
      throw std::runtime_error(path_.string() + ": OpenCV can write neither MPEG-4 nor Motion JPEG video");
    }
  }

  fs::path path_;
  double rate_hz_;
  cv::Size size_;
  cv::VideoWriter writer_;
};

struct Options {
  std::string log, out, frames;
  int64_t every = 1;
};

struct Written {
  int64_t images = 0;
  int64_t undecodable = 0;
};

void write_png(const fs::path& folder, int64_t number, const cv::Mat& image) {
  const fs::path path = folder / fmt::format("frame-{:06}.png", number);
  if (!cv::imwrite(path.string(), image)) throw std::runtime_error(path.string() + ": can't be written");
}

Written write_images(const Options& options, const LogIndex& index, std::optional<Video>& video) {
  // elsewhere than on a terminal a line now and then is enough
  ProgressLine progress;
  const int64_t told_every = progress.on_terminal() ? 25 : 1000;
  const Notes nothing;
  Written written;
  FrameReader frames;
  LogReader reader(options.log);
  int64_t number = 0;
  while (const auto event = reader.next()) {
    const auto frame = decode(*event, channels::frame);
    if (!frame || frame->encoding == frame_t::ENCODING_RING) continue;
    if (number % told_every == 0 && number > 0) {
      progress.show(fmt::format("frame {} of {}", number, index.frame_utimes.size()));
    }
    if (number++ % options.every != 0) continue;
    const FrameImage image = frames.image(*frame);
    if (!image) {
      ++written.undecodable;
      continue;
    }
    const auto notes = index.notes.find(frame->header.utime);
    const cv::Mat picture =
        drawn(image.pixels, frame->header.frame_seq, notes == index.notes.end() ? nothing : notes->second);
    if (video) video->write(picture);
    if (!options.frames.empty()) write_png(options.frames, number - 1, picture);
    ++written.images;
  }
  if (video) video->finish();
  return written;
}

/// What the log should hold and does not; empty when there is nothing to say.
std::string shortcomings(const LogIndex& index) {
  std::string text;
  if (index.references > 0) {
    text += fmt::format(
        "{} frames are references to shared memory that is gone: their pixels are not in the log.\n"
        "Write logs with `record`, which takes the pixels from there, or start the set with inline\n"
        "frames (camera.transport=jpeg).\n",
        index.references);
  }
  if (index.unreadable > 0) {
    text += fmt::format("{} frames can't be read: damaged, or of another version.\n", index.unreadable);
  }
  return text;
}

int overlay(const Options& options) {
  const LogIndex index = read_index(options.log);
  fmt::print(stderr, "{}", shortcomings(index));
  if (index.frame_utimes.empty()) throw std::runtime_error(options.log + ": there is no frame to draw on");

  const double rate_hz = rate_of(index.frame_utimes) / static_cast<double>(options.every);
  std::optional<Video> video;
  if (!options.out.empty()) video.emplace(options.out, rate_hz);
  if (!options.frames.empty()) fs::create_directories(options.frames);
  const Written written = write_images(options, index, video);
  if (written.undecodable > 0)
    fmt::print(stderr, "{} frames can't be decoded and are left out.\n", written.undecodable);
  if (written.images == 0) {
    if (video) fs::remove(video->path());
    throw std::runtime_error(options.log + ": no frame in it can be decoded");
  }
  if (video) fmt::print("{}: {} frames at {:.1f}/s\n", video->path().string(), written.images, rate_hz);
  if (!options.frames.empty()) fmt::print("{}: {} PNG files\n", options.frames, written.images);
  return 0;
}

int run(int argc, char** argv) {
  CLI::App app("Draws what the vision saw on the frames of a log: a video, single frames, or both.",
               "overlay");
  Options options;
  app.add_option("LOG", options.log, "a log with the frames' pixels, as record writes it")
      ->required()
      ->check(CLI::ExistingFile);
  app.add_option("--out", options.out, "video to write, FILE.mp4 (or FILE.avi: Motion JPEG)");
  app.add_option("--frames", options.frames, "folder for the frames as PNG files");
  app.add_option("--every", options.every, "take only every Nth frame")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  app.set_version_flag("--version", version());
  app.footer(
      "Cyan: every ellipse. Green: the target; thick when it was measured, dashed when predicted.\n"
      "Yellow: CAMShift's window. Frames narrower than 640 pixels are enlarged twofold.");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? 0 : 2;
  }
  if (options.out.empty() && options.frames.empty()) {
    fmt::print(stderr, "Say what to write: --out FILE.mp4, --frames DIR, or both.\n");
    return 2;
  }
  return overlay(options);
}

}  // namespace

int main(int argc, char** argv) {
  return stevedore::guarded_main([&] { return run(argc, argv); });
}
