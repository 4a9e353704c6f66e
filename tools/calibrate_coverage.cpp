#include "tools/calibrate_coverage.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace stevedore {
namespace {

/// The outer fifth on each side. Distortion grows with the third to seventh power of the radius: measured no
/// farther out than four fifths, its last term would be guessed at the border with five times its error.
constexpr double edge_share = 0.2;

/// One could still be refused by its residual.
constexpr std::ptrdiff_t views_a_region = 2;

/// A focal length is told from a distance by how much nearer one side of the board is than the other, and its
/// error falls with the square of the tilt's sine (Zhang 2000, figure 4): at 20 degrees it is four times that
/// at 45, the best. A lens's principal point wants tilts to opposite sides, so that its error can't hide in
/// them.
constexpr double least_tilt_deg = 20;

double degrees(double rad) {
  return rad * 180 / std::numbers::pi;
}

void missing_tilts(const Fit& fit, std::vector<std::string>& missing) {
  double left = 0, right = 0, up = 0, down = 0;
  for (const FittedView& v : fit.views) {  // the normal points to the camera: z < 0
    const double across = degrees(std::atan2(-v.normal.x(), -v.normal.z()));
    const double along = degrees(std::atan2(-v.normal.y(), -v.normal.z()));
    left = std::max(left, across);
    right = std::max(right, -across);
    up = std::max(up, along);
    down = std::max(down, -along);
  }
  const std::array<std::pair<double, const char*>, 4> tilts = {{{left, "to the left (left side away)"},
                                                                {right, "to the right (right side away)"},
                                                                {up, "backwards (upper side away)"},
                                                                {down, "forwards (lower side away)"}}};
  for (const auto& [most, words] : tilts)
    if (most < least_tilt_deg)
      missing.push_back(fmt::format("nothing tilted by more than {:.0f} degrees {}", least_tilt_deg, words));
}

}  // namespace

std::vector<Region> regions(const cv::Size& image_px) {
  const double w = image_px.width, h = image_px.height;
  const std::array<double, 4> x = {0, edge_share * w, (1 - edge_share) * w, w};
  const std::array<double, 4> y = {0, edge_share * h, (1 - edge_share) * h, h};
  const std::array<const char*, 9> names = {
      "in the upper left corner", "at the upper edge", "in the upper right corner",
      "at the left edge",         "in the middle",     "at the right edge",
      "in the lower left corner", "at the lower edge", "in the lower right corner"};
  std::vector<Region> all;
  for (std::size_t i = 0; i < names.size(); ++i)
    all.push_back({names.at(i), cv::Rect2d(cv::Point2d(x.at(i % 3), y.at(i / 3)),
                                           cv::Point2d(x.at(i % 3 + 1), y.at(i / 3 + 1)))});
  return all;
}

std::vector<std::string> missing_views(const std::vector<View>& views, const Fit* fit,
                                       const cv::Size& image_px) {
  std::vector<std::string> missing;
  if (views.size() < fewest_views)
    missing.push_back(fmt::format("{} of at least {} views", views.size(), fewest_views));
  for (const Region& region : regions(image_px)) {
    const auto seen = std::count_if(views.begin(), views.end(), [&](const View& view) {
      return std::any_of(view.corners_px.begin(), view.corners_px.end(),
                         [&](const cv::Point2f& p) { return region.area_px.contains(p); });
    });
    if (seen == 0) missing.push_back("no board " + region.name);
    if (seen > 0 && seen < views_a_region) missing.push_back("only one board " + region.name);
  }
  if (fit) missing_tilts(*fit, missing);
  return missing;
}

}  // namespace stevedore
