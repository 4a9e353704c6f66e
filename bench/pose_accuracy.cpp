// How exact poses are: Table 1's positions with tilts, rendered, found and solved as locate does, against the
// truth and the Cramer-Rao bound of the same render.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <iostream>
#include <opencv2/imgproc.hpp>

#include "geometry/lens.hpp"
#include "tests/support/measured_circle.hpp"
#include "tools/locate_frame.hpp"

using namespace stevedore;

namespace {

constexpr double deg = std::numbers::pi / 180;
constexpr double paint = 200, ground = 50, blur_px = 0.7, noise_levels = 5;
constexpr double inner_radius_m = 0.4, outer_radius_m = 0.5;

struct Options {
  bool ring = false, distorted = false;
  bool straighten = false;  ///< the outline found in the image as given, instead of the image before
  double hidden_share = 0;
  int seeds = 20;
};

/// Circle centres of the paper's Table 1, camera frame.
const std::vector<Eigen::Vector3d> positions_m{
    {-0.566, 0.074, 1.566}, {-0.278, 0.160, 2.361}, {0.644, 0.507, 4.120}, {1.044, 0.253, 5.194}};

CameraModel camera_of(const Options& o) {
  CameraModel camera;
  camera.rectified = {640, 480, 337, 337, 319.5, 239.5};
  camera.given = camera.rectified;
  if (o.distorted) {  // barrel, as of a lens of this field of view
    camera.given = {640, 480, 377, 376.4, 321.3, 238.2};
    camera.distortion = Distortion::plumb_bob;
    camera.coefficients = {-0.2, 0.04, 0.0006, -0.0004, 0};
  }
  camera.response = {Response::Curve::linear, 1};
  return camera;
}

/// Share of a pixel that is painted, from 16 x 16 points in it.
double coverage(const CameraModel& camera, const std::vector<Ellipse>& edges, int u, int v) {
  constexpr int side = 16;
  Eigen::Matrix2Xd points(2, side * side);
  for (int i = 0; i < side * side; ++i)
    points.col(i) << u + (i % side + 0.5) / side - 0.5, v + (i / side + 0.5) / side - 0.5;
  if (camera.distortion != Distortion::none) points = undistort_points(camera, points).point_px;
  int inside = 0;
  for (int i = 0; i < side * side; ++i) {
    bool painted = normalized_radius_squared(edges[0], points.col(i)) < 1;
    if (edges.size() > 1) painted = painted && normalized_radius_squared(edges[1], points.col(i)) > 1;
    inside += painted;
  }
  return static_cast<double>(inside) / (side * side);
}

bool all_of_pixel_alike(const CameraModel& camera, const std::vector<Ellipse>& edges, int u, int v) {
  const Eigen::Vector2d given(u, v);
  const Eigen::Vector2d ideal = camera.distortion == Distortion::none ? given : *undistort(camera, given);
  for (const Ellipse& e : edges)
    if (std::abs(std::sqrt(normalized_radius_squared(e, ideal)) - 1) * e.a_px < 2.5) return false;
  return true;
}

/// Without noise, linear response.
cv::Mat render(const CameraModel& camera, const std::vector<Ellipse>& edges) {
  cv::Mat image(camera.given.height_px, camera.given.width_px, CV_32F);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) {
      double share = 0;
      if (!all_of_pixel_alike(camera, edges, u, v)) {
        share = coverage(camera, edges, u, v);
      } else {
        const Eigen::Vector2d given(u, v);
        const Eigen::Vector2d ideal =
            camera.distortion == Distortion::none ? given : *undistort(camera, given);
        share = normalized_radius_squared(edges[0], ideal) < 1 &&
                (edges.size() == 1 || normalized_radius_squared(edges[1], ideal) > 1);
      }
      image.at<float>(v, u) = static_cast<float>(ground + (paint - ground) * share);
    }
  cv::GaussianBlur(image, image, {0, 0}, blur_px);
  return image;
}

/// Hides this share of the outline, from one side, behind what is as dark as the ground.
void hide(cv::Mat& image, const Ellipse& e, double share, std::mt19937& random) {
  if (share <= 0) return;
  // a chord at this height cuts the share of a circle's outline off
  const double height = std::cos(std::numbers::pi * share);
  const double turn = std::uniform_real_distribution<double>(0, 2 * std::numbers::pi)(random);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u) {
      const double x = (u - e.u_px) / e.a_px, y = (v - e.v_px) / e.a_px;
      if (x * std::cos(turn) + y * std::sin(turn) > height && x * x + y * y < 4)
        image.at<float>(v, u) = static_cast<float>(ground);
    }
}

cv::Mat with_noise(const cv::Mat& clean, std::mt19937& random) {
  cv::Mat noise(clean.size(), CV_32F), out;
  cv::RNG generator(random());
  generator.fill(noise, cv::RNG::NORMAL, 0, noise_levels);
  cv::Mat(clean + noise).convertTo(out, CV_8U);
  return out;
}

/// An edge fit that uses everything the image holds. Along a blurred step of this contrast a pixel of outline
/// places the edge within sigma_n sqrt(2 sqrt(pi) s) / contrast, s being the blur with the pixel's own width.
EllipseFit best_fit(const Ellipse& edge) {
  const double width_px = std::sqrt(blur_px * blur_px + 1.0 / 12);
  const double sigma_px =
      noise_levels * std::sqrt(2 * std::sqrt(std::numbers::pi) * width_px) / (paint - ground);
  const int count = static_cast<int>(perimeter_px(edge));
  std::vector<Eigen::Vector2d> points;
  Ellipse round = edge;
  if (round.a_px - round.b_px < 1e-3) round.b_px = round.a_px - 1e-3;  // alpha has a meaning only then
  double length = 0;
  for (double t = 0; t < 2 * std::numbers::pi; t += 0.1 / edge.a_px) {  // a point each pixel of outline
    const Eigen::Vector2d p = point_at(round, t), next = point_at(round, t + 0.1 / edge.a_px);
    if (static_cast<int>(length) == static_cast<int>(points.size()) &&
        static_cast<int>(points.size()) < count)
      points.push_back(p);
    length += (next - p).norm();
  }
  return *fitted(points, round, sigma_px);
}

struct Case {
  Circle circle;
  std::vector<Ellipse> edges;
  double theta_rad, bound_m;
};

Case case_of(const Options& o, const Eigen::Vector3d& center_m, double tilt_deg, double azimuth_deg) {
  const Pinhole pinhole = camera_of(o).rectified;
  const Eigen::Vector2d at = pinhole.project(center_m);
  Case c{circle_at(pinhole, at.x(), at.y(), center_m.z(), tilt_deg * deg, azimuth_deg * deg, outer_radius_m),
         {},
         0,
         0};
  c.theta_rad = std::acos(-c.circle.normal.dot(center_m.normalized()));
  c.edges.push_back(*image_of(pinhole, c.circle));
  MarkImage mark{best_fit(c.edges[0]), {}, Label::circle, {}};
  if (o.ring) {
    Circle inner = c.circle;
    inner.radius_m = inner_radius_m;
    c.edges.push_back(*image_of(pinhole, inner));
    mark.inner = best_fit(c.edges[1]);
  }
  PoseSettings settings;
  settings.circle_radius_m = outer_radius_m;
  const auto pose = estimate_pose(mark, pinhole, {Gravity{-c.circle.normal, 0}, {}}, settings);
  c.bound_m = std::sqrt(pose.solutions.at(0).circle.covariance_m2.trace());
  return c;
}

struct Row {
  std::vector<double> range_error_m, center_error_m, bound_m;
  int renders = 0, found = 0, wrong = 0, wrong_from_4_deg = 0, from_4_deg = 0, surely_wrong = 0;

  void add(const Case& c, const LocatedFrame& frame) {
    ++renders;
    const CirclePose* pose = nullptr;  // of the circle; what else was found is none
    for (const LocatedMark& mark : frame.marks)
      if (mark.pose.solutions.size() == 2 &&
          (mark.pose.solutions[0].circle.center_camera_m - c.circle.center_m).norm() < outer_radius_m)
        pose = &mark.pose;
    if (!pose) return;
    ++found;
    from_4_deg += c.theta_rad >= 4 * deg;
    const auto off = [&](std::size_t i) {
      return (pose->solutions[i].circle.normal_camera - c.circle.normal).norm();
    };
    const std::size_t right = off(0) <= off(1) ? 0 : 1;
    wrong += right == 1;
    wrong_from_4_deg += right == 1 && c.theta_rad >= 4 * deg;
    surely_wrong += right == 1 && pose->solutions[0].probability > 0.99;
    const Eigen::Vector3d& center_m = pose->solutions[right].circle.center_camera_m;
    range_error_m.push_back(std::abs(center_m.norm() - c.circle.center_m.norm()));
    center_error_m.push_back((center_m - c.circle.center_m).norm());
    bound_m.push_back(c.bound_m);
  }
};

double median(std::vector<double> values) {
  if (values.empty()) return NAN;
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

double rms(const std::vector<double>& values) {
  double squares = 0;
  for (const double value : values) squares += value * value;
  return std::sqrt(squares / static_cast<double>(values.size()));  // NaN for none
}

/// Down, wrong by one degree in some direction.
Eigen::Vector3d wrong_gravity(const Eigen::Vector3d& down, std::mt19937& random) {
  const double azimuth = std::uniform_real_distribution<double>(0, 2 * std::numbers::pi)(random);
  const Eigen::Vector3d x = down.unitOrthogonal(), y = down.cross(x);
  return (down + std::tan(1 * deg) * (std::cos(azimuth) * x + std::sin(azimuth) * y)).normalized();
}

/// The other way to a pose through a lens: ellipses fitted to the image as given, and their outlines
/// straightened.
LocatedFrame straightened(LocateSettings settings, const CameraModel& camera, const cv::Mat& image) {
  CameraModel lens_ignored;
  lens_ignored.given = lens_ignored.rectified = camera.given;
  lens_ignored.response = camera.response;
  settings.camera = lens_ignored;
  LocatedFrame frame = Locator(settings).step(0, image);
  for (LocatedMark& mark : frame.marks) {
    const auto outer = bent(mark.detection.outer.ellipse,
                            [&](const Eigen::Vector2d& given_px) { return undistort(camera, given_px); });
    if (!outer) continue;
    mark.pose = estimate_pose({{*outer, mark.detection.outer.covariance}, {}, mark.detection.label, {}},
                              camera.rectified, {settings.gravity, {}}, settings.pose);
  }
  return frame;
}

void run_case(const Options& o, const Case& c, Row& row, std::mt19937& random) {
  const CameraModel camera = camera_of(o);
  const cv::Mat clean = render(camera, c.edges);
  for (int seed = 0; seed < o.seeds; ++seed) {
    cv::Mat image = clean.clone();
    hide(image, c.edges[0], o.hidden_share, random);
    LocateSettings settings;
    settings.camera = camera;
    settings.radius_m = outer_radius_m;
    settings.gravity = Gravity{wrong_gravity(-c.circle.normal, random), 0};
    const cv::Mat noisy = with_noise(image, random);
    row.add(c, o.straighten ? straightened(settings, camera, noisy) : Locator(settings).step(0, noisy));
  }
}

void print(const Row& row, std::size_t position, double tilt_deg) {
  const double bound = rms(row.bound_m), center = rms(row.center_error_m);
  const double worst =
      row.range_error_m.empty() ? NAN : *std::max_element(row.range_error_m.begin(), row.range_error_m.end());
  fmt::print("| {} | {:2.0f} | {}/{} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.1f} | {}/{} | {} |\n",
             static_cast<char>('a' + position), tilt_deg, row.found, row.renders,
             1e3 * median(row.range_error_m), 1e3 * worst, 1e3 * median(row.center_error_m), 1e3 * center,
             1e3 * bound, center / bound, row.wrong_from_4_deg, row.from_4_deg, row.surely_wrong);
  std::cout.flush();
}

void run(const Options& o) {
  fmt::print(
      "{}, {}, {:.0f} % hidden: contrast {:.0f}, blur {} px, noise {} grey levels, gravity 1 degree "
      "wrong\n\n",
      o.ring ? "ring" : "disc",
      o.straighten  ? "distorted lens, outlines straightened"
      : o.distorted ? "distorted lens"
                    : "ideal lens",
      100 * o.hidden_share, paint - ground, blur_px, noise_levels);
  fmt::print(
      "| position | tilt, deg | found | range error, mm: median | worst | centre error, mm: median | rms | "
      "bound, rms | rms error over bound | wrong from 4 deg | wrong above 0.99 |\n"
      "|---|---|---|---|---|---|---|---|---|---|---|\n");
  std::mt19937 random(1);
  for (std::size_t p = 0; p < positions_m.size(); ++p)
    for (const double tilt : {0.0, 5.0, 15.0, 30.0}) {
      Row row;
      for (int k = 0; k < (tilt > 0 ? 8 : 1); ++k)
        run_case(o, case_of(o, positions_m[p], tilt, 45.0 * k), row, random);
      print(row, p, tilt);
    }
}

}  // namespace

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  CLI::App app(
      "Pose errors at Table 1's positions with tilts, rendered and located, beside the Cramer-Rao bound.",
      "pose_accuracy");
  Options options;
  app.add_flag("--ring", options.ring, "a ring 0.1 m wide instead of a disc");
  auto* distorted = app.add_flag("--distorted", options.distorted, "through a barrel lens");
  app.add_flag("--straighten", options.straighten, "ellipses of the image as given, straightened")
      ->needs(distorted);
  app.add_option("--hidden", options.hidden_share, "share of the outline that is hidden")
      ->check(CLI::Range(0.0, 0.6));
  app.add_option("--seeds", options.seeds, "noise seeds a case")->check(CLI::Range(1, 1000));
  CLI11_PARSE(app, argc, argv);
  run(options);
  return 0;
}
