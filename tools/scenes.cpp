// Pictures of the competition with their exact truth: to check a detector on what it will meet.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>
#include <regex>
#include <thread>

#include "runtime/camera_file.hpp"
#include "runtime/command_line.hpp"
#include "sim_proc/world/renderer.hpp"
#include "tools/camera_yaml.hpp"
#include "tools/contact_sheet.hpp"
#include "tools/flight_film.hpp"
#include "tools/progress_line.hpp"
#include "tools/still_truth.hpp"

namespace {

using namespace stevedore;
namespace fs = std::filesystem;

struct Options {
  int count = 0;
  double film_s = 0, rate_hz = 15, start_s = 0;
  int sea_state = 2;
  std::uint64_t seed = 1;
  std::string out, camera, size, sheet;
  bool linear = false, noise_free = false, exact = false, overlay = false;
  int threads = 0;
};

void declare(CLI::App& app, Options& o) {
  auto* count = app.add_option("--count", o.count, "How many stills")->check(CLI::Range(1, 100000));
  auto* film =
      app.add_option("--film", o.film_s, "Instead of stills a flight of so many seconds, frame by frame")
          ->check(CLI::Range(0.01, 3600.0))
          ->excludes(count);
  app.add_option("--rate", o.rate_hz, "Of a film: frames a second")
      ->check(CLI::Range(0.1, 200.0))
      ->capture_default_str()
      ->needs(film);
  app.add_option("--start", o.start_s, "Of a film: second of the flight with which it begins")
      ->check(CLI::Range(0.0, 3600.0))
      ->capture_default_str()
      ->needs(film);
  app.add_option("--sea-state", o.sea_state, "Of a film: 0 (calm) to 4")
      ->check(CLI::Range(0, 4))
      ->capture_default_str()
      ->needs(film);
  app.add_option("--seed", o.seed, "The same seed makes the same pictures, to the byte")
      ->capture_default_str();
  app.add_option("--out", o.out, "Folder for images, truth.jsonl and camera.yaml, made if missing")
      ->required()
      ->type_name("DIR");
  app.add_option("--camera", o.camera, "Camera file; without it the paper's: 640x480, 87 x 71 degrees");
  app.add_option("--size", o.size, "Another number of pixels for the same view")->type_name("WxH");
  app.add_flag("--linear", o.linear, "Grey levels proportional to light, whatever the camera file says");
  app.add_flag("--noise-free", o.noise_free, "No sensor noise");
  auto* exact = app.add_flag("--exact", o.exact,
                             "The camera is what camera.yaml says, the circles what they are told to be");
  exact->excludes(film);
  app.add_flag("--overlay", o.overlay, "Also each image with its truth drawn on, in DIR/overlay");
  app.add_option("--sheet", o.sheet,
                 "Also all of them small on one JPEG of less than 400 kB, every third with its truth")
      ->type_name("FILE");
  app.add_option("--threads", o.threads, "0: as many as there are processors; pictures do not depend on it")
      ->check(CLI::Range(0, 256));
  app.footer(
      "Each still has another scenery, light, sea, layout and height (1.5 to 12 m over the deck).\n"
      "truth.jsonl has a line for each image: `ellipses` are the circles of which at least a quarter of the\n"
      "edge is seen, with a semi-minor axis of at least 4 px, `hidden` the rest of those in the image, each\n"
      "the exact outer edge in pixels of the image, and its centre, normal and radius in the camera frame;\n"
      "`cargoes` the rims of buckets; `gravity` down in the camera frame. Unless --exact, the camera and "
      "the\n"
      "radius differ a little from what camera.yaml and a radius of 0.5 m say, as on a real aircraft.\n\n"
      "A film is flown by a script that knows the way: take-off, search from 12 m, and after 70 to 95 s\n"
      "descents to 1 m over both platforms by turns. Its lines have besides: `time` and `stamp` (what the\n"
      "camera's driver says, late by a constant), the newest readings of the sensors (`vehicle`, `gimbal`,\n"
      "`altimeter`, `hook`), and where aircraft, camera, hook and both platforms really were. `platform` "
      "and\n"
      "`slot` of a circle stay with it, so that mistaken identities can be counted.\n\n"
      "  scenes --count 200 --seed 1 --out s\n"
      "  scenes --film 60 --rate 10 --sea-state 3 --seed 7 --out f\n"
      "  locate --camera s/camera.yaml --radius 0.5 --cargo-radius 0.16 s/*.png > found.jsonl");
}

CameraModel paper_camera() {
  CameraModel camera;
  camera.given = camera.rectified = {640, 480, 337, 337, 319.5, 239.5};  // 87 x 71 degrees
  return camera;
}

CameraModel told_camera(const Options& o) {
  CameraModel camera = paper_camera();
  if (!o.camera.empty()) {
    CameraFile file = load_camera_file(o.camera);
    for (const auto& warning : file.warnings) std::cerr << warning << '\n';
    camera = file.camera;
  }
  if (!o.size.empty()) {
    std::smatch size;
    const std::regex form(R"((\d{2,4})x(\d{2,4}))");
    if (!std::regex_match(o.size, size, form))
      throw UsageError("--size: \"" + o.size + "\" is not WxH, such as 1280x960");
    camera = resized(camera, std::stoi(size[1]), std::stoi(size[2]));
  }
  if (o.linear) camera.response = {Response::Curve::linear, 1};
  return camera;
}

void write(const fs::path& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  if (!file.flush()) throw std::runtime_error(path.string() + ": not written");
}

void write(const fs::path& path, const cv::Mat& image) {
  if (!cv::imwrite(path.string(), image)) throw std::runtime_error(path.string() + ": not written");
}

void write_sheet(const Options& o, const std::vector<cv::Mat>& pictures) {
  constexpr int columns = 6, width_px = 280;
  constexpr size_t most_bytes = 390'000;
  write_jpeg(o.sheet, contact_sheet(pictures, columns, width_px), most_bytes);
}

/// Draws the frames one by one, writes them and their truth.
class Album {
 public:
  Album(const Options& o, const CameraModel& told) : o_(o), out_(o.out), renderer_(threads_of(o)) {
    fs::create_directories(o.overlay ? out_ / "overlay" : out_);
    write(out_ / "camera.yaml", camera_yaml(told, "scenes"));
  }

  template <class Frame>
  void add(world::Scene& scene, const Frame& frame, int of) {
    if (o_.noise_free) scene.eye.noise_levels = 0;
    const cv::Mat picture = renderer_.render(scene);
    const std::string name = fmt::format("{}_{:04}", o_.film_s > 0 ? "frame" : "scene", number_);
    const auto truth = truth_of(frame, name + ".png", "camera.yaml");
    truth_lines_ += truth.dump() + '\n';
    write(out_ / (name + ".png"), picture);
    if (o_.overlay) write(out_ / "overlay" / (name + ".png"), with_truth(picture, truth));
    if (!o_.sheet.empty()) sheet_.push_back(number_ % 3 == 2 ? with_truth(picture, truth) : picture);
    ++number_;
    if (progress_.on_terminal() || number_ == of)
      progress_.show(fmt::format("{} of {} pictures in {}", number_, of, o_.out));
  }

  void finish() {
    write(out_ / "truth.jsonl", truth_lines_);
    if (!o_.sheet.empty()) write_sheet(o_, sheet_);
  }

 private:
  static int threads_of(const Options& o) {
    return o.threads ? o.threads : static_cast<int>(std::thread::hardware_concurrency());
  }

  const Options& o_;
  const fs::path out_;
  world::Renderer renderer_;
  ProgressLine progress_;
  int number_ = 0;
  std::string truth_lines_;
  std::vector<cv::Mat> sheet_;
};

void make_stills(const Options& o) {
  const StillCamera camera = draw_still_camera(told_camera(o), o.seed, o.exact);
  Album album(o, camera.told);
  for (int i = 0; i < o.count; ++i) {
    Still still = draw_still(camera, o.seed, i);
    album.add(still.scene, still, o.count);
  }
  album.finish();
}

void make_film(const Options& o) {
  world::WorldSettings settings;
  settings.seed = o.seed;
  settings.sea_state = o.sea_state;
  settings.camera = told_camera(o);
  Album album(o, settings.camera);
  FlightFilm film(settings, o.rate_hz, o.start_s);
  const int count = std::max(1, static_cast<int>(std::lround(o.film_s * o.rate_hz)));
  for (int i = 0; i < count; ++i) {
    FilmFrame frame = film.next();
    album.add(frame.still.scene, frame, count);
  }
  album.finish();
}

void run(const Options& o) {
  if (o.count == 0 && o.film_s <= 0) throw UsageError("give --count for stills or --film for a flight");
  o.film_s > 0 ? make_film(o) : make_stills(o);
}

}  // namespace

int main(int argc, char** argv) {
  return guarded_main([&] {
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);  // what fails is said below
    CLI::App app("Makes pictures of the competition with their exact truth.", "scenes");
    Options options;
    declare(app, options);
    parse_command_line(app, argc, argv, "1 if a file could not be written");
    run(options);
    return 0;
  });
}
