#include "camera_proc/source.hpp"

#include <glob.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <exception>
#include <filesystem>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <set>
#include <utility>

#include "camera_proc/source_thread.hpp"
#include "runtime/frame_ring.hpp"
#include "runtime/time.hpp"

namespace stevedore {
namespace {

namespace fs = std::filesystem;

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

// The run of digits at `at` without leading zeros; moves `at` behind it.
std::string digits(const std::string& text, std::size_t& at) {
  const std::size_t start = at;
  while (at < text.size() && is_digit(text[at])) ++at;
  const std::string run = text.substr(start, at - start);
  return run.substr(std::min(run.find_first_not_of('0'), run.size()));
}

bool has_image_suffix(const fs::path& path) {
  static const std::set<std::string> suffixes = {".pgm",  ".ppm", ".pbm",  ".pnm", ".png", ".jpg",
                                                 ".jpeg", ".tif", ".tiff", ".bmp", ".webp"};
  std::string suffix = path.extension().string();
  std::transform(suffix.begin(), suffix.end(), suffix.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return suffixes.count(suffix) > 0;
}

std::vector<std::string> folder_files(const std::string& folder) {
  std::vector<std::string> files;
  std::error_code error;
  for (fs::directory_iterator i(folder, error), end; !error && i != end; i.increment(error))
    if (std::error_code ignored; i->is_regular_file(ignored) && has_image_suffix(i->path()))
      files.push_back(i->path().string());
  return files;
}

std::vector<std::string> pattern_files(const std::string& pattern) {
  std::vector<std::string> files;
  glob_t found = {};
  if (glob(pattern.c_str(), GLOB_NOSORT, nullptr, &found) == 0)
    for (std::size_t i = 0; i < found.gl_pathc; ++i)
      if (std::error_code ignored; fs::is_regular_file(found.gl_pathv[i], ignored))
        files.emplace_back(found.gl_pathv[i]);
  globfree(&found);
  return files;
}

class ImageFiles : public FrameSource {
 public:
  explicit ImageFiles(std::vector<std::string> files) : files_(std::move(files)) {}

  Grab grab(cv::Mat& image, std::int64_t& /*capture_utime*/) override {
    if (next_ == files_.size()) return Grab::end;
    const std::string& file = files_[next_++];
    try {
      image =
          cv::imread(file, cv::IMREAD_UNCHANGED);  // as stored: no rotation by a camera's note, no 8-bit cut
    } catch (const std::exception&) {
      image.release();
    }
    if (!image.empty()) return Grab::frame;
    fault_ = "can't read image " + file;
    return Grab::failed;
  }
  [[nodiscard]] std::string fault() const override { return fault_; }
  [[nodiscard]] bool is_live() const override { return false; }

 private:
  std::vector<std::string> files_;
  std::size_t next_ = 0;
  std::string fault_;
};

// A video file, a V4L2 device or a GStreamer pipeline.
class Capture : public FrameSource {
 public:
  Capture(const cv::VideoCapture& capture, const CameraSettings& settings)
      : capture_(capture), live_(settings.kind != "video"), v4l2_(settings.kind == "v4l2") {}

  Grab grab(cv::Mat& image, std::int64_t& capture_utime) override {
    image.release();  // its memory may be in use: retrieve() would write into it
    try {
      if (!capture_.grab()) return no_more();
      const std::int64_t now = monotonic_utime();
      if (live_) capture_utime = v4l2_ ? capture_instant(capture_.get(cv::CAP_PROP_POS_MSEC), now) : now;
      if (capture_.retrieve(image) && !image.empty()) return Grab::frame;
      fault_ = "a frame could not be decoded";
    } catch (const std::exception& error) {
      fault_ = error.what();
    }
    return Grab::failed;
  }
  [[nodiscard]] std::string fault() const override { return fault_; }
  [[nodiscard]] bool is_live() const override { return live_; }
  [[nodiscard]] double own_rate_hz() const override {
    const double rate_hz = capture_.get(cv::CAP_PROP_FPS);
    return std::isfinite(rate_hz) && rate_hz > 0 && rate_hz <= 1000 ? rate_hz : 0;
  }

 private:
  Grab no_more() {
    if (!live_) return Grab::end;
    fault_ = "the device gives no more frames";
    return Grab::failed;
  }

  cv::VideoCapture capture_;
  bool live_;
  bool v4l2_;
  std::string fault_;
};

int backend_of(const std::string& kind) {
  if (kind == "v4l2") return cv::CAP_V4L2;
  if (kind == "gstreamer") return cv::CAP_GSTREAMER;
  return cv::CAP_FFMPEG;
}

std::unique_ptr<FrameSource> open_capture(const CameraSettings& settings, std::string& fault) {
  cv::VideoCapture capture;
  try {
    if (capture.open(settings.source, backend_of(settings.kind))) {
      if (settings.kind == "v4l2") {
        if (settings.width_px > 0) capture.set(cv::CAP_PROP_FRAME_WIDTH, settings.width_px);
        if (settings.height_px > 0) capture.set(cv::CAP_PROP_FRAME_HEIGHT, settings.height_px);
        if (settings.rate_hz > 0) capture.set(cv::CAP_PROP_FPS, settings.rate_hz);
      }
      return std::make_unique<Capture>(std::move(capture), settings);
    }
  } catch (const std::exception&) {  // the sentence below says it better
  }
  fault = "can't open " + settings.kind + " source '" + settings.source + "'";
  return nullptr;
}

std::unique_ptr<FrameSource> open_images(const CameraSettings& settings, std::string& fault) {
  auto files = image_files(settings.source);
  if (!files.empty()) return std::make_unique<ImageFiles>(std::move(files));
  fault = "no images at '" + settings.source + "'";
  return nullptr;
}

// What each type of pixel becomes: 8 bits first, then channels.
std::optional<cv::Mat> to_8_bits(const cv::Mat& image, std::string& fault) {
  if (image.depth() == CV_8U) return image;
  if (image.depth() == CV_16U) {
    cv::Mat scaled;
    image.convertTo(scaled, CV_8U, 255.0 / 65535.0);
    return scaled;
  }
  fault = "pixels of type " + cv::typeToString(image.type()) + " are neither 8 nor 16 bits";
  return std::nullopt;
}

}  // namespace

bool natural_less(const std::string& a, const std::string& b) {
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() && j < b.size()) {
    if (is_digit(a[i]) && is_digit(b[j])) {
      const std::string left = digits(a, i);
      const std::string right = digits(b, j);
      if (left.size() != right.size()) return left.size() < right.size();
      if (left != right) return left < right;
    } else if (a[i] != b[j]) {
      return a[i] < b[j];
    } else {
      ++i;
      ++j;
    }
  }
  if (a.size() - i != b.size() - j) return i == a.size();
  return a < b;  // equal but for leading zeros
}

std::vector<std::string> image_files(const std::string& folder_or_pattern) {
  std::error_code ignored;
  std::vector<std::string> files;
  if (fs::is_directory(folder_or_pattern, ignored))
    files = folder_files(folder_or_pattern);
  else if (fs::is_regular_file(folder_or_pattern, ignored))
    files = {folder_or_pattern};  // whatever characters its name has
  else
    files = pattern_files(folder_or_pattern);
  std::sort(files.begin(), files.end(), natural_less);
  return files;
}

std::optional<cv::Mat> to_frame(const cv::Mat& image, const std::string& colour, std::string& fault) {
  constexpr int max_side_px = 32767;
  if (image.dims != 2 || image.empty()) {
    fault = "an empty image";
    return std::nullopt;
  }
  if (image.cols > max_side_px || image.rows > max_side_px || image.total() > max_frame_pixels) {
    fault = "an image of " + std::to_string(image.cols) + "x" + std::to_string(image.rows) +
            " pixels is too large";
    return std::nullopt;
  }
  const int channels = image.channels();
  if (channels != 1 && channels != 3 && channels != 4) {
    fault = "an image of " + std::to_string(channels) + " channels is neither grey nor colour";
    return std::nullopt;
  }
  const auto pixels = to_8_bits(image, fault);
  if (!pixels) return std::nullopt;

  const bool grey = colour == "grey" || (colour == "auto" && channels == 1);
  cv::Mat frame = *pixels;
  if (grey && channels != 1)
    cv::cvtColor(*pixels, frame, channels == 3 ? cv::COLOR_BGR2GRAY : cv::COLOR_BGRA2GRAY);
  else if (!grey && channels != 3)
    cv::cvtColor(*pixels, frame, channels == 1 ? cv::COLOR_GRAY2BGR : cv::COLOR_BGRA2BGR);
  return frame.isContinuous() ? frame : frame.clone();
}

std::int64_t capture_instant(double driver_stamp_ms, std::int64_t now_utime) {
  const double age_ms = static_cast<double>(now_utime) / 1000 - driver_stamp_ms;
  const bool same_clock = age_ms >= 0 && age_ms < 1000;  // false for NaN
  return same_clock ? static_cast<std::int64_t>(driver_stamp_ms * 1000) : now_utime;
}

Opener make_opener(const CameraSettings& settings) {
  if (settings.kind == "images")
    return [settings](std::string& fault) { return open_images(settings, fault); };
  const Opener open = [settings](std::string& fault) { return open_capture(settings, fault); };
  return settings.kind == "video" ? open : threaded(open);
}

}  // namespace stevedore
