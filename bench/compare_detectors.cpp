// What detection costs beside what else could be done with a frame: one table, one run, one core.
#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <functional>
#include <iostream>
#include <nlohmann/json.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/ximgproc/edge_drawing.hpp>

#include "bench/test_images.hpp"
#include "detector_proc/detector.hpp"
#include "geometry/rectify.hpp"

namespace {

using namespace stevedore;
using Clock = std::chrono::steady_clock;

struct Contender {
  std::string name;
  std::function<void(const cv::Mat& image, const Detection* expected)> run;
  bool needs_expected = false;  ///< frames without a mark are left out
};

DetectorSettings with(const std::string& method) {
  DetectorSettings settings;
  settings.method = method;
  return settings;
}

/// The front end of every edge-based detector: the yardstick.
cv::Mat front_end(const cv::Mat& image) {
  cv::Mat grey, blurred, edges;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  cv::GaussianBlur(grey, blurred, {5, 5}, 0);
  cv::Canny(blurred, edges, 50, 150);
  return edges;
}

cv::Mat grey_of(const cv::Mat& image) {
  cv::Mat grey;
  cv::cvtColor(image, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

/// As a barrel lens of 80 degrees needs it, with maps made before.
cv::Mat rectified(const cv::Mat& image) {
  static RectifyMaps maps;
  if (maps.given_size != image.size()) {
    const Pinhole pinhole{image.cols,       image.rows,       0.6 * image.cols,
                          0.6 * image.cols, image.cols / 2.0, image.rows / 2.0};
    CameraModel camera;
    camera.given = camera.rectified = pinhole;
    camera.distortion = Distortion::plumb_bob;
    camera.coefficients = {-0.2, 0.04, 0, 0, 0};
    maps = make_rectify_maps(camera);
  }
  return rectify(image, maps);
}

/// As motion leaves it from one frame to the next.
Detection off_by_a_little(Detection mark) {
  Ellipse& e = mark.outer.ellipse;
  e = {e.u_px + 0.15 * e.b_px, e.v_px - 0.1 * e.b_px, 1.06 * e.a_px, 1.06 * e.b_px, e.alpha_rad + 0.03};
  if (mark.inner) mark.inner->ellipse.a_px *= 1.06, mark.inner->ellipse.b_px *= 1.06;
  return mark;
}

std::vector<Contender> contenders() {
  static const Detector full(with("arcs")), paper(with("paper"));
  DetectorSettings thorough = with("arcs");
  thorough.subpixel_strips = 0;
  static const Detector every_pixel(thorough);
  const auto region = [](const Detector& detector) {
    return [&detector](const cv::Mat& image, const Detection* expected) {
      (void)detector.detect_near(image, off_by_a_little(*expected));
    };
  };
  static const auto drawing = [] {
    auto d = cv::ximgproc::createEdgeDrawing();
    cv::ximgproc::EdgeDrawing::Params parameters;
    parameters.EdgeDetectionOperator = cv::ximgproc::EdgeDrawing::SOBEL;
    d->setParams(parameters);
    return d;
  }();
  return {
      {"front end", [](const cv::Mat& image, const Detection*) { front_end(image); }},
      {"full", [](const cv::Mat& image, const Detection*) { (void)full.detect(image); }},
      {"region", region(full), true},
      {"region, full refit", region(every_pixel), true},
      {"method paper", [](const cv::Mat& image, const Detection*) { (void)paper.detect(image); }},
      {"EdgeDrawing::detectEllipses",
       [](const cv::Mat& image, const Detection*) {
         std::vector<cv::Vec6d> ellipses;
         drawing->detectEdges(grey_of(image));
         drawing->detectEllipses(ellipses);
       }},
      {"memcpy",
       [](const cv::Mat& image, const Detection*) {
         static std::vector<uchar> copy;
         copy.resize(image.total() * image.elemSize());
         std::memcpy(copy.data(), image.data, copy.size());
       }},
      {"rectify", [](const cv::Mat& image, const Detection*) { (void)rectified(image); }},
      {"BGR to grey", [](const cv::Mat& image, const Detection*) { grey_of(image); }},
      {"Sobel",
       [](const cv::Mat& image, const Detection*) {
         cv::Mat du, dv;
         const cv::Mat grey = grey_of(image);
         cv::Sobel(grey, du, CV_16S, 1, 0);
         cv::Sobel(grey, dv, CV_16S, 0, 1);
       }},
      {"Canny",
       [](const cv::Mat& image, const Detection*) {
         cv::Mat edges;
         cv::Canny(grey_of(image), edges, 50, 150);
       }},
  };
}

double share_of(std::vector<double> values, double share) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(share * static_cast<double>(values.size() - 1))];
}

double ms_of(const std::function<void()>& work) {
  const auto start = Clock::now();
  work();
  return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

/// The first circle of each frame, where there is one: what a region is searched for.
std::vector<std::optional<Detection>> expected_marks(const ImageFolder& folder) {
  const Detector detector;
  std::vector<std::optional<Detection>> marks;
  for (const cv::Mat& image : folder.images) {
    const auto found = detector.detect(image);
    const auto circle =
        std::find_if(found.begin(), found.end(), [](const Detection& d) { return d.label == Label::circle; });
    marks.push_back(circle == found.end() ? std::nullopt : std::optional(*circle));
  }
  return marks;
}

/// Every contender on every frame, one frame after the other, so that a machine that slows down does so for
/// all; the best of `repeats` for each frame.
std::vector<std::vector<double>> time_all(const ImageFolder& folder, const std::vector<Contender>& all,
                                          int repeats) {
  const auto expected = expected_marks(folder);
  std::vector<std::vector<double>> times(all.size());
  for (std::size_t i = 0; i < folder.images.size(); ++i) {
    if (i % 50 == 0)
      std::cerr << "\r" << folder.name << ": " << i << " of " << folder.images.size() << std::flush;
    const Detection* mark = expected[i] ? &*expected[i] : nullptr;
    for (std::size_t k = 0; k < all.size(); ++k) {
      if (all[k].needs_expected && !mark) continue;
      double best = 1e9;
      for (int r = 0; r < repeats; ++r)
        best = std::min(best, ms_of([&] { all[k].run(folder.images[i], mark); }));
      times[k].push_back(best);
    }
  }
  std::cerr << "\r" << std::string(60, ' ') << "\r";
  return times;
}

/// Of the first circles of all frames, expected a little off, those that a region search finds again.
void report_region(const ImageFolder& folder) {
  constexpr double near_share = 0.05;  // of a semi-minor axis
  const Detector detector;
  const auto expected = expected_marks(folder);
  int all = 0, again = 0;
  for (std::size_t i = 0; i < folder.images.size(); ++i) {
    if (!expected[i]) continue;
    ++all;
    const Ellipse& e = expected[i]->outer.ellipse;
    const auto found = detector.detect_near(folder.images[i], off_by_a_little(*expected[i]));
    if (!found) continue;
    const Ellipse& f = found->outer.ellipse;
    again += std::hypot(f.u_px - e.u_px, f.v_px - e.v_px) < near_share * e.b_px ? 1 : 0;
  }
  std::printf("  region: %d of %d marks found again\n", again, all);
}

void report(const ImageFolder& folder, int repeats, nlohmann::ordered_json& json) {
  const auto all = contenders();
  const auto times = time_all(folder, all, repeats);
  const double median_ms = share_of(times[0], 0.5), p90_ms = share_of(times[0], 0.9);
  std::printf("\n%s, %zu images          median ms     p90 ms   / front end   / front end's p90\n",
              folder.name.c_str(), folder.images.size());
  for (std::size_t k = 0; k < all.size(); ++k) {
    const double median = share_of(times[k], 0.5), p90 = share_of(times[k], 0.9);
    std::printf("  %-30s %12.4f %10.4f %12.3f %12.3f\n", all[k].name.c_str(), median, p90, median / median_ms,
                p90 / p90_ms);
    json.push_back({{"name", all[k].name},
                    {"folder", folder.name},
                    {"median_ms", median},
                    {"p90_ms", p90},
                    {"ratio_median", median / median_ms},
                    {"ratio_p90", p90 / p90_ms}});
  }
  report_region(folder);
}

void report_sizes(const ImageFolder& folder) {
  std::printf("\n%s, cost against size    full ms   us / kilopixel   / front end\n", folder.name.c_str());
  const Detector detector;
  const std::size_t step = std::max<std::size_t>(1, folder.images.size() / 12);
  for (const cv::Size size : {cv::Size(320, 240), cv::Size(640, 480), cv::Size(1280, 960),
                              cv::Size(1920, 1080), cv::Size(2560, 1440), cv::Size(3840, 2160)}) {
    std::vector<double> full, front;
    for (std::size_t i = 0; i < folder.images.size(); i += step) {
      cv::Mat image;
      cv::resize(folder.images[i], image, size, 0, 0, cv::INTER_LINEAR);
      double best_full = 1e9, best_front = 1e9;
      for (int r = 0; r < 3; ++r) {
        best_front = std::min(best_front, ms_of([&] { front_end(image); }));
        best_full = std::min(best_full, ms_of([&] { (void)detector.detect(image); }));
      }
      full.push_back(best_full);
      front.push_back(best_front);
    }
    const double median = share_of(full, 0.5);
    std::printf("  %4d x %4d %18.3f %16.2f %13.3f\n", size.width, size.height, median,
                1e6 * median / size.area(), median / share_of(front, 0.5));
  }
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  CLI::App app("Times detectors and their floors on image folders: one thread, one table.",
               "compare_detectors");
  std::vector<std::string> folders;
  std::string json_file;
  int repeats = 5;
  bool no_sizes = false;
  app.add_option("FOLDER", folders, "Folders of images, searched to their depth")
      ->required()
      ->check(CLI::ExistingDirectory);
  app.add_option("--json", json_file, "Also write the table to this file");
  app.add_option("--repeats", repeats, "Times each frame is done; the fastest counts")
      ->check(CLI::Range(1, 1000));
  app.add_flag("--no-sizes", no_sizes, "Leave out the cost against size");
  CLI11_PARSE(app, argc, argv);
  auto json = nlohmann::ordered_json::array();
  for (const std::string& path : folders) {
    const ImageFolder folder = load_folder(path);
    if (folder.images.empty()) {
      std::cerr << path << ": no readable image\n";
      return 2;
    }
    report(folder, repeats, json);
    if (!no_sizes) report_sizes(folder);
  }
  if (json_file.empty()) return 0;
  std::ofstream out(json_file);
  out << json.dump(2) << '\n';
  if (!out) std::cerr << json_file << ": not written\n";
  return out ? 0 : 2;
}
