// Between the image as given and the ideal pinhole image: maps for whole images, functions for points and
// outlines.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core.hpp>
#include <optional>

#include "geometry/camera_model.hpp"
#include "geometry/ellipse.hpp"

namespace stevedore {

/// For cv::remap. Both are empty when nothing is to be done: no distortion and the same intrinsics.
struct RectifyMaps {
  cv::Mat map_1;
  cv::Mat map_2;
  cv::Size given_size;  ///< of the images that they are for
};

RectifyMaps make_rectify_maps(const CameraModel& camera);

/// The image, of the size the camera gives, as the rectified pinhole would have taken it; black where the
/// lens did not look. Returns the image itself, not a copy, when the maps are empty.
cv::Mat rectify(const cv::Mat& given, const RectifyMaps& maps);

/// Pixel of the rectified image to pixel of the image as given.
Eigen::Vector2d distort(const CameraModel& camera, const Eigen::Vector2d& rectified_px);

/// The way back, iterated to 1e-9 px. Nothing where the lens model has no inverse.
std::optional<Eigen::Vector2d> undistort(const CameraModel& camera, const Eigen::Vector2d& given_px);

/// The ellipse of the image as given that fits the distorted outline best. Nothing where it is not an
/// ellipse.
std::optional<Ellipse> distort(const CameraModel& camera, const Ellipse& rectified);

/// Pixel to pixel; nothing where it goes nowhere.
using PixelMap = std::function<std::optional<Eigen::Vector2d>(const Eigen::Vector2d&)>;

/// The ellipse that fits an ellipse's outline best after a map has bent it a little. Points that the map
/// takes nowhere are left out; nothing where fewer than a quarter remain or where the rest is not an ellipse.
std::optional<Ellipse> bent(const Ellipse& ellipse, const PixelMap& map);

}  // namespace stevedore
