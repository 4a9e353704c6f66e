#include "tools/calibrate_run.hpp"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <regex>
#include <stdexcept>

#include "camera_proc/source_camera.hpp"
#include "runtime/camera_file.hpp"
#include "runtime/command_line.hpp"
#include "runtime/process.hpp"
#include "tools/calibrate_coverage.hpp"
#include "tools/calibrate_output.hpp"

namespace stevedore {
namespace {

namespace fs = std::filesystem;

/// Errors fall with the root of their number: from here on another view is hardly worth its time.
constexpr std::size_t most_views = 100;

void say(const std::string& line) {
  std::cout << line << std::endl;  // at once: a person holds the board
}

/// Given each frame; false ends.
using Handler = std::function<bool(const std::string& name, const cv::Mat& grey)>;

CameraSettings source_settings(const std::string& kind, const std::string& source) {
  CameraSettings s;
  s.kind = kind;
  s.source = source;
  s.colour = "grey";
  s.once = true;
  s.paced = false;
  return s;
}

/// Why there was no frame at all; nothing where there was one.
std::optional<std::string> play(const CameraSettings& settings, const std::string& name,
                                const Handler& handle) {
  Camera camera(settings);
  std::string said;
  int frames = 0;
  while (!camera.finished() && !stop_requested()) {
    if (const auto frame = camera.next()) {
      if (!handle(name.empty() ? fmt::format("frame {}", frames++) : name, frame->pixels))
        return std::nullopt;
      continue;
    }
    const CameraStatus status = camera.status();
    if (name.empty() && status.state == CameraStatus::State::failed && status.message != said)
      say(said = status.message);
    camera.wait();
  }
  if (camera.counts().frames > 0 || stop_requested()) return std::nullopt;
  return camera.status().message;
}

void play(const CalibrateOptions& o, const Handler& handle) {
  bool more = true;
  const Handler and_note = [&](const std::string& name, const cv::Mat& grey) {
    return more = handle(name, grey);
  };
  for (const std::string& source : o.images) {
    const auto files = image_files(source);
    if (files.empty()) throw std::runtime_error(source + ": no images there");
    for (const std::string& file : files) {
      if (!more || stop_requested()) return;
      if (const auto fault = play(source_settings("images", file), file, and_note))
        say(file + ": refused: " + *fault);
    }
  }
  std::optional<std::string> fault;
  if (!o.video.empty()) fault = play(source_settings("video", o.video), "", handle);
  if (!o.camera.empty()) {
    const bool is_device = o.camera.find('!') == std::string::npos;
    fault = play(source_settings(is_device ? "v4l2" : "gstreamer", o.camera), "", handle);
  }
  if (fault) throw std::runtime_error(*fault);
}

/// The same reason again, with other numbers.
std::string without_numbers(std::string text) {
  text.erase(std::remove_if(text.begin(), text.end(),
                            [](unsigned char c) { return std::isdigit(c) != 0 || c == '.'; }),
             text.end());
  return text;
}

/// The views taken so far.
class Collection {
 public:
  Collection(const CalibrateOptions& o, bool refuse_similar)
      : board_(o.board), refuse_similar_(refuse_similar), moving_(o.images.empty()) {}

  /// Whether a view was added; says what became of it.
  bool add(const std::string& name, const cv::Mat& grey) {
    if (image_px_.empty()) image_px_ = grey.size();
    if (const auto refusal = refusal_of(name, grey)) {
      const std::string kind = without_numbers(refusal->why);
      if (!moving_ || kind != said_) say(name + ": refused: " + refusal->why);  // a video repeats itself
      said_ = kind;
      return false;
    }
    said_.clear();
    say(fmt::format("{}: taken, {} corners", name, views_.back().ids.size()));
    return true;
  }

  void expect(const cv::Size& image_px) { image_px_ = image_px; }
  [[nodiscard]] const std::vector<View>& views() const { return views_; }
  [[nodiscard]] const cv::Size& image_px() const { return image_px_; }

 private:
  std::optional<Refusal> refusal_of(const std::string& name, const cv::Mat& grey) {
    if (grey.size() != image_px_)
      return Refusal{fmt::format("has {}x{} pixels, not {}x{}", grey.cols, grey.rows, image_px_.width,
                                 image_px_.height)};
    auto seen = look(board_, grey, name);
    if (const auto* refusal = std::get_if<Refusal>(&seen)) return *refusal;
    View& view = std::get<View>(seen);
    if (refuse_similar_)
      if (auto refusal = too_similar(board_, view, views_, image_px_)) return refusal;
    views_.push_back(std::move(view));
    return std::nullopt;
  }

  const Board& board_;
  bool refuse_similar_, moving_;
  cv::Size image_px_;
  std::vector<View> views_;
  std::string said_;
};

std::string today() {
  return fmt::format("{:%Y-%m-%d}", fmt::localtime(std::time(nullptr)));
}

void write(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  if (!file.flush()) throw std::runtime_error(path + ": not written");
}

void write(const std::string& path, const cv::Mat& image) {
  bool written = false;
  try {
    written = cv::imwrite(path, image);
  } catch (const cv::Exception&) {  // a name of no format
  }
  if (!written) throw std::runtime_error(path + ": not written");
}

void say_lens(const Fit& fit) {
  const auto names = parameter_names(fit.camera);
  const Eigen::VectorXd values = parameters(fit.camera);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const int digits = i < 4 ? 2 : 5;
    say(fmt::format("  {} {:>10.{}f} +- {:.{}f}", names[i], values[k], digits,
                    std::sqrt(fit.covariance(k, k)), digits));
  }
}

void say_difference(const Check& c) {
  const auto names = parameter_names(c.as_it_is.camera);
  const Eigen::VectorXd values = parameters(c.as_it_is.camera);
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const int digits = i < 4 ? 2 : 5;
    say(fmt::format("  {} {:>10.{}f} in the file, {:>10.{}f} +- {:.{}f} by these views", names[i], values[k],
                    digits, c.better[k], digits, std::sqrt(c.as_it_is.covariance(k, k)), digits));
  }
}

/// What is missing, given the lens as far as it can be told already.
std::vector<std::string> missing_so_far(const Collection& views, const CalibrateOptions& o, Distortion lens) {
  std::optional<Fit> fitted;
  try {
    if (views.views().size() >= fewest_views) fitted = fit(o.board, views.views(), views.image_px(), lens);
  } catch (const std::runtime_error&) {  // more views will tell
  }
  return missing_views(views.views(), fitted ? &*fitted : nullptr, views.image_px());
}

int make(const CalibrateOptions& o) {
  const Distortion lens = o.lens == "equidistant" ? Distortion::equidistant : Distortion::plumb_bob;
  Collection collection(o, true);
  std::vector<std::string> missing;
  play(o, [&](const std::string& name, const cv::Mat& grey) {
    if (collection.add(name, grey) && !o.camera.empty()) {
      const auto before = missing;
      missing = missing_so_far(collection, o, lens);
      if (missing != before)
        for (const std::string& line : missing) say("  missing: " + line);
      if (missing.empty()) return false;
    }
    return collection.views().size() < most_views;
  });
  missing = missing_views(collection.views(), nullptr, collection.image_px());
  if (collection.views().size() < fewest_views)
    for (const std::string& line : missing) say("missing: " + line);

  std::vector<RefusedView> refused;
  const Fit fitted = fit_without_outliers(o.board, collection.views(), collection.image_px(), lens, refused);
  for (const RefusedView& r : refused) say(r.name + ": refused: " + r.refusal.why);
  std::vector<View> kept;
  for (const FittedView& v : fitted.views) kept.push_back(v.view);
  missing = missing_views(kept, &fitted, collection.image_px());
  for (const std::string& line : missing) say("missing: " + line);
  say(fmt::format("{} views, {} corners, {:.3f} px rms", fitted.views.size(), fitted.corners, fitted.rms_px));
  say_lens(fitted);
  if (fitted.rms_px > most_rms_px)
    say(fmt::format("warning: more than {} px rms: a lens of another kind (--lens), or a bent board",
                    most_rms_px));
  const fs::path out(o.out);
  const std::string picture = fs::path(out).replace_extension(".png").string();
  write(out.string(), calibrated_yaml(fitted, out.stem().string(), today(), missing));
  write(picture, calibration_picture(fitted));
  say("written: " + out.string() + ", " + picture);
  return 0;
}

/// Whether a file with another focal length would not explain these views as well: boards that all face the
/// camera go with any.
bool tells_focal_length(const Fit& fit) {
  constexpr double misfit_share = 0.01;  // a file off by as much must not pass
  const double variance = fit.covariance(0, 0);
  return fit.covariance.allFinite() && variance > 0 &&
         std::sqrt(variance) <= misfit_share * fit.camera.given.fx_px;
}

int hold_against(const CalibrateOptions& o) {
  const CameraFile file = load_camera_file(o.check);
  for (const std::string& warning : file.warnings) std::cerr << warning << '\n';
  Collection collection(o, false);
  collection.expect({file.camera.given.width_px, file.camera.given.height_px});
  play(o, [&](const std::string& name, const cv::Mat& grey) {
    collection.add(name, grey);
    return collection.views().size() < most_views;
  });
  if (collection.views().empty()) throw std::runtime_error("no view to check the file with");
  const Check c = check(o.board, collection.views(), file.camera);
  for (const FittedView& v : c.as_it_is.views) say(fmt::format("{}: {:.3f} px rms", v.view.name, v.rms_px));
  say(fmt::format("all: {:.3f} px rms over {} corners; {:.3f} px with the lens that fits these views best",
                  c.as_it_is.rms_px, c.as_it_is.corners, c.free_rms_px));
  say(fmt::format("the file's share of it: {:.3f} px, at most {:.3f} will do", c.systematic_px,
                  c.allowed_px));
  if (c.free_rms_px > most_rms_px)
    say(fmt::format("no lens of this kind leaves less than {} px rms: another kind, or a bent board",
                    most_rms_px));
  if (!c.fits()) {
    say_difference(c);
    say(o.check + ": does not fit");
    return exit_failed;
  }
  if (!tells_focal_length(c.as_it_is)) {
    for (const std::string& line : missing_views(collection.views(), &c.as_it_is, collection.image_px()))
      say("missing: " + line);
    say(o.check + ": not known: these views would go with other focal lengths as well");
    return exit_failed;
  }
  say(o.check + ": fits");
  return 0;
}

Board stated_board(const CalibrateOptions& o) {
  Board board = o.board;
  board.kind = o.kind == "charuco" ? Board::Kind::charuco : Board::Kind::chessboard;
  std::smatch size;
  if (!std::regex_match(o.corners, size, std::regex(R"((\d{1,2})x(\d{1,2}))")))
    throw UsageError("--corners: \"" + o.corners + "\" is not COLSxROWS, such as 9x6");
  board.corners = {std::stoi(size[1]), std::stoi(size[2])};
  if (board.corners.width < 3 || board.corners.height < 3) throw UsageError("--corners: at least 3x3");
  if (board.kind == Board::Kind::charuco && !(board.marker_m < board.square_m))
    throw UsageError("--marker: must be smaller than --square");
  if (const auto fault = fault_of(board)) throw UsageError("--codes: " + *fault);
  return board;
}

}  // namespace

int calibrate(CalibrateOptions o) {
  o.board = stated_board(o);
  if (!o.print.empty()) {
    constexpr int square_px = 300;  // 30 mm at 254 dots per inch
    write(o.print, draw_board(o.board, square_px));
    return 0;
  }
  const int sources = (o.images.empty() ? 0 : 1) + (o.video.empty() ? 0 : 1) + (o.camera.empty() ? 0 : 1);
  if (sources != 1) throw UsageError("give images, or --video, or --camera");
  stop_on_signals();
  return o.check.empty() ? make(o) : hold_against(o);
}

}  // namespace stevedore
