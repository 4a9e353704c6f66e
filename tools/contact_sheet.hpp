// Many small pictures on one.
#pragma once

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace stevedore {

/// The picture with the truth of its line of truth.jsonl drawn on: circles cyan, dashed where they are not
/// whole, occupied ones green, cargoes yellow.
cv::Mat with_truth(const cv::Mat& picture, const nlohmann::ordered_json& truth);

/// Side by side in `columns`, each scaled to the width.
cv::Mat contact_sheet(const std::vector<cv::Mat>& pictures, int columns, int width_px);

/// As JPEG of at most that many bytes: the best quality that fits. Throws std::runtime_error if not written.
void write_jpeg(const std::string& path, const cv::Mat& picture, size_t most_bytes);

}  // namespace stevedore
