#include "runtime/camera_file.hpp"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <yaml-cpp/yaml.h>

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>

namespace stevedore {
namespace {

constexpr std::array<const char*, 11> known_keys = {"image_width",       "image_height",
                                                    "camera_name",       "camera_matrix",
                                                    "distortion_model",  "distortion_coefficients",
                                                    "response",          "mount_deg",
                                                    "projection_matrix", "rectification_matrix",
                                                    "calibration"};

/// One camera file; every complaint names file, line and key.
class Reader {
 public:
  explicit Reader(const std::string& path) : path_(path) {
    try {
      root_ = YAML::LoadFile(path);
    } catch (const YAML::BadFile&) {
      throw ConfigError(path + ": can't be read");
    } catch (const YAML::ParserException& error) {
      throw ConfigError(fmt::format("{}:{}: {}", path, error.mark.line + 1, error.msg));
    }
    if (!root_.IsMap()) throw ConfigError(path + ":1: is not a camera file (ROS camera_info YAML)");
    std::set<std::string> seen;
    for (const auto& entry : root_) {
      const std::string key = entry.first.Scalar();
      if (!seen.insert(key).second) fail(entry.first, key, "stands here twice");
      if (std::find(known_keys.begin(), known_keys.end(), key) == known_keys.end())
        fail(entry.first, key,
             fmt::format("is not a key of a camera file; there are: {}", fmt::join(known_keys, ", ")));
    }
  }

  [[noreturn]] void fail(const YAML::Node& node, const std::string& key, const std::string& why) const {
    const YAML::Mark mark = node.IsDefined() ? node.Mark() : YAML::Mark::null_mark();
    const std::string where = mark.is_null() ? path_ : fmt::format("{}:{}", path_, mark.line + 1);
    throw ConfigError(fmt::format("{}: {}: {}", where, key, why));
  }

  [[nodiscard]] YAML::Node optional(const std::string& key) const {
    const YAML::Node& root = root_;  // a constant node adds nothing
    return root[key];
  }

  [[nodiscard]] YAML::Node required(const std::string& key, const std::string& expected) const {
    const YAML::Node node = optional(key);
    if (!node || node.IsNull()) fail(node, key, "is missing; expected " + expected);
    return node;
  }

  [[nodiscard]] double number(const YAML::Node& node, const std::string& key, double lowest,
                              double highest) const {
    double value = 0;
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, value) ||
        !(value >= lowest && value <= highest))
      fail(node, key, fmt::format("expected a number from {} to {}", lowest, highest));
    return value;
  }

  [[nodiscard]] int pixels(const std::string& key) const {
    constexpr int largest = 16384;  // of any camera; keeps products of sizes within int
    const YAML::Node node = required(key, "a number of pixels");
    int value = 0;
    if (!node.IsScalar() || !YAML::convert<int>::decode(node, value) || value < 1 || value > largest)
      fail(node, key, fmt::format("expected a whole number of pixels from 1 to {}", largest));
    return value;
  }

  /// {rows, cols, data}; any size with rows = 0.
  [[nodiscard]] std::vector<double> matrix(const std::string& key, int rows, int cols) const {
    const std::string expected =
        rows ? fmt::format("rows: {}, cols: {}, data: [{} numbers]", rows, cols, rows * cols)
             : std::string("rows, cols and data: [numbers]");
    const YAML::Node node = required(key, expected);
    if (!node.IsMap() || !node["data"] || !node["data"].IsSequence()) fail(node, key, "expected " + expected);
    const YAML::Node data = node["data"];
    const int stated_rows = dimension(node, key, "rows"), stated_cols = dimension(node, key, "cols");
    if ((rows && (stated_rows != rows || stated_cols != cols)) ||
        data.size() != static_cast<std::size_t>(stated_rows * stated_cols))
      fail(node, key,
           fmt::format("is {} x {} with {} numbers; expected {}", stated_rows, stated_cols, data.size(),
                       expected));
    std::vector<double> values;
    for (const YAML::Node& value : data) values.push_back(number(value, key + ".data", -1e6, 1e6));
    return values;
  }

 private:
  [[nodiscard]] int dimension(const YAML::Node& node, const std::string& key, const char* name) const {
    int value = 0;
    if (!node[name] || !YAML::convert<int>::decode(node[name], value) || value < 0 || value > 64)
      fail(node, key, fmt::format("expected {}: a small whole number", name));
    return value;
  }

  std::string path_;
  YAML::Node root_;
};

/// From a 3 x 3 camera matrix or a 3 x 4 projection matrix of a single camera.
Pinhole pinhole(const Reader& reader, const std::string& key, int cols, int width_px, int height_px) {
  const std::vector<double> data = reader.matrix(key, 3, cols);
  const Eigen::Map<const Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::RowMajor>> m(data.data(), 3, cols);
  const Pinhole out{width_px, height_px, m(0, 0), m(1, 1), m(0, 2), m(1, 2)};
  if (!(out.fx_px > 0 && out.fy_px > 0))
    reader.fail(reader.optional(key), key,
                "the focal lengths, the first and the middle number of the diagonal, must be positive");
  if (m.leftCols<3>() != out.matrix() || (cols == 4 && !m.col(3).isZero(0)))
    reader.fail(reader.optional(key), key,
                "expected fx 0 cx / 0 fy cy / 0 0 1, without skew, of a single camera");
  return out;
}

struct Lens {
  const char* name;
  Distortion distortion;
  std::size_t coefficients;
  const char* expected;
};

constexpr std::array<Lens, 3> lenses = {
    {{"none", Distortion::none, 0, "no numbers"},
     {"plumb_bob", Distortion::plumb_bob, 5, "5 numbers: k1, k2, p1, p2, k3"},
     {"equidistant", Distortion::equidistant, 4, "4 numbers: k1, k2, k3, k4"}}};

void read_lens(const Reader& reader, CameraModel& camera) {
  const std::string names = "plumb_bob, equidistant or none";
  const YAML::Node model = reader.required("distortion_model", names);
  const auto lens = std::find_if(lenses.begin(), lenses.end(),
                                 [&](const Lens& l) { return model.IsScalar() && model.Scalar() == l.name; });
  if (lens == lenses.end()) reader.fail(model, "distortion_model", "expected " + names);
  if (lens->coefficients == 0 && !reader.optional("distortion_coefficients")) return;
  camera.coefficients = reader.matrix("distortion_coefficients", 0, 0);
  if (camera.coefficients.size() != lens->coefficients)
    reader.fail(
        reader.optional("distortion_coefficients"), "distortion_coefficients",
        fmt::format("{} has {}; there are {}", lens->name, lens->expected, camera.coefficients.size()));
  camera.distortion = lens->distortion;
  // an equidistant lens bends the image even with all its coefficients zero
  const bool all_zero =
      std::all_of(camera.coefficients.begin(), camera.coefficients.end(), [](double k) { return k == 0; });
  if (lens->distortion == Distortion::plumb_bob && all_zero) {
    camera.distortion = Distortion::none;
    camera.coefficients.clear();
  }
}

Response read_response(const Reader& reader, std::vector<std::string>& warnings, const std::string& path) {
  const YAML::Node node = reader.optional("response");
  if (!node) {
    warnings.push_back(path + ": response: is missing; srgb is assumed (linear, srgb, or a gamma)");
    return {};
  }
  if (node.IsScalar() && node.Scalar() == "linear") return {Response::Curve::linear, 1};
  if (node.IsScalar() && node.Scalar() == "srgb") return {Response::Curve::srgb, 1};
  double gamma = 0;
  if (!node.IsScalar() || !YAML::convert<double>::decode(node, gamma) || !(gamma >= 0.2 && gamma <= 5))
    reader.fail(node, "response", "expected linear, srgb, or a gamma from 0.2 to 5");
  return {Response::Curve::gamma, gamma};
}

CameraMount read_mount(const Reader& reader) {
  CameraMount mount;
  const YAML::Node node = reader.optional("mount_deg");
  if (!node) return mount;
  if (!node.IsMap()) reader.fail(node, "mount_deg", "expected {roll: , pitch: , yaw: } in degrees");
  for (const auto& entry : node) {
    const std::string key = entry.first.Scalar();
    double* const angle = key == "roll"    ? &mount.roll_rad
                          : key == "pitch" ? &mount.pitch_rad
                          : key == "yaw"   ? &mount.yaw_rad
                                           : nullptr;
    if (!angle) reader.fail(entry.first, "mount_deg." + key, "is not one of: roll, pitch, yaw");
    *angle = reader.number(entry.second, "mount_deg." + key, -180, 180) * std::numbers::pi / 180;
  }
  return mount;
}

}  // namespace

CameraFile load_camera_file(const std::string& path) {
  const Reader reader(path);
  CameraFile file;
  CameraModel& camera = file.camera;
  const int width_px = reader.pixels("image_width"), height_px = reader.pixels("image_height");
  camera.given = pinhole(reader, "camera_matrix", 3, width_px, height_px);
  read_lens(reader, camera);
  camera.rectified = reader.optional("projection_matrix")
                         ? pinhole(reader, "projection_matrix", 4, width_px, height_px)
                         : camera.given;
  if (const YAML::Node rotation = reader.optional("rectification_matrix")) {
    if (reader.matrix("rectification_matrix", 3, 3) != std::vector<double>{1, 0, 0, 0, 1, 0, 0, 0, 1})
      reader.fail(rotation, "rectification_matrix",
                  "expected the identity: this is one camera, not a stereo pair");
  }
  camera.response = read_response(reader, file.warnings, path);
  camera.mount = read_mount(reader);
  return file;
}

std::optional<CameraModel> camera_of(const Config& config) {
  const std::string path = config.camera_file();
  if (path.empty()) return std::nullopt;
  const CameraFile file = load_camera_file(path);
  for (const std::string& warning : file.warnings) spdlog::warn("{}", warning);
  return file.camera;
}

}  // namespace stevedore
