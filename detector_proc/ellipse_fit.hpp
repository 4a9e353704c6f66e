// Step 3 and 4 of Algorithm 1 for one set of points: the fit, its error, its support and its covariance.
#pragma once

#include <opencv2/core/types.hpp>
#include <optional>
#include <vector>

#include "geometry/ellipse.hpp"

namespace stevedore {

/// The ellipse drawn in a RotatedRect. In OpenCV 4.6 `angle` is the clockwise angle, in degrees, from the
/// u-axis to the side `size.width`, which fitEllipse makes the shorter one; so alpha is angle + 90 degrees
/// there. (The paper's theta, the angle of the minor axis, is the same thing; its interval [135, 315) is
/// not: 4.6 returns [0, 180).)
Ellipse ellipse_from_rotated_rect(const cv::RotatedRect& rect);

/// Least-squares ellipse of at least six points; nothing if they give no real, finite one.
std::optional<Ellipse> fit_ellipse(const std::vector<cv::Point>& points);

/// Eq. (4): mean of |left-hand side - 1| over the points.
double algebraic_error(const Ellipse& ellipse, const std::vector<cv::Point>& points);

/// Signed distance from the ellipse, outside positive, to first order (Sampson 1982). Exact near the ellipse.
double distance_px(const Ellipse& ellipse, const Eigen::Vector2d& point_px);

/// Share of the perimeter, by length, that has a point within max_distance_px.
double coverage(const Ellipse& ellipse, const std::vector<cv::Point>& points, double max_distance_px);

/// Covariance of the five parameters fitted to these points, from their residuals.
EllipseCovariance fit_covariance(const Ellipse& ellipse, const std::vector<cv::Point>& points,
                                 double correlation_length_px);

}  // namespace stevedore
