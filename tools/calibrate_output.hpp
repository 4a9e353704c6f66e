// What a calibration leaves: the camera file, and a picture of where the corners were and how they are
// missed.
#pragma once

#include <string>
#include <vector>

#include "tools/calibrate_fit.hpp"

namespace stevedore {

/// A camera file with a key `calibration`: date, views, corners, rms, sigmas, covariance, and what was
/// missing.
std::string calibrated_yaml(const Fit& fit, const std::string& name, const std::string& date,
                            const std::vector<std::string>& missing);

/// Left: the corners, a colour a view, and the regions that are to be covered. Right: the residuals,
/// enlarged.
cv::Mat calibration_picture(const Fit& fit);

}  // namespace stevedore
