// Runs the program `locate` and reads what it prints, as its users' scripts do.
#include <catch2/catch.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <numbers>
#include <opencv2/imgcodecs.hpp>
#include <sstream>

#include "tests/support/measured_circle.hpp"
#include "tests/support/program.hpp"
#include "tests/unit/detector_scene.hpp"

using namespace stevedore;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

struct Run {
  int status = -1;
  std::vector<json> lines;
};

/// What the program prints to standard output; every line has to be a JSON object.
Run locate(const std::string& arguments) {
  const ProgramRun program = run_program("$BIN/locate " + arguments);
  Run run{program.status, {}};
  std::istringstream lines(program.out);
  for (std::string line; std::getline(lines, line);) run.lines.push_back(json::parse(line));
  return run;
}

std::vector<std::string> keys_of(const json& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.push_back(key);
  return keys;
}

/// 640x480, fx = 400: a circle of 0.5 m radius, 2 m away and face on, is one of 100 px.
std::string write_circle(const Folder& folder, const std::string& name, double u, double v) {
  cv::Mat image = grey_image(640, 480, 60);
  paint(image, {u, v, 100, 100, 0}, cv::Scalar::all(220));
  cv::imwrite(folder.file(name), image);
  return folder.file(name);
}

std::string write_camera(const Folder& folder, const std::string& coefficients) {
  std::ofstream(folder.file("camera.yaml"))
      << "image_width: 640\nimage_height: 480\ncamera_name: test\n"
         "camera_matrix: {rows: 3, cols: 3, data: [400, 0, 319.5, 0, 400, 239.5, 0, 0, 1]}\n"
         "distortion_model: plumb_bob\n"
         "distortion_coefficients: {rows: 1, cols: 5, data: ["
      << coefficients
      << "]}\n"
         "rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}\n"
         "projection_matrix: {rows: 3, cols: 4, data: [400, 0, 319.5, 0, 0, 400, 239.5, 0, 0, 0, 1, 0]}\n"
         "response: linear\n";
  return folder.file("camera.yaml");
}

}  // namespace

TEST_CASE("one line an image, in order, with the keys of the contract") {
  const Folder folder;
  const auto a = write_circle(folder, "a.png", 300, 240), b = write_circle(folder, "b.png", 330, 250);
  const Run run = locate(b + " " + a);
  CHECK(run.status == 0);
  REQUIRE(run.lines.size() == 2);
  CHECK(run.lines[0]["image"] == b);
  const json& line = run.lines[1];
  CHECK(line["image"] == a);
  CHECK(line["width"] == 640);
  CHECK(line["height"] == 480);
  CHECK(line["detect_ms"].get<double>() > 0);
  CHECK(keys_of(line) == std::vector<std::string>{"detect_ms", "ellipses", "height", "image", "width"});
  REQUIRE(line["ellipses"].size() == 1);
  const json& e = line["ellipses"][0];
  CHECK(keys_of(e) == std::vector<std::string>{"a", "alpha", "b", "circle", "coverage", "error", "kind",
                                               "label", "occupied", "u", "v"});
  CHECK(e["u"].get<double>() == Approx(300).margin(0.2));
  CHECK(e["v"].get<double>() == Approx(240).margin(0.2));
  CHECK(e["a"].get<double>() == Approx(100).margin(0.3));
  CHECK(e["a"].get<double>() >= e["b"].get<double>());
  CHECK(e["kind"] == "whole");
  CHECK(e["label"] == "circle");
  CHECK(e["occupied"] == false);
  CHECK(e["circle"].is_null());
}

TEST_CASE("an image that can't be read is a line with an error, the rest goes on, exit status 1") {
  const Folder folder;
  const auto good = write_circle(folder, "good.png", 300, 240);
  std::ofstream(folder.file("text.png")) << "no image";
  std::ofstream(folder.file("empty.png"));
  std::ofstream(folder.file("broken.png"), std::ios::binary) << text_of(good).substr(0, 60);
  const std::vector<std::pair<std::string, std::string>> bad = {
      {"missing.png", "No such file or directory"},
      {"", "is a folder, not an image"},
      {"text.png", "not an image of a format that can be read"},
      {"empty.png", "an empty file"},
      {"broken.png", "a damaged image"}};
  std::string arguments;
  for (const auto& [name, why] : bad) arguments += folder.file(name) + " ";
  const Run run = locate(arguments + good);
  CHECK(run.status == 1);
  REQUIRE(run.lines.size() == bad.size() + 1);
  for (std::size_t i = 0; i < bad.size(); ++i) {
    CHECK(keys_of(run.lines[i]) == std::vector<std::string>{"error", "image"});
    CHECK(run.lines[i]["error"] == bad[i].second);
  }
  CHECK(run.lines.back()["ellipses"].size() == 1);
}

TEST_CASE("with a camera and a radius circles have a pose") {
  const Folder folder;
  const auto image = write_circle(folder, "a.png", 319.5, 239.5);
  const auto camera = write_camera(folder, "0, 0, 0, 0, 0");
  CHECK(locate("--camera " + camera + " " + image).lines[0]["ellipses"][0]["circle"].is_null());
  CHECK(locate("--radius 0.5 " + image).lines[0]["ellipses"][0]["circle"].is_null());
  CHECK(locate("--cargo-radius 0.5 --camera " + camera + " " + image)
            .lines[0]["ellipses"][0]["circle"]
            .is_null());
  for (const std::string method : {"conic", "four_point"}) {
    const Run run =
        locate("--camera " + camera + " --radius 0.5 --gravity 0,0,1 --method " + method + " " + image);
    CHECK(run.status == 0);
    const json& circle = run.lines[0]["ellipses"][0]["circle"];
    REQUIRE(circle.is_object());
    CHECK(
        locate("--camera " + camera + " --radius 0.5 --gravity 0,0,1 " + image + " " + image).lines.size() ==
        2);
    CHECK(circle["center"][0].get<double>() == Approx(0).margin(0.005));
    CHECK(circle["center"][1].get<double>() == Approx(0).margin(0.005));
    CHECK(circle["center"][2].get<double>() == Approx(2).margin(0.02));
    CHECK(circle["normal"][2].get<double>() < -0.98);
    CHECK(circle["covariance"].size() == 9);
    CHECK(circle["probability"].get<double>() <= 1);
    CHECK(circle["alternative"].is_object() == (method == "conic"));
  }
}

TEST_CASE("outlines are in pixels of the image as given, also with a lens that bends them") {
  const Folder folder;
  const auto image = write_circle(folder, "a.png", 450, 300);
  const auto camera = write_camera(folder, "-0.2, 0.05, 0, 0, 0");
  const Run run =
      locate("--camera " + camera + " --radius 0.5 --overlay " + folder.file("new") + " " + image);
  REQUIRE(run.lines[0]["ellipses"].size() == 1);
  const json& e = run.lines[0]["ellipses"][0];
  CHECK(e["u"].get<double>() == Approx(450).margin(0.5));
  CHECK(e["v"].get<double>() == Approx(300).margin(0.5));
  CHECK(e["a"].get<double>() == Approx(100).margin(1.5));
  CHECK(e["circle"].is_object());
  CHECK(std::distance(fs::directory_iterator(folder.file("new")), {}) == 1);
}

TEST_CASE("an image of another size than the camera's is an error of that image") {
  const Folder folder;
  cv::imwrite(folder.file("small.png"), grey_image(320, 240, 60));
  const Run run =
      locate("--camera " + write_camera(folder, "0, 0, 0, 0, 0") + " " + folder.file("small.png"));
  CHECK(run.status == 1);
  CHECK(run.lines[0].contains("error"));
}

TEST_CASE("a target is searched, taken up, followed, and predicted while it is hidden") {
  const Folder folder;
  cv::imwrite(folder.file("empty.png"), grey_image(640, 480, 60));
  const std::string empty = folder.file("empty.png");
  std::string images = empty;
  for (int i = 0; i < 4; ++i)
    images.append(" ").append(write_circle(folder, std::to_string(i) + ".png", 300 + 4 * i, 240));
  for (const std::string track : {"first", "380,240"}) {
    const Run run = locate("--track " + track + " " + images + " " + empty);
    REQUIRE(run.lines.size() == 6);
    CHECK(run.lines[0]["target"]["status"] == "searching");
    CHECK(run.lines[0]["target"]["u"].is_null());
    for (std::size_t i = 1; i < 5; ++i) {
      const json& target = run.lines[i]["target"];
      CHECK(target["status"] == "tracking");
      CHECK(target["id"] == run.lines[1]["target"]["id"]);
      CHECK(target["u"].get<double>() == Approx(296 + 4 * static_cast<double>(i)).margin(0.3));
    }
    CHECK(run.lines[5]["target"]["status"] == "predicted");
    CHECK(run.lines[5]["ellipses"].empty());
  }
  CHECK_FALSE(locate(empty).lines[0].contains("target"));
}

TEST_CASE("a target that is seen has the pose of its ellipse, which is solved with the others") {
  const Folder folder;
  cv::Mat image = grey_image(640, 480, 60);
  const double lean_rad = 15 * std::numbers::pi / 180;
  const Eigen::Vector3d normal(std::sin(lean_rad), 0, -std::cos(lean_rad));
  for (const double x_m : {-1.2, 0.0, 1.2})
    for (const double y_m : {-1.0, 1.0}) {
      const Circle circle{{x_m, y_m, 4 + x_m * std::tan(lean_rad)}, normal, 0.5};
      paint(image, *image_of({640, 480, 400, 400, 319.5, 239.5}, circle), cv::Scalar::all(220));
    }
  cv::imwrite(folder.file("a.png"), image);
  const std::string a = folder.file("a.png"), camera = write_camera(folder, "0, 0, 0, 0, 0");
  const Run run = locate("--camera " + camera + " --radius 0.5 --track 320,140 " + a + " " + a);
  REQUIRE(run.lines.size() == 2);
  for (const json& line : run.lines) {
    REQUIRE(line["target"]["status"] == "tracking");
    const auto& ellipses = line["ellipses"];
    const auto same = std::find_if(ellipses.begin(), ellipses.end(), [&](const json& e) {
      return e["u"] == line["target"]["u"] && e["v"] == line["target"]["v"];
    });
    REQUIRE(same != ellipses.end());
    REQUIRE(line["target"]["circle"].is_object());
    CHECK(line["target"]["circle"] == (*same)["circle"]);
  }
}

TEST_CASE("mistakes of usage print nothing and exit with status 2") {
  const Folder folder;
  const auto image = write_circle(folder, "a.png", 300, 240);
  std::ofstream(folder.file("bad.yaml")) << "detector: {no_such_key: 1}\n";
  for (const std::string& arguments :
       {std::string(), "--radius -1 " + image, "--radius nan " + image, "--radius inf " + image,
        "--cargo-radius nan " + image, "--gravity 0,0 " + image, "--gravity 0,0,0 " + image,
        "--track 3 " + image, "--track 3,4x " + image, "--method best " + image,
        "--camera " + folder.file("missing.yaml") + " " + image,
        "--config " + folder.file("bad.yaml") + " " + image}) {
    INFO(arguments);
    const Run run = locate(arguments);
    CHECK(run.status == 2);
    CHECK(run.lines.empty());
  }
}

TEST_CASE("the configuration's detector section is used") {
  const Folder folder;
  const auto image = write_circle(folder, "a.png", 300, 240);
  std::ofstream(folder.file("blind.yaml")) << "detector: {min_semi_minor_px: 200}\n";
  CHECK(locate("--config " + folder.file("blind.yaml") + " " + image).lines[0]["ellipses"].empty());
}
