// Copies of image folders as a worse camera would have taken them, for scoring what detection stands.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

struct Degradation {
  double contrast = 1, noise = 0, blur_px = 0, scale = 1;
  int jpeg_quality = 0;  ///< 0: none
};

const std::map<std::string, Degradation> degradations = {
    {"contrast", {.contrast = 0.3}}, {"noise", {.noise = 15}}, {"blur", {.blur_px = 2.5}},
    {"jpeg", {.jpeg_quality = 40}},  {"x2", {.scale = 2}},     {"x4", {.scale = 4}},
    {"half", {.scale = 0.5}},
};

cv::Mat degraded(cv::Mat image, const Degradation& d, cv::RNG& random) {
  if (d.scale != 1) {
    cv::resize(image, image, {}, d.scale, d.scale, d.scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  }
  if (d.blur_px > 0) cv::GaussianBlur(image, image, {0, 0}, d.blur_px);
  if (d.contrast != 1) image.convertTo(image, -1, d.contrast, 128 * (1 - d.contrast));
  if (d.noise > 0) {
    cv::Mat wide, noise(image.size(), CV_MAKETYPE(CV_16S, image.channels()));
    random.fill(noise, cv::RNG::NORMAL, 0, d.noise);
    image.convertTo(wide, CV_16S);
    cv::Mat(wide + noise).convertTo(image, CV_8U);
  }
  if (d.jpeg_quality > 0) {
    std::vector<uchar> bytes;
    cv::imencode(".jpg", image, bytes, {cv::IMWRITE_JPEG_QUALITY, d.jpeg_quality});
    image = cv::imdecode(bytes, cv::IMREAD_UNCHANGED);
  }
  return image;
}

/// Labels of a scaled image: pixel centres move with the scale.
Json scaled_labels(Json line, double scale) {
  for (auto& e : line["ellipses"]) {
    for (const char* key : {"u", "v"}) e[key] = (e[key].get<double>() + 0.5) * scale - 0.5;
    for (const char* key : {"a", "b"}) e[key] = e[key].get<double>() * scale;
  }
  return line;
}

void copy_truth(const fs::path& from, const fs::path& to, double scale) {
  std::ifstream in(from);
  std::ofstream out(to);
  for (std::string line; std::getline(in, line);) {
    Json json = scaled_labels(Json::parse(line), scale);
    json["image"] = fs::path(json["image"].get<std::string>()).replace_extension(".png").generic_string();
    out << json.dump() << '\n';
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app("Writes degraded copies of an image folder and of its truth.jsonl.", "degrade_images");
  std::string from, to;
  std::vector<std::string> kinds;
  app.add_option("FROM", from, "Folder of images, with truth.jsonl")
      ->required()
      ->check(CLI::ExistingDirectory);
  app.add_option("TO", to, "Folder that is made: TO/KIND/...")->required();
  app.add_option("--kind", kinds,
                 "contrast (x 0.3), noise (15 levels), blur (2.5 px), jpeg (40), x2, x4, half; default all")
      ->check(CLI::IsMember({"contrast", "noise", "blur", "jpeg", "x2", "x4", "half"}));
  CLI11_PARSE(app, argc, argv);
  for (const auto& [kind, degradation] : degradations) {
    if (!kinds.empty() && std::find(kinds.begin(), kinds.end(), kind) == kinds.end()) continue;
    std::vector<fs::path> files;
    for (const auto& entry : fs::recursive_directory_iterator(from)) {
      if (entry.is_regular_file() && cv::haveImageReader(entry.path().string()))
        files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    cv::RNG random(1);
    for (std::size_t i = 0; i < files.size(); ++i) {
      if (i % 50 == 0)
        std::cerr << '\r' << kind << ": " << i << " of " << files.size() << "   " << std::flush;
      const cv::Mat image = cv::imread(files[i].string(), cv::IMREAD_ANYCOLOR);
      if (image.empty()) continue;
      fs::path out = fs::path(to) / kind / fs::relative(files[i], from);
      out.replace_extension(".png");
      fs::create_directories(out.parent_path());
      if (!cv::imwrite(out.string(), degraded(image, degradation, random))) {
        std::cerr << out << ": not written\n";
        return 2;
      }
    }
    const fs::path truth = fs::path(from) / "truth.jsonl";
    if (fs::exists(truth)) copy_truth(truth, fs::path(to) / kind / "truth.jsonl", degradation.scale);
  }
  std::cerr << '\n';
}
