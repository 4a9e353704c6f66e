// What locate writes about one image: a line of JSON and an overlay.
#pragma once

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>

#include "tools/locate_frame.hpp"

namespace stevedore {

/// The object of one image, keys in the order of the contract.
nlohmann::ordered_json located_json(const std::string& image, cv::Size size, const LocatedFrame& frame);
nlohmann::ordered_json error_json(const std::string& image, const std::string& error);

/// The image with its marks in the colours of the paper's Fig. 7; partial ellipses are dashed.
cv::Mat overlay_of(const cv::Mat& image, const LocatedFrame& frame);

}  // namespace stevedore
