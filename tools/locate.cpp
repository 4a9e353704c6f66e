// Detector, tracker and poses for images and image sequences, without a bus: one JSON object a line and
// image.
#include <CLI/CLI.hpp>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <numeric>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>

#include "runtime/camera_file.hpp"
#include "runtime/command_line.hpp"
#include "runtime/config.hpp"
#include "tools/locate_output.hpp"

namespace {

using namespace stevedore;
namespace fs = std::filesystem;

struct Options {
  std::string camera, config, method, track, gravity, overlay;
  std::optional<double> radius_m, cargo_radius_m;
  std::vector<std::string> images;
};

/// CLI::PositiveNumber lets nan and inf pass.
const CLI::Validator length(
    [](const std::string& text) {
      double value = 0;
      std::istringstream number(text);  // reads neither nan nor inf
      const bool good = number >> value && number.peek() == EOF && value > 0;
      return good ? std::string() : text + " is not a positive number";
    },
    "POSITIVE");

void declare(CLI::App& app, Options& o) {
  app.add_option("IMAGE", o.images, "Images; with --track, a sequence in this order, 30 a second")
      ->required();
  app.add_option("--camera", o.camera, "Camera file (ROS camera_info YAML); without it no circle has a pose");
  app.add_option("--radius", o.radius_m, "Radius of a painted circle's outer edge, in metres")->check(length);
  app.add_option("--cargo-radius", o.cargo_radius_m, "Radius of a cargo's rim, in metres")->check(length);
  app.add_option("--gravity", o.gravity,
                 "Down, in the camera frame (x right, y down, z forward), of any length")
      ->type_name("X,Y,Z");
  app.add_option("--config", o.config,
                 "Configuration file: its sections detector, tracker and pose are used");
  app.add_option("--method", o.method, "How poses are found: overrides the configuration")
      ->check(CLI::IsMember({"conic", "four_point"}));
  app.add_option("--track", o.track, "Follow the ellipse at this pixel, or the first circle")
      ->type_name("U,V|first");
  app.add_option("--overlay", o.overlay, "Folder for a picture of each image's result, made if missing")
      ->type_name("DIR");
  app.footer(
      "Prints one JSON object a line and image, nothing else; warnings go to standard error.\n"
      "Lengths are semi-axes in pixels of the image as given, (0, 0) the centre of its upper-left pixel; "
      "alpha\n"
      "is in radians, clockwise from right. Circles are in the camera frame, in metres.\n"
      "\n"
      "  locate --camera config/cameras/world_640x480.yaml --radius 0.5 --track first --overlay out "
      "frames/*.png\n");
}

/// N numbers with commas between them.
template <int N>
std::optional<Eigen::Matrix<double, N, 1>> numbers_of(const std::string& text) {
  std::istringstream rest(text);
  Eigen::Matrix<double, N, 1> numbers;
  for (int k = 0; k < N; ++k)
    if (!(rest >> numbers[k]) || (k + 1 < N && rest.get() != ',')) return std::nullopt;
  return rest.peek() == EOF ? std::optional(numbers) : std::nullopt;
}

std::optional<Eigen::Vector2d> pixel_of(const std::string& track) {
  if (track.empty() || track == "first") return std::nullopt;
  const auto pixel = numbers_of<2>(track);
  if (!pixel) throw UsageError("--track: \"" + track + "\" is neither U,V nor first");
  return pixel;
}

std::optional<Gravity> gravity_of(const std::string& text) {
  if (text.empty()) return std::nullopt;
  const auto down = numbers_of<3>(text);
  if (!down || !down->allFinite() || down->norm() == 0)
    throw UsageError("--gravity: \"" + text + "\" is no direction X,Y,Z");
  return Gravity{down->normalized(), 0};
}

CameraModel camera_of(const std::string& path) {
  CameraFile file = load_camera_file(path);
  for (const auto& warning : file.warnings) std::cerr << warning << '\n';
  return file.camera;
}

LocateSettings settings_of(const Options& o) {
  const Config config = o.config.empty() ? Config{} : Config::load(o.config);
  LocateSettings s;
  s.detector = config.section<DetectorSettings>("detector");
  s.tracker = config.section<TrackerSettings>("tracker");
  s.pose = config.section<PoseSettings>("pose");
  if (!o.method.empty()) s.pose.method = o.method;
  if (!o.camera.empty()) s.camera = camera_of(o.camera);
  s.radius_m = o.radius_m;
  s.cargo_radius_m = o.cargo_radius_m;
  s.gravity = gravity_of(o.gravity);
  s.track = !o.track.empty();
  s.track_pixel = pixel_of(o.track);
  return s;
}

/// 8 bits, grey or BGR, not turned by EXIF: the camera's pixels. Empty if there is no image.
cv::Mat read(const std::string& path) {
  try {
    return cv::imread(path, cv::IMREAD_ANYCOLOR | cv::IMREAD_IGNORE_ORIENTATION);
  } catch (const cv::Exception&) {
    return {};
  }
}

/// Why a file gave no image.
std::string unreadable(const std::string& path) {
  if (fs::is_directory(path)) return "is a folder, not an image";
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::strerror(errno);
  if (file.peek() == std::ifstream::traits_type::eof()) return "an empty file";
  return cv::haveImageReader(path) ? "a damaged image" : "not an image of a format that can be read";
}

void print(const nlohmann::ordered_json& line) {
  std::cout << line.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace) << '\n'
            << std::flush;
  if (!std::cout) throw std::runtime_error("standard output can't be written");
}

/// Numbered, so that images of the same name in two folders both stay, in order.
fs::path overlay_path(const std::string& folder, std::size_t index, const std::string& image) {
  std::ostringstream name;
  name << std::setw(5) << std::setfill('0') << index << '_' << fs::path(image).stem().string() << ".png";
  return fs::path(folder) / name.str();
}

int run(const Options& o) {
  Locator locator(settings_of(o));
  if (!o.overlay.empty()) fs::create_directories(o.overlay);
  int status = 0;
  for (std::size_t i = 0; i < o.images.size(); ++i) {
    const std::string& path = o.images[i];
    const cv::Mat image = read(path);
    const auto refusal = image.empty() ? unreadable(path) : locator.refusal(image);
    if (refusal) {
      print(error_json(path, *refusal));
      status = exit_failed;
      continue;
    }
    const LocatedFrame frame = locator.step(static_cast<int>(i), image);
    print(located_json(path, image.size(), frame));
    if (o.overlay.empty()) continue;
    const fs::path file = overlay_path(o.overlay, i, path);
    if (!cv::imwrite(file.string(), overlay_of(image, frame)))
      throw std::runtime_error(file.string() + ": not written");
  }
  return status;
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  return guarded_main([&] {
    CLI::App app("Finds circles and cargoes in images; says where they are.", "locate");
    Options options;
    declare(app, options);
    parse_command_line(app, argc, argv, "1 if an image could not be read or something not written");
    return run(options);
  });
}
